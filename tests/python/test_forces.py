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
    np.testing.assert_allclose(on_plate, simulation.contact_forces[1], rtol=1e-12, atol=1e-14)
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


def test_tissue_at_points_may_be_given_that_of_the_tets(simulation):
    of_tets = simulation.tissue()
    alone, given = simulation.tissue_at_points(), simulation.tissue_at_points(of_tets)
    for name in ["deformation_gradient", "strain", "stress", "von_mises", "principal_stress", "principal_directions", "energy_density",
                 "plastic_strain", "volume_ratio"]:
        np.testing.assert_array_equal(getattr(alone, name), getattr(given, name))
    with pytest.raises(palpate.Error, match=f"found {len(alone)} rows, expected {len(of_tets)}, one for each tet"):
        simulation.tissue_at_points(alone)


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
        with pytest.raises(palpate.Error, match=f"{key}.*cannot change after the start"):
            simulation.change(**{key: {}})
    with pytest.raises(palpate.Error, match="frction"):
        simulation.change(contact={"frction": 1})


def test_pair_wrenches_about_a_point_are_transported(simulation):
    """M' = M + (a - b) x F, by NumPy; of the only pair the wrench is that of the body."""
    about = np.array([0.3, -0.2, 0.1])
    (pair,), (centered,) = simulation.pair_wrenches(about), simulation.pair_wrenches()
    np.testing.assert_array_equal(centered.on_b.about, simulation.center_of_mass("plate"))
    np.testing.assert_array_equal(pair.on_b.about, about)
    np.testing.assert_array_equal(pair.on_b.force, centered.on_b.force)
    moved = centered.on_b.torque + np.cross(centered.on_b.about - about, centered.on_b.force)
    np.testing.assert_allclose(pair.on_b.torque, moved, rtol=1e-12)
    assert np.linalg.norm(pair.on_b.torque - centered.on_b.torque) > 0.1 * np.linalg.norm(pair.on_b.force) * np.linalg.norm(about)
    np.testing.assert_allclose(pair.on_b.torque, simulation.contact_wrench("plate", about).torque, rtol=1e-12)


def test_points_of_torques_must_be_finite(simulation):
    plate = simulation.bodies["plate"]
    for about in [(np.nan, 0, 0), [0, np.inf, 0], np.array([0, 0, -np.inf])]:
        for call in [simulation.pair_wrenches, plate.contact_wrench, plate.reaction, plate.motor, simulation.contact_wrench("block").moved_to,
                     lambda a: simulation.contact_wrench("plate", about=a), lambda a: simulation.reaction("block", about=a),
                     lambda a: simulation.motor("plate", about=a), lambda a: simulation.reaction_of_prescribed(0, about=a)]:
            with pytest.raises(palpate.Error, match="^wrench: about: found a number that is not finite, expected three finite numbers$"):
                call(about)


def test_of_forces_on_a_point_given_twice_the_last_holds():
    _, _, twice = free_block()
    _, _, once = free_block()
    _, _, added = free_block()
    twice.set_forces([3, 4, 3], [[5.0, 0, 0], [0, 1.0, 0], [0, 0, 2.0]])
    once.set_forces([4, 3], [[0, 1.0, 0], [0, 0, 2.0]])
    added.set_forces([4, 3], [[0, 1.0, 0], [5.0, 0, 2.0]])
    for simulation in (twice, once, added):
        simulation.step()
    assert twice.state_hash == once.state_hash != added.state_hash
    assert "last force holds" in palpate.Simulation.set_forces.__doc__


@pytest.mark.parametrize(("law", "least"), [("corotational", -50.0), ("stable-neo-hookean", -50.0),
                                            ("stable-neo-hookean", 20.0)])
def test_a_pressure_for_each_triangle_gives_the_sum_of_its_forces(law, least):
    """Newton: the momentum after a step is that of the sum of - p A n, by NumPy. In the last case a part of it is a
    pressure on all of the body, which is computed with the tissue."""
    rng = np.random.default_rng(5)
    model = palpate.Model()
    points, tets = palpate.box((3, 3, 3), (0.1, 0.1, 0.1))
    model.add_body(points, tets, material=palpate.Material(young_modulus=5e4, model=law))
    simulation = palpate.Simulation(model, **WEIGHTLESS)
    corners = points[simulation.bodies.triangles]
    normals = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    pressures = rng.uniform(least, 100.0, len(normals))
    simulation.set_pressure(np.arange(len(normals)), pressures)
    simulation.step()
    tet_masses = 1000.0 * np.abs(np.linalg.det(points[tets][:, 1:] - points[tets][:, :1])) / 6
    lumped = np.zeros(len(points))
    np.add.at(lumped, tets, tet_masses[:, None] / 4)
    np.testing.assert_allclose(lumped @ simulation.velocities / 0.01, -pressures @ normals, rtol=1e-7)
    # The same in two parts, of which the later replaces the first, and by the body.
    other = palpate.Simulation(model, **WEIGHTLESS)
    other.bodies[0].set_pressure(7.0)
    other.bodies[0].set_pressure(pressures, np.ones(len(normals), dtype=bool))
    other.step()
    assert other.state_hash == simulation.state_hash
    before = simulation.save()
    for wrong in [pressures[:-1], np.full(len(normals), np.nan), pressures[:, None], ["a"] * len(normals)]:
        with pytest.raises(palpate.Error, match="pressure"):
            simulation.set_pressure(np.arange(len(normals)), wrong)
    assert simulation.save() == before


def test_rigid_bodies_keep_their_shape():
    points, tets = palpate.box((2, 2, 2), (0.1, 0.1, 0.1))
    model = palpate.Model()
    model.add_body(points, tets, name="block", material=TISSUE)
    model.add_body(points + [0, 0, 0.5], tets, name="wall", material=TISSUE, obstacle=True)
    simulation = palpate.Simulation(model, **WEIGHTLESS)
    block, wall = simulation.bodies
    assert (block.is_rigid, wall.is_rigid) == (False, True)
    before = simulation.state_hash
    for wrong in [lambda: wall.set_positions(points[:1], [0]), lambda: wall.set_positions(points), lambda: simulation.set_positions(points[:2], [26, 27])]:
        with pytest.raises(palpate.Error, match="of the rigid body 'wall', expected points of bodies that deform"):
            wrong()
    assert simulation.state_hash == before
    # Without `points` those of all bodies can be given: what is rigid stays.
    simulation.set_positions(simulation.positions + [0.1, 0, 0])
    np.testing.assert_array_equal(block.positions, points + [0.1, 0, 0])
    np.testing.assert_array_equal(wall.positions, points + [0, 0, 0.5])
    simulation.set_positions(points)
    np.testing.assert_array_equal(block.positions, points)
    wall.release()
    assert not wall.is_rigid
    wall.set_positions(points[:1] + [0, 0, 0.51], [0])
    assert wall.positions[0, 2] == points[0, 2] + 0.51


def test_grids_have_units(tmp_path, command):
    """In SI, in millimetres, and in the metadata of arrays where frames of the command have them."""
    import subprocess

    import pyvista
    from vtkmodules.vtkCommonCore import vtkDataArray

    def metadata(grid):
        found = {}
        for data in (grid.GetPointData(), grid.GetCellData()):
            for i in range(data.GetNumberOfArrays()):
                found[data.GetArrayName(i)] = data.GetArray(i).GetInformation().Get(vtkDataArray.UNITS_LABEL())
        return found

    _, _, simulation = free_block()
    grid = simulation.to_pyvista(["von_mises", "contact_force", "volume_ratio"])
    assert list(grid.field_data["units"]) == ["points [m]", "depth [m]", "velocity [m/s]", "von_mises [Pa]", "contact_force [N]"]
    assert metadata(grid) == {"body": None, "depth": "m", "velocity": "m/s", "von_mises": "Pa", "contact_force": "N", "volume_ratio": None}
    grid.save(tmp_path / "grid.vtu")
    assert metadata(pyvista.read(tmp_path / "grid.vtu")) == metadata(grid)
    scene = {"name": "units", "units": {"length": "mm", "mass": "g"}, "duration": 0.01, "output": {"fields": ["stress", "contact_force"]},
             "bodies": [{"name": "ball", "ball": {"radius": 10, "resolution": 2}, "material": {}}]}
    made = palpate.Simulation(scene)
    made.run()
    units = ["points [mm]", "depth [mm]", "velocity [mm/s]", "stress [g/(mm s^2) = Pa]", "contact_force [g mm/s^2 = uN]"]
    assert list(made.to_pyvista(["stress", "contact_force"]).field_data["units"]) == units
    model = palpate.Simulation(palpate.Model.from_scene(scene))
    assert list(model.to_pyvista(["stress", "contact_force"]).field_data["units"]) == units
    palpate.write_scene(scene, tmp_path / "scene.json")
    subprocess.run([command, "run", tmp_path / "scene.json", "--out", tmp_path / "out", "--no-picture", "--quiet"], check=True)
    frame = metadata(pyvista.read(sorted((tmp_path / "out/frames").glob("*.vtu"))[-1]))
    of_grid = metadata(made.to_pyvista(["stress", "contact_force"]))
    for name in ("depth", "velocity", "stress", "contact_force"):
        assert frame[name] == of_grid[name] is not None


def test_the_summary_has_the_forces_of_free_bodies(tmp_path, command):
    """Ten blocks that lie on a plate: their weights, by hand; what is held comes first, and the list is cut."""
    import re
    import subprocess

    blocks = [{"name": f"block {i}", "box": {"cells": [2, 2, 2], "size": [10, 10, 10]}, "translate": [20 * i, 0, 5 - 0.001],
               "material": {"young_modulus": 50000, "density": 0.001 * (1 + i), "mass_damping": 20}} for i in range(10)]
    plate = {"name": "plate", "obstacle": True, "box": {"cells": [1, 1, 1], "size": [400, 40, 10]}, "translate": [90, 0, -5]}
    scene = {"name": "blocks", "units": {"length": "mm", "mass": "g"}, "duration": 5, "rest": {"speed": 0.01, "time": 0.05}, "bodies": [*blocks, plate]}
    palpate.write_scene(scene, tmp_path / "scene.json")
    done = subprocess.run([command, "run", tmp_path / "scene.json", "--out", tmp_path / "out", "--no-picture", "--until-rest"], check=True,
                          capture_output=True, text=True)
    lines = re.findall(r"(?m)^force +(.*)$", done.stdout)
    shown = [re.match(r"(.*): contacts ([\d.]+) mN at the end, ([\d.]+) mN at most \(step \d+\)$", line) for line in lines[:-1]]
    assert [match[1] for match in shown] == ["plate", *(f"block {i}" for i in range(7))]
    for i, match in enumerate(shown[1:]):
        assert float(match[2]) == pytest.approx(9.81 * (1 + i), rel=0.01)  # mN: a cubic centimetre of 1 g and more
        assert float(match[3]) >= float(match[2])
    assert float(shown[0][2]) == pytest.approx(9.81 * 55, rel=0.01)
    assert lines[-1] == "... and 3 more, in forces.csv"
