"""docs/orbit.md: its commands, shortened here and in full in the long tests. Oracles: the figures of the page."""

import csv
import importlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest

import palpate

pytestmark = pytest.mark.skipif(not (pathlib.Path(os.environ["PALPATE_COMMAND"]).parent / "palpate-mesh").exists(),
                                reason="no palpate-mesh in this build")


def commands(root):
    """The lines of the page's first block that call palpate, with their continuations joined."""
    block = re.search(r"^```sh\n(.*?)^```", (root / "docs/orbit.md").read_text(), re.DOTALL | re.MULTILINE).group(1)
    return [line.split("#")[0].split() for line in block.replace("\\\n", " ").splitlines() if line.strip()]


@pytest.fixture(scope="module")
def meshes(root, command, tmp_path_factory):
    """The folder of the meshes that the page's commands make."""
    folder = tmp_path_factory.mktemp("page")
    for words in commands(root)[:3]:
        assert words[0] == "palpate"
        subprocess.run([command, *words[1:]], cwd=folder, check=True, capture_output=True)
    return folder / "orbit"


@pytest.fixture
def meshed(root, meshes):
    """The scene with these meshes."""
    scene = palpate.read_scene(root / "scenes/orbit-repair.json")
    for body in scene["bodies"]:
        body["mesh"] = str(meshes / pathlib.Path(body["mesh"]).name)
    return scene


def test_the_page_makes_the_meshes_of_the_scene(root, meshed):
    """From the label map to the first steps of the scene. The meshes are those of the repository, byte by byte."""
    kept = palpate.read_scene(root / "scenes/orbit-repair.json")
    for ours, theirs in zip(meshed["bodies"], kept["bodies"]):
        made, shipped = pathlib.Path(ours["mesh"]), root / "scenes" / theirs["mesh"]
        assert made.read_bytes() == shipped.read_bytes(), made.name  # differs with another version of CGAL
    simulation = palpate.Simulation(meshed)
    simulation.run(3)
    assert simulation.steps_not_converged == 0 and simulation.most_inverted_tets == 0
    outcomes = simulation.outcomes()
    assert abs(outcomes["globe_off"].value) < 0.05 and outcomes["herniated"].value < 10


def test_the_page_says_what_the_labels_are(root, command, tmp_path):
    for words in (["--defect", "30,5"], ["--defect-at=0,40"], ["--defect", "5"], ["--voxel", "9"]):
        refused = subprocess.run([command, "generate", "orbit-labels", *words], cwd=tmp_path, capture_output=True, text=True)
        assert refused.returncode == 2 and len(refused.stderr.strip().splitlines()) == 1, refused.stderr
    assert not list(tmp_path.iterdir())


def test_a_plate_in_bone_is_told(root, meshed):
    """The plate 3 mm too low, without the stages before it."""
    del meshed["duration"]  # of all stages
    meshed["stages"] = [stage for stage in meshed["stages"] if stage["name"] == "insert"]
    meshed["stages"][0]["until"] = {"time": 0.01}
    meshed["stages"][0]["move"][0]["motion"]["keyframes"] = [{"time": 0.01, "translate": [0, 28, 2]}]
    simulation = palpate.Simulation(meshed)
    simulation.run()
    assert any(re.match(r"stage 'insert' puts 'plate' into '(floor|bone)', by [\d.]+ mm", line) for line in simulation.stage_warnings)


@pytest.fixture(scope="module")
def repair(root, command, tmp_path_factory):
    """The folder of a run of the whole scene, and its report."""
    folder = tmp_path_factory.mktemp("repair")
    subprocess.run([command, "run", root / "scenes/orbit-repair.json", "--strict", "--no-picture", "--quiet", "--out", "out"],
                   cwd=folder, check=True)
    return folder / "out", json.loads((folder / "out/run.json").read_text())


@pytest.mark.long
def test_contacts_of_the_repair_are_at_most_2_percent_of_an_edge_deep(repair):
    run = repair[1]
    soft = next(body for body in run["bodies"] if body["name"] == "fat")
    assert run["deepest"] <= 0.02 * soft["edge_length"]["mean"]


def compare_outcomes(text, out, stages, cells):
    """Compares the tables of outcomes over stages in this text with the results of a run; there are so many cells."""
    factors = {"mm": 1, "ml": 1e-3, "mN": 1e-3, "mm²": 1}  # of mm, mm^3, uN and mm^2
    found = {outcome["name"]: outcome for outcome in json.loads((out / "outcomes.json").read_text())["outcomes"]}
    compared = 0
    for name, row in re.findall(r"^\| `(\w+)` \| (.*) \|$", text, re.MULTILINE):
        if name not in found:
            continue  # per stage
        values = {stage["stage"]: stage["value"] for stage in found[name]["stages"]}
        for stage, cell in zip(stages, row.split(" | ")):
            number, unit = cell.split()
            digits = len(number.partition(".")[2])
            assert factors[unit] * values[stage] == pytest.approx(float(number), rel=0.05, abs=min(0.011, 1.1 * 10.0**-digits)), (name, stage)
            compared += 1
    assert compared == cells


@pytest.mark.long
def test_the_whole_repair(root, repair):
    """At rest in each stage, converged, nothing inverted in any step; the page's figures."""
    out, run = repair
    assert run["solver"]["steps_not_converged"] == 0 and run["inverted_tets"]["largest"] == 0
    assert all(stage["reached"] and not stage["overlaps"] for stage in run["stages"])
    page = (root / "docs/orbit.md").read_text().split("## The same operation in a CT")[0]
    compare_outcomes(page, out, ("intact", "fracture", "retract", "release"), 28)


@pytest.mark.long
def test_the_study_ranks_plans(root, tmp_path):
    """One plan in two stiffnesses: the table, the chart, and a second call that makes no run again."""
    def study():
        return subprocess.run([sys.executable, root / "examples/orbit_study.py", "plans", tmp_path, "--shapes", "bent", "--places", "planned",
                               "--stiffness", "1", "2"], check=True, capture_output=True, text=True).stdout

    first = study()
    with open(tmp_path / "plans.csv", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["status"] for row in rows] == ["done", "done"] and float(rows[0]["globe_off"]) != float(rows[1]["globe_off"])
    assert (tmp_path / "plans.png").stat().st_size > 10000 and study() == first
    shutil.rmtree(tmp_path / "runs")


@pytest.fixture
def plates(root, monkeypatch):
    """The module that makes the plates of the CT scene."""
    monkeypatch.syspath_prepend(root / "scenes/ct")
    return importlib.import_module("plates")


def slope(places):
    """A floor: a quadratic, so that bilinear heights over a fine lattice are exact to a micrometre."""
    x, y = places.T
    return -20.0 + 0.3 * x - 0.1 * y + 0.02 * x * y + 0.01 * y * y


@pytest.mark.parametrize("shape", ["bent", "flat"])
def test_a_plate_of_the_ct_fits_the_hole_and_the_floor(plates, shape):
    """A closed disc inside the ellipse, of its volume; bent: its upper side is the floor, flat: in a plane that no tilt or rise brings closer."""
    axis = np.arange(-10.0, 10.0, 0.05)
    x, y = np.meshgrid(axis, axis)
    heights = slope(np.stack([x.ravel(), y.ravel()], -1)).reshape(x.shape)
    floor = plates.Heights(heights, np.ones(x.shape, bool), np.array([axis[0], axis[0]]), 0.05)
    points, tets = plates.plate(floor, shape, (1.0, -2.0), np.array([5.0, 6.0]))
    p, q, r, s = (points[tets[:, k]] for k in range(4))
    volumes = np.einsum("ij,ij->i", np.cross(q - p, r - p), s - p) / 6
    sides = plates.SECTORS * np.sin(2 * np.pi / plates.SECTORS) / 2  # area of a polygon in the unit circle
    assert volumes.min() > 0 and volumes.sum() == pytest.approx(sides * 5 * 6 * plates.THICKNESS)
    assert (((points[:, :2] - (1.0, -2.0)) / (5.0, 6.0)) ** 2).sum(axis=1).max() <= 1 + 1e-12
    faces = np.sort(np.concatenate([np.delete(tets, k, axis=1) for k in range(4)]), axis=1)
    counts = np.unique(faces, axis=0, return_counts=True)[1]
    assert counts.max() == 2 and (counts == 1).sum() == 2 * plates.SECTORS * (2 * plates.RINGS - 1) + 2 * plates.SECTORS  # two sides and the rim
    top = points[len(points) // 2:]
    off = top[:, 2] - slope(top[:, :2])
    if shape == "bent":
        assert abs(off).max() < 1e-3
    else:
        terms = np.column_stack([np.ones(len(top)), top[:, :2]])
        assert abs(terms.T @ off).max() < 0.1 and abs(top[:, 2] - terms @ np.linalg.lstsq(terms, top[:, 2], rcond=None)[0]).max() < 1e-9
    with pytest.raises(AssertionError, match="larger than the floor"):
        plates.plate(plates.Heights(heights, x < 2.0, np.array([axis[0], axis[0]]), 0.05), shape, (1.0, -2.0), np.array([5.0, 6.0]))


def test_the_study_knows_the_places_of_each_head(root, tmp_path):
    refused = subprocess.run([sys.executable, root / "examples/orbit_study.py", "plans", tmp_path, "--head", "ct", "--places", "4 mm forward"],
                             capture_output=True, text=True)
    assert refused.returncode == 2
    assert refused.stderr.splitlines()[-1].endswith("--places: found '4 mm forward', expected one of: planned, 1 mm higher, 1 mm lower")


@pytest.mark.parametrize("study, missing", [("plans", "plate-bent.mesh"), ("meshes", "organs.seg.nrrd")])
def test_the_study_says_what_makes_the_files_of_the_ct(root, tmp_path, study, missing):
    """In a clone in which the scene of the CT was never run."""
    (tmp_path / "examples").mkdir()
    script = shutil.copy(root / "examples/orbit_study.py", tmp_path / "examples")
    refused = subprocess.run([sys.executable, script, study, "out", "--head", "ct"], cwd=tmp_path, capture_output=True, text=True)
    assert refused.returncode == 1 and len(refused.stderr.splitlines()) == 1
    assert refused.stderr.endswith(f"{missing}: './dev run scenes/orbit-ct.json --steps 1' makes it from the CT\n")


@pytest.mark.long
def test_the_repair_in_a_ct(root, command, tmp_path):
    """At rest in each stage, converged, nothing inverted in any step, contacts at most 2 % of an edge deep at the end; the page's figures."""
    if not (root / "build/ct/orbit/plate-bent.mesh").exists():
        pytest.skip("no meshes of the CT: './dev run scenes/orbit-ct.json --steps 1' makes them")
    subprocess.run([command, "run", root / "scenes/orbit-ct.json", "--strict", "--no-picture", "--quiet", "--out", "out"], cwd=tmp_path, check=True)
    run = json.loads((tmp_path / "out/run.json").read_text())
    assert run["solver"]["steps_not_converged"] == 0 and run["inverted_tets"]["largest"] == 0
    assert all(stage["reached"] and not stage["overlaps"] for stage in run["stages"])
    assert run["deepest"] <= 0.02 * next(body for body in run["bodies"] if body["name"] == "fat")["edge_length"]["mean"]
    section = (root / "docs/orbit.md").read_text().split("## The same operation in a CT")[1].split("\n## ")[0]
    compare_outcomes(section, tmp_path / "out", ("intact", "fracture", "repair"), 18)
