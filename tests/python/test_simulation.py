"""Simulation: the bits of the command, models built in code against analytic answers, grabs, callbacks, Ctrl-C."""

import csv
import io
import json
import subprocess
import sys
import warnings

import numpy as np
import pytest

import palpate
from threads import in_threads

SOFT = dict(young_modulus=2e4, poisson_ratio=0.3, density=1000.0)


def block(**options):
    """A model of one block of 3^3 cells of 0.1 m."""
    model = palpate.Model()
    model.add_body(*palpate.box((3, 3, 3), (0.1, 0.1, 0.1)), material=palpate.Material(**SOFT), **options)
    return model


def test_a_run_has_the_bits_of_the_command(root, command, tmp_path):
    scene = root / "scenes/stacking.json"
    output = subprocess.run([command, "run", scene, "--steps", "12", "--out", tmp_path / "run", "--no-picture", "--json"],
                            capture_output=True, text=True, check=True)
    simulation = palpate.Simulation(scene, threads=2)
    assert simulation.run(12) == 12
    assert simulation.state_hash == json.loads(output.stdout)["state_hash"]


def test_contacts_have_the_bits_of_the_command(root, command):
    scene = root / "scenes/stacking.json"
    output = subprocess.run([command, "detect", scene], capture_output=True, text=True, check=True).stdout
    rows = list(csv.reader(io.StringIO(output)))[1:]
    simulation = palpate.Simulation(scene)
    for contacts in [palpate.World.from_scene(scene).contacts, simulation.contacts]:
        assert len(contacts) == len(rows)
    touching = palpate.Simulation(scene)
    touching.run(10)
    world = palpate.World.from_scene(scene)
    world.update(touching.positions)
    for name in ["point", "body", "tet", "weights", "depth", "direction"]:
        assert np.array_equal(getattr(world.contacts, name), getattr(touching.contacts, name))
    assert len(world.contacts) > 500


def test_overlapping_contacts_have_the_bits_of_the_command(root, command, tmp_path):
    """A scene with overlaps from the start, so that `palpate detect` has contacts to show."""
    scene = palpate.read_scene(root / "scenes/stacking.json")
    scene["bodies"] = scene["bodies"][:6]
    for number, body in enumerate(scene["bodies"]):
        body["translate"][2] -= 0.003 * number
    palpate.write_scene(scene, tmp_path / "overlap.json")
    output = subprocess.run([command, "detect", tmp_path / "overlap.json"], capture_output=True, text=True,
                            check=True).stdout
    table = np.array([[float(x) for x in row] for row in list(csv.reader(io.StringIO(output)))[1:]])
    contacts = palpate.World.from_scene(scene).contacts
    assert len(table) > 200
    for name, columns in [("point", 0), ("body", 2), ("tet", 3), ("weights", slice(4, 8)), ("depth", 8),
                          ("direction", slice(9, 12))]:
        assert np.array_equal(table[:, columns], getattr(contacts, name)), name


def test_threads_and_settings_in_code_change_nothing_they_should_not(root):
    scene = root / "examples/scenes/tower.json"
    one, two = palpate.Simulation(scene, threads=1), palpate.Simulation(palpate.read_scene(scene), threads=3)
    one.run(5)
    two.run(5)
    assert one.state_hash == two.state_hash
    other = palpate.Simulation(scene, gravity=(0, 0, -1.0))
    other.run(5)
    assert other.state_hash != one.state_hash


def test_free_fall():
    """Implicit Euler falls g h^2 n (n + 1) / 2 in n steps, exactly."""
    simulation = palpate.Simulation(block(velocity=(1.0, 0, 0)), time_step=0.01, gravity=(0, 0, -9.81))
    start = simulation.positions
    assert simulation.run(20) == 20
    fallen = simulation.positions - start
    np.testing.assert_allclose(fallen[:, 2], -9.81 * 0.01**2 * 20 * 21 / 2, rtol=1e-6)
    np.testing.assert_allclose(fallen[:, 0], 0.2, rtol=1e-6)
    np.testing.assert_allclose(simulation.velocities[:, 2], -9.81 * 0.2, rtol=1e-6)
    assert simulation.metrics.step == 20 and simulation.metrics.time == pytest.approx(0.2)
    assert simulation.masses[0] == pytest.approx(1000.0 * 0.001)


def test_a_run_until_rest_that_ends_before_it_warns():
    simulation = palpate.Simulation(block(), time_step=0.01, duration=0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulation.run(until_rest=True, callback=lambda s: True)
        simulation.run(1, until_rest=True)  # the caller's own limit
    with pytest.warns(RuntimeWarning, match="not at rest after 8 steps, the rest of the duration of 0.1 s"):
        assert simulation.run(until_rest=True) == 8


def test_a_run_in_which_something_may_have_gone_through_a_body_warns():
    model = palpate.Model()
    points, tets = palpate.box(cells=(6, 6, 3), size=(0.12, 0.12, 0.02))
    model.add_body(points, tets, name="block", material=palpate.Material(young_modulus=1e4), fixed=abs(points[:, 0]) > 0.059)
    points, tets = palpate.box(cells=(8, 8, 1), size=(0.1, 0.1, 0.002))
    through = palpate.Motion([palpate.Keyframe(0), palpate.Keyframe(0.02, (0, 0, -0.2))])
    model.add_body(points + [0, 0, 0.012], tets, name="plate", motion=through)
    simulation = palpate.Simulation(model, time_step=0.02, gravity=(0, 0, 0))
    with pytest.warns(RuntimeWarning, match="in 1 of 1 steps something may have gone through a body"):
        simulation.run(1)
    assert simulation.metrics.passes > 0 and simulation.steps_too_far == 1


@pytest.mark.parametrize("continuous", ["off", "full"])
def test_a_run_without_continuous_detection_warns_and_says_what_helps(continuous):
    model = palpate.Model()
    points, tets = palpate.box(cells=(6, 6, 1), size=(0.2, 0.2, 0.004))
    model.add_body(points, tets, name="sheet", obstacle=True)
    points, tets = palpate.ball(radius=0.02, resolution=3)
    model.add_body(points + [0.003, 0.002, 0.1], tets, name="ball", material=palpate.Material(), velocity=(0, 0, -100))
    simulation = palpate.Simulation(model, time_step=0.005, gravity=(0, 0, 0), contact={"continuous": continuous})
    with pytest.warns(RuntimeWarning, match="something may have gone through a body") as caught:
        simulation.run(20)
    advice = [str(w.message) for w in caught if "gone through" in str(w.message)][0]
    assert ('"continuous": "full"' in advice) == (continuous == "off")
    assert simulation.steps_too_far > 0


def test_a_bar_that_falls_through_another_for_want_of_edges_warns():
    model = palpate.Model()
    points, tets = palpate.box(cells=(1, 1, 1), size=(0.2, 0.02, 0.02))
    model.add_body(points, tets, name="lower", obstacle=True)
    points, tets = palpate.box(cells=(1, 1, 1), size=(0.02, 0.2, 0.02))
    model.add_body(points + [0.09, -0.09, 0.021], tets, name="upper", material=palpate.Material())
    simulation = palpate.Simulation(model, time_step=0.005, contact={"edge_contacts": False})
    with pytest.warns(RuntimeWarning, match='gone through a body: .* contact={"edge_contacts": True}'):
        simulation.run(40)
    assert simulation.metrics.detection.unseen_pairs == 0, "it is below"
    assert simulation.positions[8:, 2].max() < 0


def test_a_grab_holds_a_block_by_its_weight():
    """At rest the springs carry the weight."""
    model = block()
    simulation = palpate.Simulation(model, time_step=0.02, rest={"speed": 1e-5, "time": 0.1})
    top = np.flatnonzero(simulation.positions[:, 2] > 0.049)
    grabs = [simulation.grab(int(p), simulation.positions[p], 200.0) for p in top]
    simulation.run(3000, until_rest=True)
    assert simulation.at_rest
    total = sum(grab.force for grab in grabs)
    np.testing.assert_allclose(total, [0, 0, 9.81 * simulation.masses[0]], atol=1e-3)
    grabs[0].move(simulation.positions[top[0]] + [0, 0, 0.01])
    for grab in grabs:
        grab.release()
    before = simulation.positions[:, 2].mean()
    simulation.run(10)
    assert simulation.positions[:, 2].mean() < before
    with pytest.raises(palpate.Error, match="a grab that was released"):
        grabs[0].force


def test_a_load_and_fixed_points():
    """The fixed points do not move; the others move along the force."""
    points, tets = palpate.box((6, 2, 2), (0.3, 0.1, 0.1))
    model = palpate.Model()
    beam = model.add_body(points, tets, name="beam", material=palpate.Material(**SOFT), fixed=points[:, 0] < -0.149)
    model.load(beam, np.flatnonzero(points[:, 0] > 0.149), (0, 0.5, 0))
    simulation = palpate.Simulation(model, gravity=(0, 0, 0))
    simulation.run(20)
    moved = simulation.positions - points
    assert np.array_equal(moved[points[:, 0] < -0.149], np.zeros((9, 3)))
    assert moved[points[:, 0] > 0.149][:, 1].min() > 1e-4
    simulation.set_force(0, (0, 0, 1.0))
    simulation.step()


def test_a_motion_carries_what_is_attached():
    bone = palpate.Motion([palpate.Keyframe(0.0), palpate.Keyframe(0.2, (0.0, 0.0, 0.1))], interpolation="smooth")
    model = palpate.Model()
    points, tets = palpate.box((2, 2, 2), (0.1, 0.1, 0.1))
    jaw = model.add_body(points, tets, name="jaw", motion=bone)
    tissue = model.add_body(points + [0.0, 0.0, 0.2], tets, name="tissue", material=palpate.Material(**SOFT))
    model.attach(tissue, points[:, 2] < -0.049, jaw)
    simulation = palpate.Simulation(model, gravity=(0, 0, 0))
    rest = simulation.positions
    simulation.run(20)
    moved = simulation.positions - rest
    np.testing.assert_allclose(moved[simulation.bodies["jaw"].points], np.tile([0, 0, 0.1], (27, 1)), atol=1e-12)
    glued = np.flatnonzero(points[:, 2] < -0.049) + 27
    np.testing.assert_allclose(moved[glued], np.tile([0, 0, 0.1], (9, 1)), atol=1e-12)


def test_regions_and_bodies_added_after_them():
    """A region doubles the mass; a body added later keeps its own material."""
    points, tets = palpate.box((2, 2, 2), (0.1, 0.1, 0.1))
    model = palpate.Model()
    first = model.add_body(points, tets, material=palpate.Material(density=1000.0))
    model.add_region(first, np.arange(len(tets)), palpate.Material(density=2000.0))
    model.add_body(points + 1.0, tets, material=palpate.Material(density=500.0))
    simulation = palpate.Simulation(model)
    np.testing.assert_allclose(simulation.masses, [2.0, 0.5])


def test_a_model_of_a_scene_is_the_scene(root):
    scene = root / "examples/scenes/everything.json"
    settings = {k: v for k, v in palpate.read_scene(scene).items()
                if k in ("time_step", "gravity", "contact", "solver", "rest", "limits")}
    one, two = palpate.Simulation(scene), palpate.Simulation(palpate.Model.from_scene(scene), **settings)
    one.run(3)
    two.run(3)
    assert one.state_hash == two.state_hash


def test_relax_takes_overlaps_out():
    model = palpate.Model()
    points, tets = palpate.box((3, 3, 3), (0.1, 0.1, 0.1))
    for i in range(2):
        model.add_body(points + [0, 0, 0.095 * i], tets, material=palpate.Material(**SOFT))
    simulation = palpate.Simulation(model, gravity=(0, 0, 0), relax={})
    assert simulation.relaxed.relaxed and simulation.relaxed.deepest_before > 0.004
    assert simulation.relaxed.deepest_after <= simulation.relaxed.allowed_depth
    assert palpate.Simulation(model, gravity=(0, 0, 0)).relaxed is None


def test_what_is_no_callback_is_refused_before_a_step():
    simulation = palpate.Simulation(palpate.stacking_scene(2, (3, 3, 1)))
    with pytest.raises(palpate.Error, match="callback: found int"):
        simulation.run(1, callback=3)
    with pytest.raises(palpate.Error, match="pressure: found an array of shape"):
        simulation.set_pressure([0, 1], [1.0, 2.0, 3.0])
    assert simulation.metrics.step == 0


def test_callbacks_see_each_step_and_can_end_the_run():
    simulation = palpate.Simulation(block())
    seen = []
    assert simulation.run(10, callback=lambda s: seen.append(s.metrics.step)) == 10
    assert seen == list(range(1, 11))
    assert simulation.run(10, callback=lambda s: s.metrics.step == 13) == 3

    def fail(_):
        raise RuntimeError("mine")

    with pytest.raises(RuntimeError, match="mine"):
        simulation.run(10, callback=fail)
    assert simulation.metrics.step == 14


def test_a_run_lasts_as_long_as_the_scene_says(root):
    scene = palpate.read_scene(root / "scenes/ball-on-plate.json")
    scene["duration"], scene["time_step"] = 0.1, 0.01
    simulation = palpate.Simulation(scene)
    assert simulation.run() == 10 and simulation.run() == 0


def test_progress_goes_to_stderr(capsys):
    palpate.Simulation(block()).run(3, progress=True)
    shown = capsys.readouterr()
    assert "3/3" in shown.err and shown.out == ""


def test_a_run_that_blows_up_says_where_and_keeps_the_last_good_step():
    simulation = palpate.Simulation(block(), limits={"max_speed": 0.5})
    with pytest.raises(palpate.Error, match="body 0.*max_speed") as caught:
        simulation.run(100)
    assert "step" in caught.value.where
    assert simulation.metrics.largest_speed <= 0.5 and np.isfinite(simulation.positions).all()


def test_ctrl_c_ends_a_run_between_two_steps():
    script = """
import palpate, sys
simulation = palpate.Simulation(palpate.stacking_scene(count=4, cells=(4, 4, 1)))
def ready(s):
    if s.metrics.step == 3: print("ready", flush=True)
try:
    simulation.run(10**9, callback=ready)
except KeyboardInterrupt:
    simulation.step()
    print("interrupted", simulation.metrics.step > 3, flush=True)
"""
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    process.send_signal(2)
    rest, _ = process.communicate(timeout=60)
    assert (rest, process.returncode) == ("interrupted True\n", 0)


def test_two_simulations_in_two_threads():
    results = []

    def work():
        simulation = palpate.Simulation(palpate.stacking_scene(count=4, cells=(4, 4, 1)), threads=2)
        simulation.run(10)
        results.append(simulation.state_hash)

    in_threads(work, 2)
    assert len(results) == 2 and results[0] == results[1]


def test_one_simulation_in_two_threads_makes_whole_steps_or_refuses():
    scene = palpate.stacking_scene(count=4, cells=(4, 4, 1))
    shared, refusals = palpate.Simulation(scene), []

    def work():
        for _ in range(20):
            try:
                shared.step()
            except palpate.Error as error:
                refusals.append(str(error))

    in_threads(work, 3)
    assert all("one thread at a time" in text for text in refusals)
    alone = palpate.Simulation(scene)
    alone.run(shared.metrics.step)
    assert shared.metrics.step >= 1 and alone.state_hash == shared.state_hash


def test_scene_errors_name_file_and_key(tmp_path):
    file = tmp_path / "bad.json"
    for text, words in [
        ("{", "bad.json"),
        ('{"bodies": []}', "bodies"),
        ('{"bodies": [{"ball": {"radius": -1, "resolution": 2}, "material": {}}]}', r"bodies\[0\].ball.radius"),
        ('{"bodies": [{"mesh": "none.vtu", "material": {}}]}', "none.vtu"),
    ]:
        file.write_text(text)
        with pytest.raises(palpate.Error, match=words):
            palpate.Simulation(file)
    with pytest.raises(palpate.Error, match="no such file"):
        palpate.Simulation(tmp_path / "none.json")
    with pytest.raises(palpate.Error, match="a path of|the path of"):
        palpate.Simulation(7)
    with pytest.raises(palpate.Error, match="time_stp.*time_step"):
        palpate.Simulation(block(), time_stp=0.1)
    with pytest.raises(palpate.Error):
        palpate.Simulation(block(), time_step=float("nan"))
    with pytest.raises(palpate.Error, match="bodies|materials|at least"):
        palpate.Simulation(palpate.Model())


def test_bad_models_are_refused_and_stay_as_they_were():
    model = block()
    points, tets = palpate.box((2, 2, 2), (1, 1, 1))
    soft = palpate.Material()
    for call, words in [
        (lambda: model.add_body(points, tets), "material"),
        (lambda: model.add_body(points.T, tets, material=soft), "give points.T"),
        (lambda: model.add_body(points, tets, material=soft, fixed=[99]), "fixed"),
        (lambda: model.add_body(points, tets, material=soft, fixed=np.zeros(5, bool)), "mask"),
        (lambda: model.add_body(points, tets, material=soft, velocity=(0, 1)), "velocity"),
        (lambda: model.add_body(points, tets, obstacle=True, self_collision=True), "self_collision"),
        (lambda: model.attach(0, [0], 0), "itself"),
        (lambda: model.attach(0, [0], 5), "body"),
        (lambda: model.load(0, [10**6], (0, 0, 1)), "points"),
        (lambda: model.load(3, [0], (0, 0, 1)), "body"),
        (lambda: model.grab(0, -1, (0, 0, 0), 1.0), "point"),
        (lambda: model.add_region(0, [10**6], soft), "tets"),
        (lambda: palpate.Motion([palpate.Keyframe(0.0)], interpolation="smoth"), "smooth"),
    ]:
        with pytest.raises(palpate.Error, match=words):
            call()
    assert len(model.bodies) == 1
    simulation = palpate.Simulation(model)
    for call in [lambda: simulation.set_force(10**6, (0, 0, 0)), lambda: simulation.set_force(0, (np.nan, 0, 0)),
                 lambda: simulation.grab(0, (0, 0, 0), -1.0), lambda: simulation.grab(-1, (0, 0, 0), 1.0)]:
        with pytest.raises(palpate.Error):
            call()
    with pytest.raises(palpate.Error, match="young_modulus"):
        palpate.Material(young_modulus=-1.0)


def test_a_restored_simulation_goes_on_with_the_same_bits(tmp_path):
    scene = palpate.stacking_scene(count=4, cells=(4, 4, 1))
    one = palpate.Simulation(scene)
    one.run(20)
    (tmp_path / "state").write_bytes(one.save())
    before = one.contacts.depth.copy()
    one.run(20)
    two = palpate.Simulation(scene, threads=2)
    two.restore((tmp_path / "state").read_bytes())
    assert two.metrics.step == 20 and np.array_equal(two.contacts.depth, before)
    two.run(20)
    assert two.state_hash == one.state_hash
    for wrong in [b"", b"nonsense", one.save()[:-1], bytes(reversed(one.save()))]:
        with pytest.raises(palpate.Error):
            two.restore(wrong)
    with pytest.raises(palpate.Error):
        palpate.Simulation(block()).restore(one.save())
    assert two.state_hash == one.state_hash


@pytest.mark.parametrize("changed", [
    {"contact": {"friction": 0.0}}, {"gravity": (0, 0, -1.6)}, {"solver": {"tolerance": 1e-7}},
    {"contact": {"stiffness": 500.0}}, {"contact": {"damping": 0.0}},
])
def test_a_restored_simulation_has_the_settings_that_were_changed(changed):
    """Restored ones went on with the settings of the scene, and said nothing."""
    scene = {
        "contact": {"friction": 0.5},
        "bodies": [
            {"name": "floor", "box": {"cells": [4, 4, 1], "size": [0.4, 0.4, 0.02]}, "translate": [0, 0, -0.01],
             "obstacle": True},
            {"name": "block", "box": {"cells": [2, 2, 1], "size": [0.08, 0.08, 0.04]}, "translate": [0, 0, 0.0201],
             "velocity": [0.5, 0, 0], "material": {}},
        ],
    }
    simulation = palpate.Simulation(scene, threads=1)
    simulation.run(5)
    before = simulation.save()
    simulation.change(**changed)
    simulation.run(5)
    saved = simulation.save()
    other = palpate.Simulation(scene, threads=1)
    other.restore(saved)
    assert other.state_hash == simulation.state_hash
    for one in (simulation, other):
        one.run(20)
    assert other.state_hash == simulation.state_hash
    # And back to the settings of a state before the change.
    other.restore(before)
    unchanged = palpate.Simulation(scene, threads=1)
    unchanged.run(25)
    other.run(20)
    assert other.state_hash == unchanged.state_hash


def test_a_change_after_a_restore_keeps_the_other_settings():
    """It brought the settings of the scene back."""
    scene = {
        "gravity": [0, 0, 0],
        "units": {"length": "mm"},
        "bodies": [{"name": "ball", "ball": {"radius": 20, "resolution": 2}, "material": {}}],
    }
    one = palpate.Simulation(scene, threads=1)
    one.change(gravity=(0, 0, -2000))
    other = palpate.Simulation(scene, threads=1)
    other.restore(one.save())
    for simulation in (one, other):
        simulation.change(contact={"friction": 0.2})
        simulation.run(10)
        assert simulation.velocities[:, 2].mean() == pytest.approx(-200)
    assert other.state_hash == one.state_hash


def test_a_change_in_a_stage_keeps_the_settings_of_the_stage():
    """It brought the gravity of the scene back."""
    simulation = palpate.Simulation(
        {
            "bodies": [{"name": "ball", "ball": {"radius": 0.02, "resolution": 2}, "material": {}}],
            "stages": [
                {"name": "falls", "until": {"time": 0.1}},
                {"name": "drifts", "gravity": [0, 0, 0], "until": {"time": 1.0}},
            ],
        },
        threads=1,
    )
    simulation.run(15)
    before = simulation.velocities.mean(axis=0)
    simulation.change(contact={"friction": 0.2})
    simulation.run(5)
    assert before[2] < -0.5
    assert simulation.velocities.mean(axis=0) == pytest.approx(before)
