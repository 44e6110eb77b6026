"""Forces, stress and driving from Python. Oracles: Newton, Hooke, NumPy, and the same set-up built otherwise."""

import numpy as np
import pytest

import palpate

TISSUE = palpate.Material(young_modulus=5e4, poisson_ratio=0.3, mass_damping=5.0, stiffness_damping=2e-3)
EXACT = {"solver": {"tolerance": 1e-9, "max_iterations": 5000}}
WEIGHTLESS = {"gravity": (0.0, 0.0, 0.0), **EXACT}


def pressed(**settings):
    """A block fixed at its bottom, and a plate with a prescribed motion that presses it off its centre."""
    model = palpate.Model()
    points, tets = palpate.box((5, 4, 3), (0.1, 0.1, 0.06))
    model.add_body(points, tets, name="block", material=TISSUE, fixed=points[:, 2] < -0.0299)
    plate, plate_tets = palpate.box((2, 2, 1), (0.1, 0.12, 0.02))
    motion = palpate.Motion([palpate.Keyframe(0.0), palpate.Keyframe(0.2, (0, 0, -0.005))], interpolation="smooth")
    model.add_body(plate + [0.03, 0.0, 0.0405], plate_tets, name="plate", motion=motion)
    return palpate.Simulation(model, reactions=True, contact={"friction": 0.4}, **{**EXACT, **settings})


@pytest.fixture(scope="module")
def simulation():
    made = pressed(rest={"speed": 1e-6, "time": 0.05})
    made.run(2000, until_rest=True)
    assert made.at_rest
    return made


def test_contacts_tell_their_forces(simulation):
    contacts = simulation.acting_contacts
    assert len(contacts) > 10 and set(contacts.status) <= {"open", "stick", "slide"}
    parts = contacts.normal[:, None] * contacts.direction + contacts.friction
    np.testing.assert_allclose(contacts.force, parts, atol=1e-12)
    np.testing.assert_allclose(np.einsum("ij,ij->i", contacts.friction, contacts.direction), 0.0, atol=1e-9)
    body = simulation.bodies.body_of_point
    on_plate = contacts.force[body[contacts.point] == 1].sum(axis=0) - contacts.force[contacts.body == 1].sum(axis=0)
    np.testing.assert_allclose(on_plate, simulation.contact_forces[1], rtol=1e-12)
    held = simulation.bodies.tets[contacts.tet]
    assert (body[held[:, 0]] == contacts.body).all()


def test_wrenches_and_reactions_balance(simulation):
    plate = simulation.contact_wrench("plate")
    assert plate.force[2] > 5.0
    arms = simulation.positions - plate.about
    held = simulation.bodies["block"].points
    support = simulation.reaction("block", plate.about)
    np.testing.assert_allclose(support.force, simulation.reactions[held].sum(axis=0), rtol=1e-12)
    np.testing.assert_allclose(support.torque, np.cross(arms[held], simulation.reactions[held]).sum(axis=0), rtol=1e-9)
    weight = np.array([0.0, 0.0, 9.81]) * simulation.masses[0]
    np.testing.assert_allclose(support.force - weight, plate.force, atol=1e-4 * plate.force[2])
    motor = simulation.motor("plate", plate.about)
    np.testing.assert_allclose(motor.force - [0, 0, 9.81 * simulation.masses[1]], -plate.force, atol=1e-4 * plate.force[2])
    (pair,) = simulation.pair_wrenches()
    assert (pair.body_a, pair.body_b) == (0, 1) and pair.normal == pytest.approx(plate.force[2], rel=0.05)
    np.testing.assert_allclose(pair.on_b.force, plate.force, rtol=1e-12)
    moved = plate.moved_to((0.0, 0.0, 0.0))
    np.testing.assert_allclose(moved.torque, plate.torque + np.cross(plate.about, plate.force), rtol=1e-12)
    assert "Wrench" in repr(plate)


def test_tractions_add_up_to_the_wrench(simulation):
    surface = simulation.tractions()
    triangles = simulation.bodies["block"].triangles
    assert surface.corner_forces.shape == (len(simulation.bodies.triangles), 3, 3)
    total = (surface.area[:, None] * surface.traction)[triangles].sum(axis=0)
    np.testing.assert_allclose(total, simulation.contact_forces[0], atol=1e-10)
    np.testing.assert_allclose(surface.point_forces[simulation.bodies["block"].points].sum(axis=0), total, atol=1e-10)
    assert surface.pressure.max() > 0.0 and surface.point_pressure.shape == (len(simulation.positions),)


def test_stress_is_that_of_the_law():
    """An affine map: the corotational law by NumPy's singular values."""
    model = palpate.Model()
    points, tets = palpate.box((2, 2, 2), (0.1, 0.1, 0.1))
    model.add_body(points, tets, material=TISSUE)
    simulation = palpate.Simulation(model, **WEIGHTLESS)
    gradient = np.array([[1.1, 0.2, 0.0], [-0.1, 0.9, 0.1], [0.05, 0.0, 1.2]])
    simulation.set_positions(points @ gradient.T)
    u, _, vt = np.linalg.svd(gradient)
    rotation = u @ vt
    strain = rotation.T @ gradient - np.eye(3)
    mu, lam = 5e4 / 2.6, 5e4 * 0.3 / (1.3 * 0.4)
    first = rotation @ (2 * mu * strain + lam * np.trace(strain) * np.eye(3))
    stress = first @ gradient.T / np.linalg.det(gradient)
    for state in (simulation.tissue(), simulation.tissue_at_points()):
        np.testing.assert_allclose(state.stress, np.broadcast_to(stress, (len(state), 3, 3)), rtol=1e-9, atol=1e-6)
        np.testing.assert_allclose(state.deformation_gradient, np.broadcast_to(gradient, (len(state), 3, 3)), atol=1e-12)
        np.testing.assert_allclose(state.pressure, -np.trace(stress) / 3, rtol=1e-9)
        np.testing.assert_allclose(state.principal_stress, np.broadcast_to(np.linalg.eigvalsh(stress)[::-1], (len(state), 3)), rtol=1e-8)
        np.testing.assert_allclose(state.strain[0], (gradient.T @ gradient - np.eye(3)) / 2, atol=1e-12)
        np.testing.assert_allclose(state.volume_ratio, np.linalg.det(gradient))
        deviator = stress - np.trace(stress) / 3 * np.eye(3)
        np.testing.assert_allclose(state.von_mises, np.sqrt(1.5 * (deviator**2).sum()), rtol=1e-9)
    assert len(simulation.tissue()) == len(tets) and len(simulation.tissue_at_points()) == len(points)


def test_tables_and_grids(simulation):
    import pandas

    frame = simulation.acting_contacts.to_dataframe()
    assert isinstance(frame, pandas.DataFrame) and len(frame) == len(simulation.acting_contacts)
    np.testing.assert_array_equal(frame["force_z"], simulation.acting_contacts.force[:, 2])
    assert {"weights_3", "status", "depth"} <= set(frame.columns)
    np.testing.assert_array_equal(frame["edge"], simulation.acting_contacts.edge)
    with pytest.raises(palpate.Error, match="a list of names"):
        simulation.to_pyvista("von_mises")
    assert {"direction_x", "certainty"} <= set(simulation.contacts.to_dataframe().columns)
    grid = simulation.to_pyvista(["von_mises", "stress", "contact_pressure", "reaction"])
    np.testing.assert_array_equal(grid.cell_data["von_mises"], simulation.tissue().von_mises)
    np.testing.assert_array_equal(grid.point_data["von_mises"], simulation.tissue_at_points().von_mises)
    assert grid.cell_data["stress"].shape == (grid.n_cells, 6)
    np.testing.assert_array_equal(grid.cell_data["stress"][:, 4], simulation.tissue().stress[:, 1, 2])
    np.testing.assert_array_equal(grid.point_data["reaction"], simulation.reactions)
    with pytest.raises(palpate.Error, match="von_misses"):
        simulation.to_pyvista(["von_misses"])


def test_a_frame_of_the_command_has_the_same_fields(tmp_path, command):
    """The command writes the same values as Python, bit for bit, with units."""
    import json
    import subprocess

    import pyvista

    scene = {
        "name": "fields", "units": {"length": "mm", "mass": "g"}, "duration": 0.2,
        "output": {"fields": ["von_mises", "contact_pressure"], "pairs": [{"bodies": ["ball", "block"]}]},
        "bodies": [
            {"name": "block", "box": {"cells": [4, 4, 2], "size": [60, 60, 20]}, "material": {"young_modulus": 20000},
             "fixed": [{"box": {"lower": [-31, -31, -11], "upper": [31, 31, -9]}}]},
            {"name": "ball", "ball": {"radius": 10, "resolution": 3}, "translate": [3, 0, 20.1],
             "motion": {"keyframes": [{"time": 0}, {"time": 0.2, "translate": [0, 0, -3]}]}}],
    }
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    subprocess.run([command, "run", tmp_path / "scene.json", "--out", tmp_path / "out", "--no-picture", "--quiet"], check=True)
    simulation = palpate.Simulation(tmp_path / "scene.json", reactions=True)
    simulation.run()
    frame = pyvista.read(sorted((tmp_path / "out/frames").glob("*.vtu"))[-1])
    np.testing.assert_array_equal(frame.cell_data["von_mises"], simulation.tissue().von_mises)
    np.testing.assert_array_equal(frame.point_data["contact_pressure"], simulation.tractions().point_pressure)
    text = b"".join(line for line in open(sorted((tmp_path / "out/frames").glob("*.vtu"))[-1], "rb").readlines()[:60])
    assert b"g/(mm s^2) = Pa" in text
    table = np.genfromtxt(tmp_path / "out/forces.csv", delimiter=",", names=True, deletechars="")
    header = (tmp_path / "out/forces.csv").read_text().splitlines()[0].split(",")
    assert header[:3] == ["step", "time [s]", "block contact force_x [g mm/s^2 = uN]"]
    assert len(table) == 21
    last = dict(zip(header, (tmp_path / "out/forces.csv").read_text().splitlines()[-1].split(",")))
    assert float(last["ball contact force_z [g mm/s^2 = uN]"]) == simulation.contact_forces[1][2]
    assert float(last["ball held force_z [g mm/s^2 = uN]"]) == simulation.motor("ball").force[2]
    assert float(last["ball on block force_z [g mm/s^2 = uN]"]) == simulation.contact_forces[0][2]
    report = json.loads((tmp_path / "out/run.json").read_text())
    assert report["units"]["force"] == "g mm/s^2 = uN"
    block = report["bodies"][0]
    assert block["stress"]["largest_von_mises"] == np.nanmax(simulation.tissue().von_mises)
    assert block["forces"]["largest_contact"]["force"] >= (1 - 1e-12) * np.linalg.norm(simulation.contact_forces[0])


def test_reactions_must_be_asked_for():
    simulation = pressed()
    with pytest.raises(palpate.Error, match="record_reactions"):
        _ = simulation.reactions  # no step yet
    simulation.record_reactions(False)
    simulation.step()
    with pytest.raises(palpate.Error, match="record_reactions"):
        simulation.reaction("block")
    simulation.record_reactions(True)
    simulation.step()
    assert simulation.reactions.shape == simulation.positions.shape
    with pytest.raises(palpate.Error, match="no motion"):
        simulation.motor("block")


def test_an_instrument_is_driven_step_by_step():
    """move_to() along the keyframes of a motion gives the positions of that motion."""
    by_keyframes, by_hand = pressed(), pressed()
    for step in range(1, 11):
        fraction = min(1.0, 0.01 * step / 0.2)
        depth = -0.005 * fraction * fraction * (3 - 2 * fraction)
        by_hand.move_to("plate", (0.0, 0.0, depth))
        by_keyframes.step()
        by_hand.step()
        np.testing.assert_allclose(by_hand.positions, by_keyframes.positions, atol=1e-9)
    assert np.abs(by_hand.contact_forces[1]).max() > 0.1
    turn = palpate.Motion([palpate.Keyframe(0.0, (0, 0, 0.1), (np.sqrt(0.5), 0, 0, np.sqrt(0.5)))], center=(0.03, 0, 0))
    by_hand.set_motion("plate", turn)
    by_hand.step()
    first = by_hand.bodies["plate"].points.start
    x, y, z = by_hand.bodies.points_rest[first] - [0.03, 0, 0]
    np.testing.assert_allclose(by_hand.positions[first], [0.03 - y, x, z + 0.1], atol=1e-12)
    by_hand.move_to("plate", (0, 0, 0.2), (0.0, 0.0, 0.0, 1.0))
    by_hand.step()
    np.testing.assert_allclose(by_hand.positions[first], [0.03 - x, -y, z + 0.2], atol=1e-12)
    for wrong in [lambda: by_hand.move_to("block", (0, 0, 0)), lambda: by_hand.move_to("nobody", (0, 0, 0)),
                  lambda: by_hand.move_to(1, (0, 0, np.nan)), lambda: by_hand.move_to(1, (0, 0, 0), (1, 0, 0))]:
        with pytest.raises(palpate.Error):
            wrong()


def free_block(**settings):
    model = palpate.Model()
    points, tets = palpate.box((3, 3, 3), (0.1, 0.1, 0.1))
    model.add_body(points, tets, name="block", material=palpate.Material(young_modulus=5e4, stiffness_damping=2e-3))
    return model, points, palpate.Simulation(model, **{**WEIGHTLESS, **settings})


def test_loads_in_one_call_are_those_of_the_model():
    model, points, simulation = free_block()
    loaded = palpate.Model()
    loaded.add_body(points, palpate.box((3, 3, 3), (0.1, 0.1, 0.1))[1], material=palpate.Material(young_modulus=5e4, stiffness_damping=2e-3))
    top = np.flatnonzero(points[:, 2] > 0.0499)
    loaded.load(0, top, (0.0, 0.0, 1.6))
    loaded.load_surface(0, points[:, 0] > 0.0499, pressure=30.0)
    other = palpate.Simulation(loaded, **WEIGHTLESS)
    simulation.set_forces(top, (0.0, 0.0, 0.1))
    right = (points[simulation.bodies.triangles][:, :, 0] > 0.0499).all(axis=1)
    simulation.set_pressure(right, 30.0)
    for _ in range(5):
        simulation.step()
        other.step()
    np.testing.assert_allclose(simulation.velocities, other.velocities, atol=1e-12)
    momentum = simulation.masses[0] * (simulation.center_of_mass(0) - points.mean(axis=0)) / (0.01 * 0.01 * 15)
    np.testing.assert_allclose(momentum, [-0.3, 0.0, 1.6], atol=2e-3)  # N: 30 Pa on 1 dm^2, and 16 times 0.1 N


def test_ramps_gravity_and_start_velocities():
    points, tets = palpate.box((2, 2, 2), (0.1, 0.1, 0.1))
    material = palpate.Material(young_modulus=5e4)
    model = palpate.Model()
    model.add_body(points, tets, material=material, gravity=(0.0, 0.0, 2.0))
    model.add_body(points + [1, 0, 0], tets, material=material, velocity=(1.0, 0.0, 0.0), angular_velocity=(0, 0, 0.5))
    model.add_body(points + [2, 0, 0], tets, material=material, velocity=np.outer(points[:, 0], [1.0, 0, 0]))
    model.load(2, np.arange(27), (0.0, 3.0, 0.0), ramp=palpate.Ramp([0.0, 0.1], [0.0, 1.0]))
    simulation = palpate.Simulation(model, **WEIGHTLESS)
    velocities = simulation.velocities
    np.testing.assert_allclose(velocities[27:54], [1, 0, 0] + np.cross([0, 0, 0.5], points), atol=1e-12)
    np.testing.assert_allclose(velocities[54:], np.outer(points[:, 0], [1.0, 0, 0]), atol=1e-12)
    start = simulation.center_of_mass(2)
    simulation.run(10)
    assert simulation.center_of_mass(0)[2] == pytest.approx(2.0 * 1e-4 * 55, rel=1e-6)
    distance = sum((11 - n) * 0.1 * n for n in range(1, 11)) * 1e-4 * 3.0 / simulation.masses[2]
    assert (simulation.center_of_mass(2) - start)[1] == pytest.approx(distance, rel=1e-6)
    with pytest.raises(palpate.Error, match="velocity"):
        model.add_body(points, tets, material=material, velocity=np.zeros((3, 3)))


def test_prescribed_points_and_ties():
    model = palpate.Model()
    points, tets = palpate.box((4, 2, 2), (0.2, 0.05, 0.05))
    bar = model.add_body(points, tets, material=TISSUE, fixed=points[:, 0] < -0.0999)
    pull = palpate.Motion([palpate.Keyframe(0.0), palpate.Keyframe(0.2, (0.004, 0, 0))], interpolation="smooth")
    model.prescribe(bar, points[:, 0] > 0.0999, pull)
    hung = model.add_body(points - [0, 0, 0.051], tets, material=TISSUE)
    model.attach(hung, points[:, 2] > 0.0249, bar, stiffness=300.0)
    simulation = palpate.Simulation(model, reactions=True, rest={"speed": 1e-6, "time": 0.05}, **EXACT)
    simulation.run(3000, until_rest=True)
    assert simulation.at_rest
    ends = points[:, 0] > 0.0999
    np.testing.assert_allclose(simulation.positions[:45][ends], points[ends] + [0.004, 0, 0], atol=1e-12)
    weight = 9.81 * simulation.masses[1]
    assert simulation.tie_forces.shape == (15, 3)
    np.testing.assert_allclose(simulation.tie_forces.sum(axis=0), [0, 0, weight], atol=1e-3 * weight)
    assert simulation.reactions.sum(axis=0)[2] == pytest.approx(weight + 9.81 * simulation.masses[0], rel=1e-3)
    with pytest.raises(palpate.Error, match="itself"):
        model.attach(hung, [0], hung)
    with pytest.raises(palpate.Error, match="fixed"):
        model.prescribe(bar, [0], pull)


def test_states_are_set_whole_or_in_part():
    _, points, simulation = free_block()
    simulation.set_positions(points + [0.5, 0, 0])
    np.testing.assert_array_equal(simulation.positions, points + [0.5, 0, 0])
    simulation.set_positions(points[:2], [0, 1])
    np.testing.assert_array_equal(simulation.positions[:2], points[:2])
    simulation.set_positions(points + [0.5, 0, 0])
    simulation.set_velocities((0.2, 0.0, 0.0), np.arange(len(points)))
    assert simulation.metrics.kinetic_energy == pytest.approx(0.5 * simulation.masses[0] * 0.04)
    simulation.step()
    np.testing.assert_allclose(simulation.positions, points + [0.502, 0, 0], atol=1e-9)
    before = simulation.state_hash
    for wrong in [lambda: simulation.set_positions(points[:3]), lambda: simulation.set_positions([[np.nan] * 3], [0]),
                  lambda: simulation.set_velocities((0, 0, 0), [999]), lambda: simulation.set_forces([0, 1], np.zeros((3, 3))),
                  lambda: simulation.set_pressure([-1], 1.0)]:
        with pytest.raises(palpate.Error):
            wrong()
    assert simulation.state_hash == before


def test_settings_change_between_steps():
    _, _, simulation = free_block()
    simulation.change(gravity=(0.0, 0.0, -9.81), contact={"friction": 0.7})
    simulation.step()
    np.testing.assert_allclose(simulation.velocities[:, 2], -0.0981, rtol=1e-6)
    with pytest.raises(palpate.Error, match="time_step"):
        simulation.change(time_step=0.02)
    with pytest.raises(palpate.Error, match="relax"):
        simulation.change(relax={})
    for key in ("units", "bodies", "duration"):
        with pytest.raises(palpate.Error, match=f"{key}.*no step reads"):
            simulation.change(**{key: {}})
    with pytest.raises(palpate.Error, match="frction"):
        simulation.change(contact={"frction": 1})
