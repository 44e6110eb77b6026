"""A blow-out fracture of the orbital floor in the orbit of eye.py: a label map, and plates that fit into the hole."""

import numpy as np

import eye
import plates
import volume as v

FLOOR_THICKNESS = 2.4  # mm, as the shell of eye.py
FRAGMENT = (-3.0, 8.0, 7.0, 8.5)  # centre from that of the bulb, and radii, mm: over the maxillary sinus
GAP = 1.0  # mm, between a plate and the border of the hole: the mesh of the border is rough
FLOOR = ((-16.0, 12.0), (-5.0, 22.0), -12.5)  # x, y and largest z from the centre of the bulb, mm
SMOOTH = 2.0  # mm: a CT of slices of 1.5 mm does not show smaller details of the floor


def blurred(heights, inside, reach):
    """A mean of the heights inside, with the weights of a Gaussian of this reach (in cubes)."""
    half = int(np.ceil(3.0 * reach))
    weights = np.exp(-0.5 * (np.arange(-half, half + 1) / reach) ** 2)

    def blur(values):
        for axis in (0, 1):
            padded = np.pad(values, [(half, half) if a == axis else (0, 0) for a in (0, 1)])
            values = sum(w * np.take(padded, range(i, i + values.shape[axis]), axis) for i, w in enumerate(weights))
        return values

    return blur(np.where(inside, heights, 0.0)) / np.maximum(blur(inside.astype(float)), 1e-9)


def floor_heights(ct, soft, centre):
    """Smoothed heights of the floor over the columns of cubes, and the columns where there is a floor."""
    x, y, z = (p - c for p, c in zip(v.places(ct), centre))
    lowest = np.where(soft, z, np.inf).min(axis=0) - 0.5 * ct.GetSpacing()[2]
    (x0, x1), (y0, y1), highest = FLOOR
    there = (lowest < highest) & (x[0] > x0) & (x[0] < x1) & (y[0] > y0) & (y[0] < y1)
    return blurred(lowest, there, SMOOTH / ct.GetSpacing()[0]), there, lowest


def fracture(ct, organs, centre):
    """The organs of eye.py without skin and plate, with the floor smoothed, and the piece that breaks out as an organ of its own; the
    heights of the floor over the columns of cubes, and the columns where there is a floor."""
    x, y, z = (p - c for p, c in zip(v.places(ct), centre))
    soft = {name: inside for name, inside in organs.items() if name not in ("bone", "skin", "plate", "fat")}
    taken = np.any(list(soft.values()), axis=0)
    soft["fat"] = v.largest(ct, v.opened(ct, (organs["fat"] | organs["plate"]) & ~taken, 0.8))
    heights, there, lowest = floor_heights(ct, taken | soft["fat"], centre)
    below = there[None] & (z < heights[None])
    soft = {name: inside & ~below for name, inside in soft.items()}
    soft["fat"] |= there[None] & ~below & (z < lowest[None])
    floor = v.largest(ct, below & (z >= heights[None] - FLOOR_THICKNESS))
    column = np.hypot((x - FRAGMENT[0]) / FRAGMENT[2], (y - FRAGMENT[1]) / FRAGMENT[3]) < 1.0
    fragment = v.largest(ct, floor & column)
    sinus = column & below & ~floor & (z > -40.0)  # spurs of bone there would hold what falls into the sinus
    bone = v.largest(ct, organs["bone"] & ~np.any(list(soft.values()), axis=0) & ~floor & ~sinus)
    # Dense spots in the tissue are no organ: without them it has no hollows.
    outside = v.parts(ct, ~(np.any(list(soft.values()), axis=0) | floor | bone))
    soft["fat"] |= (outside > 1) & v.grown(ct, soft["fat"], 1.0)
    return soft | {"fragment": fragment, "floor": floor & ~fragment, "bone": bone}, heights, there


def make(source, folder, write_mesh):
    """Writes label map and plates; returns the flags of `palpate mesh`. The centre of the bulb becomes the origin."""
    ct = v.cubes(v.read_inv3(source), eye.LOWER, eye.UPPER, eye.EDGE)
    organs, _, centre, _ = eye.anatomy(ct)
    labels, heights, there = fracture(ct, organs, centre)
    v.write_labels(folder / "organs.seg.nrrd", ct, labels, centre)
    floor = plates.Heights(heights, there, (np.array(ct.GetOrigin()) - centre)[:2], eye.EDGE)
    x, y, *radii = FRAGMENT
    for shape in ("bent", "flat"):
        write_mesh(folder / f"plate-{shape}.mesh", *plates.plate(floor, shape, (x, y), np.array(radii) - GAP))
    return ["--conforming", "--tets", "31000", "--rigid", "bone", "--rigid", "floor", "--rigid", "fragment", "--relation",
            "fat:floor=slides", "--relation", "fat:fragment=slides"]
