"""Driving bodies one by one, poses, fixed axes, prescribed points, fields by name. Oracles: NumPy,
SciPy's formula of rotations written out, Hooke, and the same set-up built otherwise.
"""

import numpy as np
import pytest

import palpate

TISSUE = palpate.Material(young_modulus=1e5, poisson_ratio=0.3, mass_damping=20.0, stiffness_damping=5e-3)
EXACT = {"solver": {"tolerance": 1e-10, "max_iterations": 5000}}
WEIGHTLESS = {"gravity": (0.0, 0.0, 0.0), **EXACT}


def rotation(axis, angle):
    """Rodrigues: I + sin K + (1 - cos) K^2."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def with_probe(center=(0.1, -0.2, 0.3)):
    model = palpate.Model()
    points, tets = palpate.box((2, 2, 2), (0.1, 0.1, 0.1))
    model.add_body(points, tets, name="block", material=TISSUE, fixed=points[:, 2] < -0.0499)
    motion = palpate.Motion([palpate.Keyframe(0.0)], center=center)
    model.add_body(points + [0.0, 0.0, 0.3], tets, name="probe", motion=motion)
    return points, palpate.Simulation(model, reactions=True, **WEIGHTLESS)


@pytest.mark.parametrize("axis,angle", [((0, 0, 1), 0.3), ((1, 2, 3), 3.1), ((-1, 0, 0.1), np.pi), ((0, 1, 0), -2.5), ((1, 1, 1), 0.0)])
def test_a_body_is_moved_to_a_pose(axis, angle):
    points, simulation = with_probe()
    probe = simulation.bodies["probe"]
    rest = points + [0.0, 0.0, 0.3]
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation(axis, angle), (0.02, -0.03, 0.1)
    probe.move_to(pose)
    simulation.step()
    np.testing.assert_allclose(probe.positions, rest @ pose[:3, :3].T + pose[:3, 3], atol=1e-12)
    # The same as a shift and a quaternion about the centre of the motion.
    center = np.array([0.1, -0.2, 0.3])
    unit = np.asarray(axis) / np.linalg.norm(axis)
    quaternion = np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * unit])
    shift = pose[:3, 3] + pose[:3, :3] @ center - center
    for call in [lambda: probe.move_to(shift, quaternion), lambda: probe.move_to(palpate.Keyframe(7.0, tuple(shift), tuple(quaternion))),
                lambda: simulation.move_to("probe", pose), lambda: simulation.move_to(1, shift, quaternion)]:
        probe.move_to((0.0, 0.0, 0.0))
        simulation.step()
        np.testing.assert_allclose(probe.positions, rest, atol=1e-15)
        call()
        simulation.step()
        np.testing.assert_allclose(probe.positions, rest @ pose[:3, :3].T + pose[:3, 3], atol=1e-12)


def test_what_is_no_pose_is_refused():
    _, simulation = with_probe()
    probe, block = simulation.bodies["probe"], simulation.bodies[0]
    before = simulation.save()
    mirror = np.diag([1.0, 1.0, -1.0, 1.0])
    tall = np.diag([1.0, 1.0, 1.1, 1.0])
    projective = np.eye(4)
    projective[3, 0] = 0.1
    for wrong in [lambda: probe.move_to(mirror), lambda: probe.move_to(tall), lambda: probe.move_to(projective),
                  lambda: probe.move_to(np.full((4, 4), np.nan)), lambda: probe.move_to(np.eye(3)), lambda: probe.move_to((0, 0)),
                  lambda: probe.move_to(np.eye(4), (1, 0, 0, 0)), lambda: probe.move_to(palpate.Keyframe(0.0), (1, 0, 0, 0)),
                  lambda: block.move_to((0, 0, 0)), lambda: probe.move_to((0, 0, 0), (1, 0, 0))]:
        with pytest.raises(palpate.Error):
            wrong()
    assert simulation.save() == before
    with pytest.raises(KeyError):
        simulation.bodies["nobody"]
    with pytest.raises(IndexError):
        simulation.bodies[2]


def test_a_body_tells_and_takes_what_the_simulation_does():
    points, simulation = with_probe()
    block, probe = simulation.bodies
    assert [block.name, probe.name, block.number, probe.number] == ["block", "probe", 0, 1]
    assert len(simulation.bodies) == 2 and "block" in repr(block)
    top = points[:, 2] > 0.0499
    block.set_forces((0.0, 0.0, 0.5), top)
    right = (points[simulation.bodies.triangles[block.triangles]][:, :, 0] > 0.0499).all(axis=1)
    block.set_pressure(40.0, right)
    simulation.step()
    force = block.reaction().force + [-0.4, 0.0, 0.5 * top.sum()]  # N: 40 Pa on 1 dm^2, 0.5 N on each point above
    # Newton from rest over 0.01 s, with lumped masses by NumPy: the force changes the momentum and balances the
    # damping.
    volumes = np.abs(np.linalg.det(points[simulation.bodies.tets[block.tets]][:, 1:] - points[simulation.bodies.tets[block.tets]][:, :1])) / 6
    lumped = np.zeros(len(points))
    np.add.at(lumped, simulation.bodies.tets[block.tets], 1000.0 * volumes[:, None] / 4)
    np.testing.assert_allclose(lumped @ block.velocities * (1 / 0.01 + TISSUE.mass_damping), force, atol=1e-7)
    assert block.mass == pytest.approx(lumped.sum())
    np.testing.assert_allclose(block.center_of_mass, lumped @ block.positions / lumped.sum(), atol=1e-12)
    block.set_velocities((0.0, 0.0, 0.0), ~(points[:, 2] < -0.0499))
    assert simulation.metrics.kinetic_energy == 0.0
    block.set_positions(points)
    np.testing.assert_array_equal(block.positions, points)
    np.testing.assert_array_equal(block.contact_wrench().force, np.zeros(3))
    probe.set_motion(palpate.Motion([palpate.Keyframe(0.0, (0.0, 0.0, 1.0))]))
    simulation.step()
    np.testing.assert_allclose(probe.positions, points + [0.0, 0.0, 1.3], atol=1e-12)
    mass = simulation.masses[1]
    np.testing.assert_allclose(probe.motor().force, [0.0, 0.0, mass * 1.0 / 1e-4], rtol=1e-9, atol=1e-9)  # 1 m in one step from rest


def test_axes_are_fixed_by_a_mask_for_each():
    """An eighth of a bar between planes of symmetry, stretched: Hooke for the corotational law."""
    points, tets = palpate.box((4, 3, 3), (0.1, 0.04, 0.06))
    points = points + [0.05, 0.02, 0.03]
    model = palpate.Model()
    body = model.add_body(points, tets, material=TISSUE, fixed=np.abs(points) < 1e-12)
    model.load_surface(body, points[:, 0] > 0.0999, traction=(1e4, 0.0, 0.0))
    simulation = palpate.Simulation(model, reactions=True, rest={"speed": 1e-8, "time": 0.05}, **WEIGHTLESS)
    simulation.run(3000, until_rest=True)
    assert simulation.at_rest
    np.testing.assert_allclose(simulation.positions, points * [1.1, 1 - 0.3 * 0.1, 1 - 0.3 * 0.1], atol=1e-7)
    np.testing.assert_allclose(simulation.reactions.sum(axis=0), [-1e4 * 0.04 * 0.06, 0.0, 0.0], atol=1e-4)
    with pytest.raises(palpate.Error, match="axis that is fixed"):
        simulation.set_velocities((0.0, 1.0, 0.0), (points[:, 1] == 0.0) & (points[:, 0] > 0.01) & (points[:, 2] > 0.01))
    with pytest.raises(palpate.Error, match="mask"):
        model.add_body(points, tets, material=TISSUE, fixed=np.zeros((3, 3), dtype=bool))


def test_prescribed_points_are_driven_frame_by_frame():
    """The same keyframes as one motion, and one by one in a callback."""
    points, tets = palpate.box((4, 2, 2), (0.2, 0.05, 0.05))
    right = points[:, 0] > 0.0999

    def pulled(motion):
        model = palpate.Model()
        bar = model.add_body(points, tets, material=TISSUE, fixed=points[:, 0] < -0.0999)
        number = model.prescribe(bar, right, motion)
        return number, palpate.Simulation(model, reactions=True, **WEIGHTLESS)

    number, by_hand = pulled(palpate.Motion([palpate.Keyframe(0.0)]))
    _, by_keyframes = pulled(palpate.Motion([palpate.Keyframe(0.0), palpate.Keyframe(0.1, (0.01, 0.0, 0.0))]))
    by_hand.move_prescribed(number, (0.001, 0.0, 0.0))
    by_hand.run(10, callback=lambda s: s.move_prescribed(number, (0.001 * (s.metrics.step + 1), 0.0, 0.0)))
    by_keyframes.run(10)
    np.testing.assert_allclose(by_hand.positions, by_keyframes.positions, atol=1e-10)
    np.testing.assert_allclose(by_hand.positions[right], points[right] + [0.01, 0.0, 0.0], atol=1e-12)
    by_hand.set_prescribed(number, palpate.Motion([palpate.Keyframe(0.0, (0.01, 0.0, 0.0))]))
    by_hand.run(400)
    pull = by_hand.reaction_of_prescribed(number).force
    left = by_hand.reactions[points[:, 0] < -0.0999].sum(axis=0)
    np.testing.assert_allclose(pull, -left, atol=1e-5 * pull[0])
    # Ends held laterally: stiffer than E A strain, and softer than a bar with rigid sides.
    assert 1e5 * 0.05**2 * 0.05 < pull[0] < 1.35 * 1e5 * 0.05**2 * 0.05


def test_results_that_are_kept_do_not_change_and_the_memory_of_others_is_used_again():
    _, simulation = with_probe()
    states = {"tets": simulation.tissue, "points": lambda: simulation.tissue_at_points(simulation.tissue())}
    for name, state in states.items():
        simulation.bodies["block"].set_forces((0.0, 0.0, 0.0))
        kept, array = state(), state().von_mises
        stress, von_mises = kept.stress.copy(), array.copy()
        simulation.bodies["block"].set_forces((0.1, 0.0, 0.2 if name == "tets" else -0.2))
        simulation.run(3)
        now = state().von_mises
        assert not np.array_equal(now, von_mises)
        np.testing.assert_array_equal(kept.stress, stress)
        np.testing.assert_array_equal(array, von_mises)
        place = now.ctypes.data
        del now
        assert state().von_mises.ctypes.data == place


def test_fields_have_the_names_of_scenes():
    _, simulation = with_probe()
    simulation.bodies["block"].set_forces((0.1, 0.0, 0.2))
    simulation.run(3)
    tets, points, surface = simulation.tissue(), simulation.tissue_at_points(), simulation.tractions()
    np.testing.assert_array_equal(simulation.field("von_mises"), points.von_mises)
    np.testing.assert_array_equal(simulation.field("von_mises", of="tets"), tets.von_mises)
    order = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)]
    for name in ("stress", "strain", "plastic_strain"):
        full = getattr(tets, name)
        np.testing.assert_array_equal(simulation.field(name, of="tets"), np.stack([full[:, i, j] for i, j in order], axis=1))
    np.testing.assert_array_equal(simulation.field("deformation_gradient"), points.deformation_gradient.reshape(-1, 9))
    np.testing.assert_array_equal(simulation.field("contact_pressure"), surface.point_pressure)
    np.testing.assert_array_equal(simulation.field("reaction"), simulation.reactions)
    # The docstring names every field with its shape, and nothing else.
    text = palpate.Simulation.field.__doc__
    for name in [n for n, *_ in simulation._fields([
            "contact_force", "contact_traction", "contact_pressure", "reaction", "deformation_gradient", "strain", "stress",
            "von_mises", "pressure", "principal_stress", "principal_directions", "energy_density", "plastic_strain", "volume_ratio"])]:
        values = simulation.field(name)
        assert f"{name} (n{'' if values.ndim == 1 else f', {values.shape[1]}'})" in text
    for wrong in [lambda: simulation.field("von_misses"), lambda: simulation.field("reaction", of="tets"),
                  lambda: simulation.field("stress", of="cells")]:
        with pytest.raises(palpate.Error):
            wrong()


def test_a_motion_that_was_set_is_part_of_the_state():
    _, one = with_probe()
    _, other = with_probe()
    one.move_to("probe", (0.0, 0.0, 0.1))
    other.restore(one.save())
    one.step()
    other.step()
    assert one.state_hash == other.state_hash
    assert one.bodies["probe"].positions[0, 2] == pytest.approx(0.3 - 0.05 + 0.1)


def test_a_run_tells_forces_and_maxima(tmp_path, command):
    """Columns of metrics.csv and maxima of run.json, by NumPy from forces.csv and from the frames as PyVista reads them."""
    import csv
    import json
    import subprocess

    import pyvista

    scene = {
        "name": "maxima", "units": {"length": "mm", "mass": "g"}, "duration": 0.3,
        "output": {"every": 3, "fields": ["von_mises", "contact_pressure", "pressure", "contact_force", "stress"]},
        "contact": {"friction": 0.0},
        "bodies": [
            {"name": "block, the", "box": {"cells": [4, 4, 2], "size": [60, 60, 20]},
             "material": {"young_modulus": 20000, "mass_damping": 5},
             "fixed": [{"box": {"lower": [-31, -31, -11], "upper": [31, 31, -9]}, "axes": "z"},
                       {"box": {"lower": [-31, -31, -11], "upper": [-29, -29, -9]}}]},
            {"name": "ball", "ball": {"radius": 10, "resolution": 3}, "translate": [3, 0, 20.1],
             "motion": {"keyframes": [{"time": 0}, {"time": 0.2, "translate": [0, 0, -3]}, {"time": 0.3, "translate": [0, 0, -1]}]}}],
    }
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    subprocess.run([command, "run", tmp_path / "scene.json", "--out", tmp_path / "out", "--no-picture", "--quiet"], check=True)
    unit = "[g mm/s^2 = uN]"
    with open(tmp_path / "out/forces.csv", newline="") as file:
        forces = list(csv.DictReader(file))
    with open(tmp_path / "out/metrics.csv", newline="") as file:
        metrics = list(csv.DictReader(file))
    assert len(forces) == len(metrics) == 31
    pressed = 0
    for force, row in zip(forces, metrics):
        sizes = [np.linalg.norm([float(force[f"{body} contact force_{axis} {unit}"]) for axis in "xyz"])
                 for body in ("block, the", "ball")]
        assert float(row[f"largest_contact_force {unit}"]) == pytest.approx(max(sizes), rel=1e-12)
        # Without friction every force is along a contact: their sum is at least the resultant.
        assert float(row[f"normal_force {unit}"]) >= max(sizes) * (1 - 1e-9)
        held = float(force[f"block, the held force_z {unit}"])
        pressed += held > 0.0
    assert pressed > 20, "the rollers carry the block"
    report = json.loads((tmp_path / "out/run.json").read_text())
    frames = [pyvista.read(file) for file in sorted((tmp_path / "out/frames").glob("*.vtu"))]
    assert set(report["fields"]) == {"von_mises", "contact_pressure", "pressure", "contact_force"}
    for name, told in report["fields"].items():
        of_tets = name in ("von_mises", "pressure")
        best = []
        for number, frame in enumerate(frames):
            values = np.asarray(frame.cell_data[name] if of_tets else frame.point_data[name])
            sizes = values if values.ndim == 1 else np.linalg.norm(values, axis=1)
            best.append((np.nanmax(sizes), 3 * number, int(np.nanargmax(sizes)), frame))
        largest, step, row, frame = max(best, key=lambda b: b[0])
        assert told["largest"] == pytest.approx(largest, rel=1e-12) and told["step"] == step
        body = int((frame.cell_data if of_tets else frame.point_data)["body"][row])
        assert told["body"] == ("block, the", "ball")[body]
        first = np.flatnonzero((frame.cell_data if of_tets else frame.point_data)["body"] == body)[0]
        assert told["tet" if of_tets else "point"] == row - first
        place = frame.get_cell(row).points.mean(axis=0) if of_tets else frame.points[row]
        np.testing.assert_allclose(told["place"], place, atol=1e-4)
        assert told["unit"] == (unit[1:-1] if name == "contact_force" else "g/(mm s^2) = Pa")
