"""Makes hertz.png: the pressure under a ball that is pressed by plates, against Hertz's formula.

    ./dev python docs/pictures/hertz.py

The set-up is that of tests/sim/hertz_test.cpp.
"""

import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import palpate

RADIUS, YOUNG, POISSON, APPROACH = 0.05, 1e5, 0.3, 0.001


def graded_ball(layers):
    """A ball of radius 1, finer at both poles by a factor of five."""
    points, tets = palpate.ball(1.0, layers)
    radius = np.linalg.norm(points, axis=1)
    across = np.hypot(points[:, 0], points[:, 1])
    angle = np.arctan2(across, np.abs(points[:, 2]))
    angle *= 0.2 + 0.8 * angle / (0.5 * np.pi)
    depth = (1.0 - radius) * (0.2 + 0.8 * (1.0 - radius))
    side = np.divide(np.sin(angle), across, out=np.zeros_like(across), where=across > 0)
    direction = np.stack([side * points[:, 0], side * points[:, 1], np.copysign(np.cos(angle), points[:, 2])], axis=1)
    direction[radius == 0] = 0.0
    return (1.0 - depth)[:, None] * direction, tets


def pressed(layers):
    """The force, and place and pressure of the points on the lower side."""
    model = palpate.Model()
    plate, plate_tets = palpate.box((1, 1, 1), (0.12, 0.12, 0.02))
    for sign in (1.0, -1.0):
        displacement = palpate.Motion([palpate.Keyframe(0.0), palpate.Keyframe(0.2, (0, 0, sign * APPROACH))], interpolation="smooth")
        model.add_body(plate - [0, 0, sign * (RADIUS + 0.01)], plate_tets, motion=displacement)
    points, tets = graded_ball(layers)
    material = palpate.Material(young_modulus=YOUNG, poisson_ratio=POISSON, mass_damping=20.0, stiffness_damping=0.01)
    model.add_body(RADIUS * points, tets, material=material)
    simulation = palpate.Simulation(
        model, gravity=(0, 0, 0), rest={"speed": 2e-6, "time": 0.05}, contact={"stiffness": 10 * YOUNG * RADIUS},
        solver={"tolerance": 1e-6, "max_iterations": 2000},
    )
    simulation.run(300, until_rest=True)
    lower = np.zeros(len(simulation.positions), bool)
    lower[simulation.bodies[2].points] = True
    lower &= simulation.positions[:, 2] < -0.9 * RADIUS
    on_surface = np.zeros_like(lower)
    on_surface[simulation.bodies.triangles] = True
    lower &= on_surface
    pressure = simulation.tractions().point_pressure[lower]
    return simulation.contact_forces[1][2], np.hypot(*simulation.positions[lower, :2].T), pressure


def main():
    """Three meshes, each against Hertz at its own force."""
    figure, axes = plt.subplots(figsize=(7.2, 4.2), layout="constrained")
    for layers, color in [(6, "#bbbbbb"), (9, "#56b4e9"), (12, "#d55e00")]:
        force, place, pressure = pressed(layers)
        modulus = YOUNG / (1 - POISSON**2)
        a = np.cbrt(0.75 * force * RADIUS / modulus)
        largest = 1.5 * force / (np.pi * a**2)
        axes.plot(place / a, pressure / largest, "o", color=color, markersize=4, label=f"{20 * layers**3} tets, {force:.3f} N")
    r = np.linspace(0, 1, 300)
    axes.plot(r, np.sqrt(1 - r**2), color="black", label="Hertz")
    axes.set(xlabel="distance from the middle / contact radius", ylabel="pressure / Hertz's largest", xlim=(0, 1.6), ylim=(-0.05, 1.4))
    axes.legend()
    axes.grid(alpha=0.3)
    figure.savefig(pathlib.Path(__file__).parent / "hertz.png", dpi=110)


if __name__ == "__main__":
    main()
