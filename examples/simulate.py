"""A simulation that is built in code: a plate with a prescribed motion presses a soft block, and a hook pulls at its side."""

import numpy as np

import palpate

model = palpate.Model()
points, tets = palpate.box(cells=(6, 6, 4), size=(0.06, 0.06, 0.04))
tissue = palpate.Material(young_modulus=20e3, poisson_ratio=0.45, density=1000.0, stiffness_damping=0.002)
block = model.add_body(points, tets, name="block", material=tissue, fixed=points[:, 2] < -0.0199)
model.add_region(block, points[tets].mean(axis=1)[:, 0] > 0.0, palpate.Material(young_modulus=60e3, density=1000.0))

down = palpate.Motion([palpate.Keyframe(0.0), palpate.Keyframe(0.3, translate=(0.0, 0.0, -0.012))],
                      interpolation="smooth")
plate_points, plate_tets = palpate.box(cells=(8, 8, 1), size=(0.08, 0.08, 0.01))
model.add_body(plate_points + [0.0, 0.0, 0.026], plate_tets, name="plate", motion=down)

simulation = palpate.Simulation(model, time_step=0.01, gravity=(0, 0, 0), contact={"friction": 0.3})
side = int(np.linalg.norm(points - [-0.03, 0.0, 0.0], axis=1).argmin())
hook = simulation.grab(point=side, target=points[side], stiffness=50.0)


def pull(simulation):
    """Moves the hook a little in each step."""
    hook.move(points[side] + [-0.0005 * simulation.metrics.step, 0.0, 0.0])


simulation.run(40, callback=pull)
metrics = simulation.metrics
print(f"after {metrics.time:.1f} s: {metrics.detection.contacts} contacts, "
      f"pressed by {-simulation.contact_forces[block][2]:.1f} N, pulled by {-hook.force[0]:.2f} N")
