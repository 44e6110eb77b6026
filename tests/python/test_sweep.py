"""sweep(): rows against runs made by hand, failures, resuming, dying workers, Dask, Ctrl-C."""

import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
import warnings

import numpy as np
import pandas
import pytest

import palpate
import study_helpers
from palpate._sweep import set_value

SCENE = palpate.stacking_scene(count=2, cells=(2, 2, 1))
STIFFNESS = "bodies[1].material.young_modulus"


def test_a_grid_has_a_row_for_each_combination_with_the_bits_of_a_run():
    table = palpate.sweep(SCENE, {STIFFNESS: [1e4, 1e5], "contact.friction": [0.0, 0.2, 0.4]}, steps=4, workers=2)
    assert list(table["status"]) == ["done"] * 6 and (table["steps"] == 4).all()
    assert [tuple(row) for row in table[[STIFFNESS, "contact.friction"]].to_numpy()] == [
        (e, f) for e in [1e4, 1e5] for f in [0.0, 0.2, 0.4]]
    scene = palpate.stacking_scene(count=2, cells=(2, 2, 1))
    scene["bodies"][1]["material"]["young_modulus"] = 1e5
    scene["contact"]["friction"] = 0.2
    simulation = palpate.Simulation(scene)
    simulation.run(4)
    row = table.iloc[4]
    assert row["state_hash"] == simulation.state_hash
    assert row["kinetic_energy"] == simulation.metrics.kinetic_energy


def test_samples_functions_and_measures():
    samples = pandas.DataFrame({"stiffness": [2e4, 3e4, 2e4]})
    table = palpate.sweep(SCENE, samples, apply=study_helpers.stiffness_of, measure=study_helpers.heights, steps=2,
                          workers=1)
    assert len(table) == 3 and list(table["stiffness"]) == [2e4, 3e4, 2e4]
    assert table["height"].notna().all() and table["first"][0] == table["first"][2]
    assert table["state_hash"][0] == table["state_hash"][2] != table["state_hash"][1]


STAGED = {
    "name": "staged", "time_step": 0.01,
    "bodies": [{"name": "block", "box": {"cells": [1, 1, 1], "size": [0.1, 0.1, 0.1]}, "material": {}}],
    "stages": [{"name": "fall", "until": {"time": 0.03}}, {"name": "rest", "until": {"rest": True, "most": 0.02}}],
    "outcomes": [{"name": "sunk", "displacement": {"body": "block", "along": [0, 0, -1]}}],
}


def test_outcomes_of_stages_are_columns(tmp_path):
    """Free fall in steps of implicit Euler: n (n + 1) / 2 g h^2."""
    table = palpate.sweep(STAGED, {"gravity[2]": [-10.0, -20.0]}, workers=1, folder=tmp_path)
    for row, g in zip(table.to_dict("records"), (10, 20)):
        assert row["status"] == "done" and row["steps"] == 5
        assert row["fall.sunk"] == pytest.approx(6 * g * 1e-4) and row["rest.sunk"] == row["sunk"] == pytest.approx(15 * g * 1e-4)
        assert row["warnings"] == "stage 'rest' ended after 0.02 s, not at rest"
    again = palpate.sweep(STAGED, {"gravity[2]": [-10.0, -20.0]}, workers=1, folder=tmp_path)
    assert again.equals(table)
    plain = palpate.sweep(SCENE, {"time_step": [0.01]}, steps=1, workers=1)
    assert "warnings" not in plain and not any("." in column for column in plain)


def test_another_mesh_under_the_same_name_is_another_run(tmp_path):
    def write(size):
        points, tets = palpate.box((1, 1, 1), (size, size, size))
        lines = ["MeshVersionFormatted 2", "Dimension 3", f"Vertices {len(points)}", *(f"{x} {y} {z} 0" for x, y, z in points),
                 f"Tetrahedra {len(tets)}", *(" ".join(str(c + 1) for c in tet) + " 0" for tet in tets), "End", ""]
        (tmp_path / "box.mesh").write_text("\n".join(lines))

    def run():
        row, = palpate.sweep_rows({**STAGED, "gravity": [0, 0, -10]}, [{"bodies.block.mesh": str(tmp_path / "box.mesh")}],
                                  apply=study_helpers.other_mesh, workers=1, folder=tmp_path)
        return row

    write(0.1)
    first = run()
    assert first["status"] == "done" and run()["seconds"] == first["seconds"]
    write(0.2)
    assert run()["kinetic_energy"] == pytest.approx(8 * first["kinetic_energy"])


@pytest.mark.filterwarnings("ignore:sweep")
def test_failures_are_rows():
    table = palpate.sweep(SCENE, {"time_step": [0.01, -1.0], "nothing.there": [1]}, steps=2, workers=1)
    assert list(table["status"]) == ["failed", "failed"] and "nothing" in table["error"][0]
    table = palpate.sweep(SCENE, {"time_step": [0.01, -1.0]}, steps=2, workers=1)
    assert list(table["status"]) == ["done", "failed"] and "time_step" in table["error"][1]
    table = palpate.sweep(SCENE, {"time_step": [0.01]}, measure=study_helpers.refuse, steps=2, workers=1)
    assert "RuntimeError: measured nothing" in table["error"][0]


def test_one_warning_tells_how_many_runs_failed_and_why():
    """The columns of a measure that always fails are missing: pandas alone would tell that by a KeyError."""
    with pytest.warns(UserWarning) as told:
        table = palpate.sweep(SCENE, {"time_step": [0.01, 0.005]}, measure=study_helpers.refuse, steps=1, workers=1)
    assert "height" not in table
    assert len(told) == 1 and told[0].filename == __file__
    text = str(told[0].message)
    assert text.startswith("sweep: 2 of 2 runs failed, the first by: RuntimeError: measured nothing (line ")
    assert "\n" not in text
    with pytest.warns(UserWarning, match="^sweep: 1 of 2 runs failed, the first by: scene: time_step"):
        palpate.sweep_rows(SCENE, {"time_step": [0.01, -1.0]}, steps=1, workers=1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        palpate.sweep_rows(SCENE, {"time_step": [0.01]}, steps=1, workers=1)


@pytest.mark.filterwarnings("ignore:sweep")
def test_a_measure_whose_result_is_no_column_is_a_failed_row_that_says_so():
    """Each of these runs is done; its row is not. Nothing that the row has is overwritten."""
    def error_of(measure, **arguments):
        row, = palpate.sweep_rows(SCENE, {"time_step": [0.01]}, measure=measure, steps=1, workers=1, **arguments)
        assert row["status"] == "failed" and row["traceback"] == "" and row["time_step"] == 0.01
        return row["error"]

    def three(simulation):
        return 3

    assert error_of(three) == (f"sweep: measure three (line {three.__code__.co_firstlineno} of {__file__}): found the result 3, "
                               "expected a mapping of names to values")
    for measure, found in [
        (lambda _: None, "the result None"),
        (lambda _: {"l": threading.Lock()}, "a lock for 'l', which cannot be sent to another process"),
        (lambda _: {"status": 1}, "the name 'status', which another column has"),
        (lambda _: {"time_step": 1}, "the name 'time_step', which another column has"),
        (lambda _: {"warnings": 1}, "the name 'warnings', which another column has"),
    ]:
        assert re.match(rf"sweep: measure <lambda> \(line \d+ of .*test_sweep\.py\): found {found}, ", error_of(measure) + ", ")
    row, = palpate.sweep_rows(SCENE, {"time_step": [0.01]}, steps=1, workers=1,
                              measure=lambda _: {"of": {"a": [1]}, "series": pandas.Series([1.0, 2.0]), "number": np.int64(3)})
    assert row["status"] == "done" and (row["of"], row["series"], row["number"]) == ({"a": [1]}, [1.0, 2.0], 3)


@pytest.mark.filterwarnings("ignore:sweep")
def test_an_outcome_with_the_name_of_a_column_is_refused():
    scene = {**STAGED, "outcomes": [{**STAGED["outcomes"][0], "name": "status"}]}
    row, = palpate.sweep_rows(scene, {"time_step": [0.01]}, workers=1)
    assert row["status"] == "failed" and "sweep: outcomes: found the name 'status', which another column has" in row["error"]


def test_functions_that_cannot_be_called_or_sent_are_refused_at_once():
    def refusal(**arguments):
        with pytest.raises(palpate.Error) as refused:
            palpate.sweep_rows(SCENE, {"time_step": [0.01]}, steps=1, workers=1, **arguments)
        return refused.value

    for name, expected in [("measure", "a function of the Simulation, or None"),
                           ("apply", "a function of the scene and the values of a run, or None")]:
        assert str(refusal(**{name: 3})) == f"sweep: {name}: found 3, expected {expected}"
        assert isinstance(refusal(**{name: 3}), TypeError)
        assert re.fullmatch(rf"sweep: {name} <lambda> \(line \d+ of .*\): found the arguments \(a, b, c\), expected a function of .*",
                            str(refusal(**{name: lambda a, b, c: {}})))
    lock = threading.Lock()
    refused = refusal(measure=lambda _: {"locked": lock.locked()})
    assert refused.where == "measure" and "lock" in refused.found
    assert "cloudpickle" not in refused.expected, "it is installed, and cannot help"
    assert refusal(apply=lambda *_: lock).where == "apply"
    with pytest.raises(palpate.Error, match=r"sweep: parameters\['status'\]: found the name of another column"):
        palpate.sweep_rows(SCENE, [{"status": 1}], apply=lambda *_: None, workers=1)


def test_a_study_goes_on_where_it_was(tmp_path):
    values = [1e4, 2e4, 3e4]
    first = palpate.sweep(SCENE, {STIFFNESS: values[:2]}, steps=2, workers=1, folder=tmp_path)
    kept = {file: file.stat().st_mtime_ns for file in (tmp_path / "runs").iterdir()}
    assert len(kept) == 2
    second = palpate.sweep(SCENE, {STIFFNESS: values}, steps=2, workers=1, folder=tmp_path)
    assert first.equals(second.iloc[:2])  # also the seconds: the runs were not repeated
    assert all(file.stat().st_mtime_ns == written for file, written in kept.items())
    damaged = next(iter(kept))
    damaged.write_text("{")
    third = palpate.sweep(SCENE, {STIFFNESS: values}, steps=2, workers=1, folder=tmp_path)
    assert list(third["state_hash"]) == list(second["state_hash"])
    other = palpate.sweep(SCENE, {STIFFNESS: values}, steps=3, workers=1, folder=tmp_path)
    assert (other["steps"] == 3).all()


@pytest.mark.filterwarnings("ignore:sweep")
def test_failed_runs_are_kept_unless_they_shall_be_made_again(tmp_path):
    wrong = {"time_step": [-1.0]}
    first = palpate.sweep(SCENE, wrong, steps=1, workers=1, folder=tmp_path)
    again = palpate.sweep(SCENE, wrong, steps=1, workers=1, folder=tmp_path)
    assert first["seconds"][0] == again["seconds"][0]
    again = palpate.sweep(SCENE, wrong, steps=1, workers=1, folder=tmp_path, retry_failed=True)
    assert again["seconds"][0] != first["seconds"][0]


def test_a_run_whose_process_dies_is_made_again(tmp_path):
    samples = [{"number": i, "folder": str(tmp_path)} for i in range(5)]
    table = palpate.sweep(SCENE, samples, apply=study_helpers.die_once, steps=1, workers=2)
    assert list(table["status"]) == ["done"] * 5
    assert (tmp_path / "died-2").exists()


@pytest.mark.filterwarnings("ignore:sweep")
def test_a_run_that_always_dies_is_a_failed_row():
    table = palpate.sweep(SCENE, [{"number": i} for i in range(2)], apply=study_helpers.die_always, steps=1, workers=1)
    assert list(table["status"]) == ["done", "failed"] and "died" in table["error"][1]


def test_a_dask_cluster_that_loses_a_worker_loses_no_run():
    import distributed

    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None,
                                  silence_logs=50) as cluster, distributed.Client(cluster) as client:
        pids = client.run(lambda: __import__("os").getpid())
        victim = next(iter(pids.values()))
        killed = threading.Timer(0.1, lambda: os.kill(victim, signal.SIGKILL))
        killed.start()
        table = palpate.sweep(SCENE, {STIFFNESS: np.linspace(1e4, 1e5, 30)}, steps=60, client=client)
        killed.join()
        with pytest.raises(ProcessLookupError):  # it was killed, and its nanny has seen it
            for _ in range(600):
                os.kill(victim, 0)
                time.sleep(0.05)
    assert list(table["status"]) == ["done"] * 30
    alone = palpate.sweep(SCENE, {STIFFNESS: [1e4, 1e5]}, steps=60, workers=1)
    assert list(alone["state_hash"]) == [table["state_hash"][0], table["state_hash"][29]]


def test_ctrl_c_ends_a_study_and_keeps_what_is_done(tmp_path):
    script = f"""
import palpate
if __name__ == "__main__":
    scene = palpate.stacking_scene(count=2, cells=(2, 2, 1))
    try:
        palpate.sweep(scene, {{"bodies[1].material.young_modulus": [1e4 + i for i in range(1000)]}}, steps=20, workers=1,
                      folder={str(tmp_path)!r})
    except KeyboardInterrupt:
        print("interrupted")
"""
    (tmp_path / "study.py").write_text(script)
    process = subprocess.Popen([sys.executable, tmp_path / "study.py"], stdout=subprocess.PIPE, text=True)
    end = time.monotonic() + 60
    while len(list((tmp_path / "runs").glob("*.json"))) < 2 and time.monotonic() < end:
        time.sleep(0.05)
    process.send_signal(2)
    output, _ = process.communicate(timeout=60)
    assert output == "interrupted\n"
    rows = [json.loads(file.read_text()) for file in (tmp_path / "runs").glob("*.json")]
    assert 2 <= len(rows) < 1000 and all(row["status"] == "done" for row in rows)


def test_paths_of_values():
    scene = {"bodies": [{"name": "liver", "material": {"density": 1}}], "gravity": [0, 0, -9.81]}
    set_value(scene, "bodies[0].material.density", 2)
    set_value(scene, "bodies.liver.material.young_modulus", 3)
    set_value(scene, "gravity[2]", 4)
    assert scene == {"bodies": [{"name": "liver", "material": {"density": 2, "young_modulus": 3}}],
                     "gravity": [0, 0, 4]}
    for path in ["bodies[1].material", "bodies.spleen.material", "contact.friction.of", "gravity.x.y", "gravity[3]"]:
        with pytest.raises(palpate.Error, match="sweep"):
            set_value(scene, path, 0)


def test_bad_arguments():
    for arguments in [dict(parameters={"time_step": 0.01}), dict(parameters={"time_step": "abc"}),
                      dict(parameters=[1, 2]), dict(parameters={"time_step": [0.01]}, workers=0),
                      dict(parameters={"time_step": [0.01]}, client=object()),
                      dict(parameters={"time_step": [float("nan")]})]:
        with pytest.raises(palpate.Error):
            palpate.sweep(SCENE, **arguments)
    with pytest.raises(palpate.Error, match="bodies"):
        palpate.sweep({"bodies": []}, {"time_step": [0.01]})
    assert len(palpate.sweep(SCENE, {"time_step": []})) == 0
