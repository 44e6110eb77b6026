"""Skull, jaws and soft tissue of the face from a CT of a head: label maps."""

import re

import numpy as np

import volume as v

TISSUE_DEPTH = 16.0  # mm below the skin that the soft tissue reaches; bones and what is behind them left out


def neighbours(labels):
    """The labels of the six cubes beside each."""
    for axis in range(3):
        for step in (1, -1):
            beside = np.roll(labels, step, axis)
            edge = [slice(None)] * 3
            edge[axis] = 0 if step == 1 else -1
            beside[tuple(edge)] = 0
            yield beside


def grown_into(labels, room, steps):
    """Labels grown cube by cube into the room, all at the same pace; where two meet the lower number wins."""
    labels = labels.copy()
    for _ in range(steps):
        free = room & (labels == 0)
        found = np.zeros_like(labels)
        for beside in neighbours(labels):
            take = free & (beside > 0) & ((found == 0) | (beside < found))
            found[take] = beside[take]
        if not found.any():
            break
        labels[found > 0] = found[found > 0]
    return labels


def bones(ct, seeds, level, steps, hollow):
    """Bone above the level, shared among the seeds, with a cube of joint between different ones and hollows filled."""
    labels = grown_into(seeds, v.array(ct) > level, steps)
    out = {}
    for number in range(1, seeds.max() + 1):
        others = (labels > 0) & (labels != number)
        bone = v.closed(ct, labels == number, hollow) & ~v.grown(ct, others, 1.01 * ct.GetSpacing()[0])
        out[number] = v.opened(ct, bone, 1.6)
    return out


def soft_tissue(ct, air_level, solid, back, lowest):
    """What is neither air nor bone, from the skin to so deep, before a plane."""
    x, y, z = v.places(ct)
    outside = v.largest(ct, v.opened(ct, v.array(ct) < air_level, 4.0))
    depth = v.distance_to(v.mask(ct, outside))
    head = v.largest(ct, v.opened(ct, ~outside & (v.array(ct) >= air_level), 3.0))
    tissue = head & (depth < TISSUE_DEPTH) & ~solid & (y < back) & (z > lowest)
    return v.largest(ct, v.opened(ct, tissue, 1.6))


def write(ct, organs, origin, folder, gap, sizes):
    v.write_labels(folder / "organs.seg.nrrd", ct, organs, origin)
    flags = ["--gap", str(gap)]
    for name, size in sizes.items():
        flags += ["--size", f"{name}={size}"]
    return flags


def make_cranium(source, folder, _write_mesh):
    """The CT of InVesalius begins at the teeth of the upper jaw: of the lower jaw it holds the two rami."""
    ct = v.cubes(v.read_inv3(source), (40.0, 15.0, 0.0), (211.0, 140.0, 120.0), 1.5)
    x, y, z = v.places(ct)
    found = v.parts(ct, v.array(ct) > 600)
    # The two parts after the skull lie left and right behind the teeth.
    seeds = np.where(found == 1, 1, np.where((found == 2) | (found == 3), 2, 0)).astype(np.uint8)
    bone = bones(ct, seeds, 250, 12, 5.0)
    jaw = (z < 19.0) & (y < 92.0)  # the cut of a Le Fort I osteotomy, and behind the upper jaw
    joint = (z < 21.0) & (y < 94.0)
    organs = {"lower jaw": bone[2], "upper jaw": v.largest(ct, bone[1] & jaw), "skull": v.largest(ct, bone[1] & ~joint & (y < 125.0))}
    solid = np.any(list(organs.values()), axis=0) | (bone[1] & joint)
    organs["soft tissue"] = soft_tissue(ct, -250, v.closed(ct, solid, 6.0), 120.0, 0.0)
    return write(ct, organs, (125.0, 95.0, 40.0), folder, 1.2, SIZES["skull"])


def make_headsq(source, folder, _write_mesh):
    """VTK's head, from the crown down in slices of 64 x 64."""
    files = sorted(source.glob("quarter.*"), key=lambda file: -int(re.sub(r"\D", "", file.suffix)))
    image = v.read_slices(files, (64, 64), (3.2, 3.2, 1.5))
    ct = v.cubes(image, (10.0, 0.0, 0.0), (190.0, 150.0, 137.0), 1.6)
    found = v.parts(ct, v.array(ct) > 1800)
    y = v.places(ct)[1]
    # Skull, lower jaw, upper jaw; 4: vertebrae, which lie behind them. Crumbs go to whom they belong.
    seeds = np.where(found <= 3, found, np.where(y > 105.0, 4, 0)).astype(np.uint8)
    bone = bones(ct, seeds, 1300, 12, 3.0)
    organs = {"lower jaw": bone[2], "upper jaw": bone[3], "skull": bone[1]}
    solid = np.any(list(bone.values()), axis=0)
    organs["soft tissue"] = soft_tissue(ct, 600, v.closed(ct, solid, 6.0), 100.0, 0.0)
    return write(ct, organs, (100.0, 90.0, 70.0), folder, 1.5, SIZES["jaw"])


# Of the triangles, mm: found with --tets, so that the scenes have the counts of the paper's Table 1.
SIZES = {"skull": {"skull": 7.3, "upper jaw": 4.7, "lower jaw": 4.3, "soft tissue": 6.4},
         "jaw": {"skull": 6.4, "upper jaw": 5.2, "lower jaw": 5.3, "soft tissue": 6.4}}
