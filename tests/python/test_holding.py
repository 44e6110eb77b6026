"""Ties, grabs, prescribed points, loads and velocities, read and driven from Python and in files. Oracles: weights and Newton."""

import csv
import json
import subprocess

import numpy as np
import pytest

import palpate

TISSUE = palpate.Material(young_modulus=1e5, poisson_ratio=0.3, density=1000.0, mass_damping=20.0, stiffness_damping=5e-3)
POINTS, TETS = palpate.box((2, 2, 2), (0.1, 0.1, 0.1))
TOP, BOTTOM = POINTS[:, 2] > 0.0499, POINTS[:, 2] < -0.0499
WEIGHT = 9.81


def test_a_block_that_hangs_by_ties_and_one_by_a_grab():
    model = palpate.Model()
    model.add_body(POINTS, TETS, name="held", material=TISSUE, fixed=TOP)
    model.add_body(POINTS - [0.0, 0.0, 0.11], TETS, name="tied", material=TISSUE)
    model.attach("tied", TOP, "held", stiffness=5e3)
    model.add_body(POINTS + [0.5, 0.0, 0.0], TETS, name="grabbed", material=TISSUE)
    middle = int(np.argmin(np.abs(POINTS).sum(axis=1)))
    model.grab("grabbed", middle, POINTS[middle] + [0.5, 0.0, 0.0], 1e3)
    simulation = palpate.Simulation(model, solver={"tolerance": 1e-10, "max_iterations": 5000})
    simulation.run(400)
    bodies = simulation.bodies
    ties = simulation.ties
    assert len(ties.point) == len(ties.tet) == TOP.sum()
    np.testing.assert_array_equal(bodies.body_of_point[ties.point], 1)
    np.testing.assert_array_equal(bodies.body_of_point[bodies.tets[ties.tet]], 0)
    np.testing.assert_allclose(ties.force.sum(axis=0), [0, 0, WEIGHT], atol=1e-3)
    np.testing.assert_allclose(bodies["tied"].tie_wrench().force, ties.force.sum(axis=0), rtol=1e-12)
    np.testing.assert_allclose(bodies["held"].tie_wrench().force, -ties.force.sum(axis=0), rtol=1e-12)
    about = (1.0, 0.0, 0.0)
    assert simulation.tie_wrench("tied", about).torque[1] == pytest.approx(WEIGHT, rel=1e-3)  # arm -1 m along x
    (grab,) = simulation.grabs
    assert (grab.number, grab.point, grab.stiffness) == (0, bodies["grabbed"].points.start + middle, 1e3)
    np.testing.assert_allclose(grab.target, POINTS[middle] + [0.5, 0.0, 0.0])
    np.testing.assert_allclose(grab.force, [0, 0, WEIGHT], atol=1e-3)
    np.testing.assert_array_equal(bodies["grabbed"].grab_wrench().force, grab.force)
    grab.release()
    assert simulation.grabs == []


def test_files_have_the_forces_of_ties_and_grabs(tmp_path, command):
    box = {"cells": [2, 2, 2], "size": [0.1, 0.1, 0.1]}
    material = {"young_modulus": 1e5, "density": 1000, "mass_damping": 20}
    face = {"box": {"lower": [-1, -1, -0.061], "upper": [1, 1, -0.059]}}
    scene = {"name": "hanging", "duration": 4, "bodies": [
        {"name": "held", "box": box, "material": material, "fixed": [{"box": {"lower": [-1, -1, 0.049], "upper": [1, 1, 1]}}]},
        {"name": "tied", "box": box, "translate": [0, 0, -0.11], "material": material, "attached": [{"to": "held", **face}]},
        {"name": "grabbed", "box": box, "translate": [0.5, 0, 0], "material": material,
         "grabs": [{"from": [0.5, 0, 0], "target": [0.5, 0, 0], "stiffness": 1000}]}]}
    palpate.write_scene(scene, tmp_path / "scene.json")
    subprocess.run([command, "run", tmp_path / "scene.json", "--out", tmp_path / "out", "--no-picture", "--quiet"], check=True)
    rows = list(csv.DictReader((tmp_path / "out/forces.csv").open()))
    last = rows[-1]
    assert float(last["tied tied force_z [N]"]) == pytest.approx(WEIGHT, rel=1e-3)
    assert float(last["held tied force_z [N]"]) == pytest.approx(-WEIGHT, rel=1e-3)
    assert float(last["held held force_z [N]"]) == pytest.approx(2 * WEIGHT, rel=1e-3)
    assert float(last["grabbed grabbed force_z [N]"]) == pytest.approx(WEIGHT, rel=1e-3)
    assert not [name for name in last if name.startswith(("tied grabbed", "grabbed tied", "held grabbed"))]
    bodies = json.loads((tmp_path / "out/run.json").read_text())["bodies"]
    forces = {body["name"]: body["forces"] for body in bodies}
    assert forces["tied"]["tied"]["force"][2] == float(last["tied tied force_z [N]"])
    assert forces["grabbed"]["grabbed"]["force"][2] == float(last["grabbed grabbed force_z [N]"])
    assert forces["grabbed"]["tied"] is None and forces["tied"]["grabbed"] is None


@pytest.mark.parametrize("ramp", [None, palpate.Ramp([0.0], [1.0])])
def test_driven_forces_add_to_loads(ramp):
    model = palpate.Model()
    model.add_body(POINTS, TETS, name="block", material=TISSUE, fixed=BOTTOM)
    model.load("block", TOP, (0.0, 0.0, 0.5), ramp=ramp)
    simulation = palpate.Simulation(model, gravity=(0, 0, 0), reactions=True, solver={"tolerance": 1e-10, "max_iterations": 5000})
    simulation.set_forces(np.flatnonzero(TOP), (0.0, 0.0, 0.1))
    simulation.run(400)
    assert simulation.reaction("block").force[2] == pytest.approx(-0.5 - 0.1 * TOP.sum(), rel=1e-4)
    simulation.set_forces(np.flatnonzero(TOP), (0.0, 0.0, 0.0))
    simulation.run(400)
    assert simulation.reaction("block").force[2] == pytest.approx(-0.5, rel=1e-4)


def test_a_callback_of_numpy_ends_a_run():
    simulation = palpate.Simulation({"bodies": [{"ball": {"radius": 1.0, "resolution": 1}, "material": {}}]})
    assert simulation.run(20, callback=lambda s: np.float64(s.metrics.step) > 4) == 5
    assert simulation.run(3, callback=lambda s: s.metrics.step) == 3  # a number is not an order to stop


def test_prescribed_points_of_a_scene_have_numbers():
    cells = {"cells": [2, 2, 2], "size": [0.1, 0.1, 0.1]}
    top = {"box": {"lower": [-1, -1, 0.049], "upper": [1, 1, 1]}}
    still = {"keyframes": [{"time": 0}]}
    simulation = palpate.Simulation({"gravity": [0, 0, 0], "bodies": [
        {"name": "block", "box": cells, "material": {}, "prescribed": [{"motion": still, **top}]},
        {"name": "probe", "box": cells, "translate": [0.5, 0, 0], "motion": still}]})
    (number,) = simulation.bodies["block"].prescribed
    assert simulation.bodies["probe"].prescribed == []
    simulation.move_prescribed(number, (0.0, 0.0, 0.02))
    simulation.step()
    np.testing.assert_allclose(simulation.positions[:27][TOP], POINTS[TOP] + [0.0, 0.0, 0.02], atol=1e-12)
    for wrong in {0, 1, 2, -1} - {number}:
        for call in (lambda: simulation.move_prescribed(wrong, (0, 0, 0)), lambda: simulation.set_prescribed(wrong, palpate.Motion([palpate.Keyframe(0.0)]))):
            with pytest.raises(palpate.Error, match="prescribed"):
                call()
    np.testing.assert_allclose(simulation.bodies["probe"].positions, POINTS + [0.5, 0, 0], atol=1e-15)


def test_velocities_are_set_whole():
    model = palpate.Model()
    model.add_body(POINTS, TETS, name="held", material=TISSUE, fixed=BOTTOM)
    model.add_body(POINTS + [0.5, 0.0, 0.0], TETS, name="free", material=TISSUE, velocity=(0.0, 1.0, 0.0))
    simulation = palpate.Simulation(model)
    simulation.run(5)
    kept = simulation.velocities
    simulation.set_velocities((0.0, 0.0, 0.0))
    assert not simulation.velocities.any()
    simulation.set_velocities(kept)
    np.testing.assert_array_equal(simulation.velocities, kept)
    simulation.bodies["held"].set_velocities((1.0, 0.0, 0.0))
    np.testing.assert_array_equal(simulation.bodies["held"].velocities, np.where(BOTTOM[:, None], 0.0, [1.0, 0.0, 0.0]))
    simulation.bodies["held"].set_velocities(np.zeros((27, 3)))
    assert not simulation.bodies["held"].velocities.any()
    np.testing.assert_array_equal(simulation.bodies["free"].velocities, kept[27:])


def test_a_spin_is_about_the_centre_of_mass():
    uneven = POINTS.copy()
    uneven[:, 0] = np.where(np.abs(uneven[:, 0]) < 1e-9, 0.04, uneven[:, 0])  # the middle layer is off the middle
    model = palpate.Model()
    model.add_body(uneven, TETS, name="block", material=palpate.Material(young_modulus=1e5), angular_velocity=(0.0, 0.0, 10.0))
    simulation = palpate.Simulation(model, gravity=(0, 0, 0), solver={"tolerance": 1e-12, "max_iterations": 5000})
    start = simulation.center_of_mass("block")
    simulation.run(20)
    np.testing.assert_allclose(simulation.center_of_mass("block"), start, atol=1e-10)


def test_a_model_refuses_what_a_scene_refuses():
    model = palpate.Model()
    axes = np.zeros((len(POINTS), 3), dtype=bool)
    axes[TOP, 2] = True
    model.add_body(POINTS, TETS, name="block", material=TISSUE, fixed=axes)
    still = palpate.Motion([palpate.Keyframe(0.0)])
    model.add_body(POINTS, TETS, name="plate", obstacle=True)
    for call, words in [
        (lambda: model.add_body(POINTS, TETS, obstacle=True, velocity=(1, 0, 0)), "a velocity of a rigid body"),
        (lambda: model.add_body(POINTS, TETS, motion=still, angular_velocity=(1, 0, 0)), "a velocity of a rigid body"),
        (lambda: model.load("plate", TOP, (1, 0, 0)), "the rigid body 'plate'"),
        (lambda: model.load("none", TOP, (1, 0, 0)), r"'none', expected one of \['block', 'plate'\]"),
        (lambda: model.load_surface("block", TOP), "neither pressure nor traction"),
        (lambda: model.load_surface("block", TOP, pressure=1.0, traction=(1, 0, 0)), "both pressure and traction"),
        (lambda: model.prescribe("block", TOP, still), "fixed along an axis"),
    ]:
        with pytest.raises(palpate.Error, match=words):
            call()
    assert len(model.bodies) == 2
