"""A blow-out fracture of the orbital floor in the orbit of eye.py: a label map."""

import numpy as np

import eye
import volume as v

FLOOR_THICKNESS = 2.4  # mm, as the shell of eye.py
FRAGMENT = (-3.0, 8.0, 6.0, 7.0)  # centre from that of the bulb, and radii, mm: over the maxillary sinus


def fracture(ct, organs, centre):
    """The organs of eye.py without skin and plate, and the floor and the piece that breaks out as organs of their own."""
    x, y, z = v.places(ct)
    soft = {name: inside for name, inside in organs.items() if name not in ("bone", "skin", "plate", "fat")}
    taken = np.any(list(soft.values()), axis=0)
    soft["fat"] = v.largest(ct, v.opened(ct, (organs["fat"] | organs["plate"]) & ~taken, 0.8))
    lowest = np.where(taken | soft["fat"], z, np.inf).min(axis=0)[None]
    bone = organs["bone"] & ~taken & ~soft["fat"]
    dx, dy = x - centre[0], y - centre[1]
    under = (z < lowest) & (z >= lowest - FLOOR_THICKNESS - 1e-6) & (lowest < centre[2] - 11.0)
    floor = v.largest(ct, bone & under & (dx > -12.0) & (dx < 8.0) & (dy > -5.0) & (dy < 21.0))
    column = np.hypot((dx - FRAGMENT[0]) / FRAGMENT[2], (dy - FRAGMENT[1]) / FRAGMENT[3]) < 1.0
    fragment = v.largest(ct, floor & column)
    below = column & (z < lowest) & (z > centre[2] - 40.0)  # spurs of bone there would hold what falls into the sinus
    bone = v.largest(ct, bone & ~floor & ~below)
    return soft | {"fragment": fragment, "floor": floor & ~fragment, "bone": bone}


def make(source, folder, write_mesh):
    """Writes the label map; returns the flags of `palpate mesh`. The centre of the bulb becomes the origin."""
    ct = v.cubes(v.read_inv3(source), eye.LOWER, eye.UPPER, eye.EDGE)
    organs, _, centre, _ = eye.anatomy(ct)
    v.write_labels(folder / "organs.seg.nrrd", ct, fracture(ct, organs, centre), centre)
    return ["--conforming", "--tets", "30000", "--rigid", "bone", "--rigid", "floor", "--rigid", "fragment", "--relation",
            "fat:floor=slides", "--relation", "fat:fragment=slides"]
