"""Push a liver with an instrument: from a mesh file to a force-displacement plot and a picture of the stress.

    ./dev python examples/push.py [FOLDER of the plot and the picture]
"""

import pathlib
import sys

try:
    import matplotlib
    import pyvista  # for to_pyvista()
except ImportError as error:
    sys.exit(f"push.py: {error}; what it needs: pip install 'palpate[plot,view]'")

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import palpate

HERE = pathlib.Path(__file__).parent
FOLDER = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "results/push-python")
FOLDER.mkdir(parents=True, exist_ok=True)

points, tets = palpate.read_mesh(HERE / "push/liver.vtu")
points = 1e-3 * points  # the file is in mm
tissue = palpate.Material(young_modulus=6e3, poisson_ratio=0.45, density=1060.0, stiffness_damping=0.01)

model = palpate.Model()
model.add_body(points, tets, name="liver", material=tissue, fixed=points[:, 2] < -0.015)
tip, tip_tets = palpate.ball(radius=0.012, resolution=6)
held = palpate.Motion([palpate.Keyframe(0.0)])  # led by hand below
model.add_body(tip + [-0.02, 0.0, 0.036], tip_tets, name="instrument", motion=held)
simulation = palpate.Simulation(model, gravity=(0, 0, 0), reactions=True)

depths, forces = [0.0], [0.0]
for depth in np.linspace(0.0, 0.01, 41)[1:]:
    simulation.move_to("instrument", (0.0, 0.0, -depth))
    simulation.run(2)
    depths.append(depth)
    forces.append(simulation.contact_wrench("instrument").force[2])
simulation.run(20)

push = simulation.contact_wrench("liver")
held_by = simulation.reaction("liver")
print(f"the liver is pushed with {-push.force[2]:.2f} N and held with {held_by.force[2]:.2f} N")
contacts = simulation.acting_contacts
print(f"{sum(status != 'open' for status in contacts.status)} contacts, the strongest {contacts.normal.max():.3f} N")
pressure = simulation.tractions().pressure[simulation.bodies["liver"].triangles]
print(f"pressure under the instrument up to {pressure.max() / 1e3:.1f} kPa")
stress = simulation.tissue()
tets = simulation.bodies["liver"].tets
most = np.nanquantile(stress.von_mises[tets], 0.99)
worst = np.nanargmax(stress.von_mises[tets])
print(f"von Mises stress below {most / 1e3:.1f} kPa in 99 of 100 tets")
print(f"it is {stress.von_mises[tets][worst] / 1e3:.1f} kPa at most")
print(f"the tet with the most is compressed to {stress.volume_ratio[tets][worst]:.2f} of its volume")

figure, axes = plt.subplots(figsize=(7, 4.4))
axes.plot(1e3 * np.array(depths), forces)
axes.set(xlabel="displacement of the instrument, mm", ylabel="force, N")
axes.grid(alpha=0.3)
figure.savefig(FOLDER / "force.png", dpi=110, bbox_inches="tight")

grid = simulation.to_pyvista(["von_mises", "stress"])
grid.save(FOLDER / "liver.vtu")
print(f"force.png and liver.vtu are in {FOLDER.name}")
