"""Functions that studies send to other processes."""

import os
import signal


def stiffness_of(scene, values):
    """Young's modulus from a parameter with a free name."""
    for body in scene["bodies"]:
        if "material" in body:
            body["material"]["young_modulus"] = values["stiffness"]


def other_mesh(scene, values):
    """Replaces the mesh of the first body by a file."""
    del scene["bodies"][0]["box"]
    scene["bodies"][0]["mesh"] = values["bodies.block.mesh"]


def heights(simulation):
    """Mean height of the points, and of each body."""
    return {"height": float(simulation.positions[:, 2].mean()), "first": simulation.positions[:1, 2]}


def refuse(simulation):
    raise RuntimeError("measured nothing")


def die_once(scene, values):
    """Ends its process, but only the first time."""
    mark = os.path.join(values["folder"], f"died-{values['number']}")
    if values["number"] == 2 and not os.path.exists(mark):
        open(mark, "w").close()
        os.kill(os.getpid(), signal.SIGKILL)


def die_always(scene, values):
    if values["number"] == 1:
        os.kill(os.getpid(), signal.SIGKILL)
