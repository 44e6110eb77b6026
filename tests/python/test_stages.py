"""Stages, outcomes and constraints. Oracles: formulas of free fall, the command, and the run driven by hand."""

import json
import os
import subprocess

import numpy as np
import pytest

import palpate

BODIES = [
    {"name": "table", "box": {"cells": [2, 2, 1], "size": [0.3, 0.3, 0.04]}, "translate": [0, 0, -0.02], "obstacle": True},
    {"name": "block", "box": {"cells": [2, 2, 2], "size": [0.1, 0.1, 0.1]}, "translate": [0, 0, 0.06],
     "material": {"young_modulus": 1e5, "stiffness_damping": 0.01}},
]
STAGES = [
    {"name": "move", "until": {"time": 0.06}, "move": [
        {"body": "block", "motion": {"interpolation": "smooth", "keyframes": [{"time": 0.05, "translate": [0.05, 0, 0]}]}}]},
    {"name": "rest", "release": [{"body": "block"}], "until": {"rest": True, "most": 2}},
]
OUTCOMES = [
    {"name": "shift", "displacement": {"body": "block"}},
    {"name": "weight", "force": {"body": "block", "along": [0, 0, 1]}},
    {"name": "volume", "volume": {"body": "block", "beyond": [{"point": [0, 0, 0], "normal": [0, 0, 1]}]}},
]
SCENE = {"name": "staged", "time_step": 0.01, "bodies": BODIES, "stages": STAGES, "outcomes": OUTCOMES}


def test_stages_run_as_the_command_runs_them(tmp_path):
    simulation = palpate.Simulation(SCENE)
    assert simulation.stage == "move" and not simulation.stages_done
    steps = simulation.run()
    assert simulation.stages_done and simulation.stage == "rest"
    assert simulation.stage_endings == [(6, True), (steps, True)]
    palpate.write_scene(SCENE, tmp_path / "scene.json")
    subprocess.run([os.environ["PALPATE_COMMAND"], "run", "scene.json", "--no-picture", "--out", "out", "--quiet"],
                   cwd=tmp_path, check=True)
    told = json.loads((tmp_path / "out/outcomes.json").read_text())
    assert told["state_hash"] == simulation.state_hash
    outcomes = simulation.outcomes()
    assert list(outcomes) == ["shift", "weight", "volume"]
    assert list(simulation.stage_outcomes) == ["move", "rest"] and simulation.stage_warnings == []
    for row in told["outcomes"]:
        outcome = outcomes[row["name"]]
        for stage in row["stages"]:
            assert simulation.stage_outcomes[stage["stage"]][row["name"]].value == stage["value"]
        assert (outcome.value, outcome.unit, outcome.kind) == (row["value"], row["unit"], row["kind"])
        assert (outcome.vector is None) == ("vector" not in row)
    assert outcomes["weight"].value == pytest.approx(9.81, rel=1e-3)
    np.testing.assert_allclose(outcomes["shift"].vector[0], 0.05, atol=1e-4)


def test_a_staged_run_is_the_one_driven_by_hand():
    led = palpate.Simulation(SCENE)
    led.run()
    hand = palpate.Simulation({key: value for key, value in SCENE.items() if key != "stages"}, threads=1)
    block = hand.bodies["block"]
    motion = palpate.Motion([palpate.Keyframe(0.0), palpate.Keyframe(0.05, (0.05, 0, 0))], interpolation="smooth")
    assert block.move(motion) == 0
    hand.run(6)
    block.release()
    hand.run(led.metrics.step - 6)
    assert hand.state_hash == led.state_hash


def test_stages_are_in_a_saved_state():
    whole = palpate.Simulation(SCENE)
    whole.run(3)
    before = whole.save()
    whole.run(3)
    between = whole.save()
    whole.run()
    for saved in (before, between):
        other = palpate.Simulation(SCENE, threads=1)
        other.restore(saved)
        other.run()
        assert other.state_hash == whole.state_hash
        assert [list(of.values())[0].value for of in other.stage_outcomes.values()] \
            == [list(of.values())[0].value for of in whole.stage_outcomes.values()]
    with pytest.raises(palpate.Error, match="saved state"):
        whole.restore(b"123")


def test_a_plate_that_is_put_into_bone_is_told():
    plate = {"name": "plate", "box": {"cells": [1, 1, 1], "size": [0.1, 0.1, 0.02]}, "translate": [0, 0, 0.3], "absent": True, "obstacle": True}
    stage = {"name": "put", "insert": ["plate"], "until": {"time": 0.02},
             "move": [{"body": "plate", "motion": {"keyframes": [{"time": 0.01, "translate": [0.09, 0, -0.3]}]}}]}
    simulation = palpate.Simulation({"time_step": 0.01, "bodies": [*BODIES, plate], "stages": [stage]})
    assert simulation.stage_warnings == []
    simulation.run()
    assert simulation.stage_warnings == ["stage 'put' puts 'plate' into 'table', by 0.01 m at its end"]


def test_bodies_without_contact_fall_through_each_other():
    falling = {**BODIES[1], "no_contact": ["table"]}
    simulation = palpate.Simulation({"bodies": [BODIES[0], falling], "time_step": 0.01})
    simulation.run(30)
    assert len(simulation.contacts) == 0 and simulation.positions[-1, 2] < -0.1
    with pytest.raises(palpate.Error, match=r"bodies\[1\].no_contact\[0\]: found 'tabel', expected another body: 'table'"):
        palpate.Simulation({"bodies": [BODIES[0], {**BODIES[1], "no_contact": ["tabel"]}]})


def test_bodies_are_removed_fixed_tied_and_brought_in():
    simulation = palpate.Simulation({"bodies": BODIES, "time_step": 0.01})
    table, block = simulation.bodies["table"], simulation.bodies["block"]
    simulation.run(60)
    table.remove()
    assert not table.is_present and len(simulation.contacts) == 0
    high = block.positions[:, 2].mean()
    simulation.run(3)
    fall = 0.5 * 9.81 * 0.01**2 * 3 * 4
    assert high - block.positions[:, 2].mean() == pytest.approx(fall, rel=0.03)
    block.fix()
    held = block.positions
    simulation.run(2)
    assert (block.positions == held).all()
    table.insert()
    assert table.is_present
    low = np.flatnonzero(simulation.positions[:, 2] < 0.02)
    tied = low[low >= block.points.start]
    simulation.tie(tied, "table")
    assert len(simulation.tie_forces) == len(tied) > 0
    assert simulation.untie("block", "table") == len(tied)
    assert simulation.untie("block", "table") == 0
    with pytest.raises(palpate.Error, match="'table', which is in the simulation already"):
        simulation.insert("table")
    with pytest.raises(palpate.Error, match="rigid body 'table'"):
        table.fix()
    assert simulation.outcomes() == {} and simulation.stage is None and simulation.stages_done
