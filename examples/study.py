"""A planning study: a bone with a bar of tissue comes down over a rod. How far does the tip of the tissue sink, and what
does the rod carry, for three plans of the bone and tissue of two stiffnesses?

Each run is a row of the table; a run that fails is a row too. Runs that were made are kept in a folder, so that the
study continues where it was when it is started again. `client=` takes a dask.distributed.Client for other machines.
"""

import pathlib
import sys

import palpate

SCENE = pathlib.Path(__file__).parent / "scenes" / "attached.json"


def plan(scene, values):
    """Changes the scene: how far the bone comes down, and how stiff the tissue is."""
    bodies = {body["name"]: body for body in scene["bodies"]}
    bodies["bone"]["motion"]["keyframes"][-1]["translate"] = [0.0, 0.0, -values["down"]]
    bodies["bar"]["material"]["young_modulus"] = values["young_modulus"]


def outcome(simulation):
    """What a planner asks of the end of a run."""
    bar = simulation.bodies["bar"].points
    rest = simulation.bodies.points_rest[bar]
    tip = rest[:, 0] > 0.159
    moved = (simulation.positions[bar] - rest)[tip].mean(axis=0)
    return {"tip_mm": 1000 * float(moved[2]), "rod_newton": -float(simulation.contact_forces[1][2])}


if __name__ == "__main__":  # without cloudpickle the worker processes import this file
    folder = sys.argv[1] if len(sys.argv) > 1 else None
    rows = palpate.sweep_rows(SCENE, {"down": [0.03, 0.05, 0.07], "young_modulus": [30e3, 60e3]}, apply=plan,
                              measure=outcome, steps=90, folder=folder)
    print("   down  young_modulus status  tip_mm  rod_newton")
    for i, row in enumerate(rows):
        print(f"{i} {row['down']:5.2f} {row['young_modulus']:14.1f} {row['status']:>6} {row['tip_mm']:7.2f} "
              f"{row['rod_newton']:11.2f}")
