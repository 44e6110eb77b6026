"""The musts of `palpate mesh --conforming` for an eye. Oracle: each voxel centre against each tet, in NumPy."""

import base64
import gzip
import json
import os
import pathlib
import re
import struct
import subprocess
import zlib

import numpy as np
import pytest

pytestmark = pytest.mark.skipif(not (pathlib.Path(os.environ["PALPATE_COMMAND"]).parent / "palpate-mesh").exists(),
                                reason="no palpate-mesh in this build")
NEVER_SOFT = {"bone", "plate"}


def read_nrrd(path):
    """Labels (x, y, z), origin, spacing and names by label of a NRRD file of bytes with upright axes."""
    head, data = path.read_bytes().split(b"\n\n", 1)
    fields = dict(re.findall(r"^([^:#\n]+):=?\s*(.*)$", head.decode(), re.MULTILINE))
    sizes = [int(word) for word in fields["sizes"].split()]
    assert fields["type"] in ("unsigned char", "uint8")
    data = gzip.decompress(data) if fields["encoding"].startswith("gz") else data
    vectors = [[float(x) for x in vector.split(",")] for vector in re.findall(r"\(([^)]*)\)", fields["space directions"])]
    spacing = np.diag(np.array(vectors))
    assert np.array_equal(np.diag(spacing), vectors) and fields["space"] == "left-posterior-superior"
    origin = np.array([float(x) for x in fields["space origin"].strip("()").split(",")])
    names = {int(fields[f"Segment{n}_LabelValue"]): fields[f"Segment{n}_Name"] for n in range(len(fields)) if f"Segment{n}_Name" in fields}
    return np.frombuffer(data, np.uint8, np.prod(sizes)).reshape(sizes, order="F"), origin, spacing, names


def read_vtu(path):
    """Points, tets and labels of a .vtu file with appended arrays in blocks of zlib."""
    text, appended = path.read_bytes().split(b"<AppendedData", 1)
    encoded = b'encoding="base64"' in appended[:100]
    appended = appended[appended.index(b"_") + 1:]

    def array(name):
        kind, offset = re.search(rf'<DataArray type="(\w+)" Name="{name}"[^>]*?offset="(\d+)"', text.decode()).groups()
        data = appended[int(offset):]
        if encoded:
            data = base64.b64decode(data[:data.index(b"<")])
        blocks = struct.unpack_from("<Q", data)[0]
        sizes = struct.unpack_from(f"<{blocks}Q", data, 24)
        found, at = b"", 8 * (3 + blocks)
        for size in sizes:
            found += zlib.decompress(data[at:at + size])
            at += size
        return np.frombuffer(found, np.dtype(kind.lower()))

    return array("Points").reshape(-1, 3), array("connectivity").reshape(-1, 4), array("label")


def boxes_of(tets, shape):
    """The voxels whose centres may be in each tet, given its corners in voxels: the first one, and the one beyond the last."""
    first = np.maximum(np.ceil(tets.min(axis=1)), 0).astype(int)
    return first, np.minimum(np.floor(tets.max(axis=1)) + 1, shape).astype(int)


def voxels_of(labels, tets, label_of_tet):
    """The label of the tet that contains each voxel's centre."""
    found = np.zeros_like(labels)
    inverse = np.linalg.inv(tets[:, 1:] - tets[:, :1])
    for t, (lower, upper) in enumerate(zip(*boxes_of(tets, labels.shape))):
        voxels = np.stack(np.meshgrid(*map(np.arange, lower, upper), indexing="ij"), axis=-1).reshape(-1, 3)
        weights = (voxels - tets[t, 0]) @ inverse[t]
        inside = voxels[(weights >= -1e-12).all(axis=1) & (weights.sum(axis=1) <= 1 + 1e-12)]
        found[tuple(inside.T)] = label_of_tet[t]
    return found


def least_angle(corners):
    faces = [(1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)]
    normals = np.stack([np.cross(corners[:, b] - corners[:, a], corners[:, c] - corners[:, a]) for a, b, c in faces], axis=1)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    cosines = [-np.einsum("ij,ij->i", normals[:, f], normals[:, g]) for f in range(4) for g in range(f)]
    return np.degrees(np.arccos(np.max(cosines)))


def turns_of_lines(points, tets, label_of_tet):
    """Angles in degrees between consecutive edges where three labels meet (the outside is one), at points with two such edges."""
    faces = np.sort(tets[:, [(1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2)]].reshape(-1, 3), axis=1)
    sides = {}
    for face, label in zip(map(tuple, faces), np.repeat(label_of_tet, 4)):
        sides.setdefault(face, []).append(label)
    around = {}
    for (a, b, c), labels in sides.items():
        if len(set(labels)) + (len(labels) == 1) > 1:
            for edge in ((a, b), (a, c), (b, c)):
                around.setdefault(edge, set()).update(labels if len(labels) == 2 else [labels[0], 0])
    ends = {}
    for (a, b), labels in around.items():
        if len(labels) > 2:
            ends.setdefault(a, []).append(b)
            ends.setdefault(b, []).append(a)
    at, before, after = np.array([(p, *others) for p, others in ends.items() if len(others) == 2]).T
    u, v = points[at] - points[before], points[after] - points[at]
    cosines = (u * v).sum(axis=1) / np.linalg.norm(u, axis=1) / np.linalg.norm(v, axis=1)
    return np.degrees(np.arccos(np.clip(cosines, -1, 1)))


def grown(mask):
    """With the 26 neighbours of each voxel."""
    for axis in range(3):
        padded = np.pad(mask, [(int(axis == a),) * 2 for a in range(3)])
        parts = [np.take(padded, range(k, k + mask.shape[axis]), axis) for k in range(3)]
        mask = parts[0] | parts[1] | parts[2]
    return mask


def synthetic(command, folder):
    subprocess.run([command, "generate", "eye-labels", "--out", folder / "eye.seg.nrrd"], check=True, capture_output=True)
    return folder / "eye.seg.nrrd", ["--rigid", "bone", "--relation", "slides", "--relation", "fat:bone=grown", "--relation", "skin:bone=grown"]


def from_ct(command, folder):
    found = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"]) / "build/ct/eye/organs.seg.nrrd"
    if not found.exists():
        pytest.skip("no label map of the CT: './dev run scenes/eye-ct.json --steps 1' makes it")
    return found, ["--tets", "57500", "--rigid", "bone", "--rigid", "plate", "--relation", "bulb=slides",
                   "--size", "superior rectus=1.5"]


@pytest.mark.long
@pytest.mark.parametrize("map_of", [synthetic, from_ct])
def test_the_eye_has_what_its_map_has(command, tmp_path, map_of):
    """40 to 60 thousand tets, Dice, angles, layers, interfaces; the report agrees with the oracle."""
    file, flags = map_of(command, tmp_path)
    report = json.loads(subprocess.run([command, "mesh", file, "--conforming", *flags, "--out", tmp_path / "eye", "--json", "--quiet"],
                                       check=True, capture_output=True, text=True).stdout)
    labels, origin, spacing, names = read_nrrd(file)
    points, tets, label_of_tet = read_vtu(tmp_path / "eye/tissues.vtu")
    assert 40000 <= len(tets) <= 60000 and report["tets"] == len(tets)
    assert least_angle(points[tets]) >= 8.0
    assert report["closed_fraction"] >= 0.99
    # Without edges along the lines, the medians are 57 and 64 degrees.
    assert np.median(turns_of_lines(points, tets, label_of_tet)) <= (30 if map_of is synthetic else 55)
    found = voxels_of(labels, ((points - origin) / spacing)[tets], label_of_tet)
    by_name = {tissue["name"]: tissue for tissue in report["tissues"]}
    for label, name in names.items():
        ours, theirs = found == label, labels == label
        dice = 2 * (ours & theirs).sum() / (ours.sum() + theirs.sum())
        assert dice >= (0.95 if name in NEVER_SOFT else 0.98), name
        assert dice == pytest.approx(by_name[name]["dice"], abs=1e-3)
        assert not (theirs & ~grown(ours)).any(), f"lost voxels of {name}"
    between = (labels[1:] > 0) & (labels[:-1] > 0) & (labels[1:] != labels[:-1])
    assert ((found[1:] > 0) & (found[:-1] > 0))[between].mean() >= 0.99, "a hole where tissues touch"
    subprocess.run([command, "run", tmp_path / "eye/scene.json", "--steps", "1", "--no-picture", "--quiet", "--strict", "--out", tmp_path / "out"],
                   check=True)
