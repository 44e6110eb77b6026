"""What forces, fields and driving cost.

    ./dev python bench/forces_cost.py COMMAND [--calls | --fields | --instructions]

COMMAND is the palpate command of the same build. Three parts, all of them without a choice:

--calls         a call with 1000 points: from Python, and of that what the compiled part takes (the same call with arrays
                that need no check), by the time that the thread spent; medians.
--fields        all fields of the eye's 10160 tets after a few steps, against a step of it: the same.
--instructions  under valgrind's callgrind: share of a step's instructions that is copying what acted, with nothing asked
                for, and with reactions and a row of forces.csv, in a small stack that falls and comes to rest; and
                all fields of the eye against the mean of its first 40 steps, with the copies that a frame gets.
"""

import json
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time
import typing

import numpy as np

import palpate
from palpate._names import Field

STEPS = 40
ROOT = pathlib.Path(__file__).resolve().parent.parent


def round_of(call, calls):
    """Microseconds of one call, the mean of a round."""
    start = time.thread_time_ns()
    for _ in range(calls):
        call()
    return (time.thread_time_ns() - start) / 1000 / calls


def microseconds(call, calls=30, rounds=15):
    """Of one call, the median of rounds."""
    return statistics.median(round_of(call, calls) for _ in range(rounds))


def compared(python, compiled, calls=20, rounds=41):
    """Of two calls, made alternately: the median of each, and of their differences."""
    pairs = [(round_of(python, calls), round_of(compiled, calls)) for _ in range(rounds)]
    whole, inner = (statistics.median(column) for column in zip(*pairs))
    return whole, inner, statistics.median(a - b for a, b in pairs)


def measure_calls():
    """A row for each call."""
    points, tets = palpate.box((14, 14, 9), (1.0, 1.0, 0.6))
    model = palpate.Model()
    model.add_body(points, tets, name="block", material=palpate.Material())
    model.add_body(points + [0, 0, 2.0], tets, name="probe", motion=palpate.Motion([palpate.Keyframe(0.0)]))
    simulation = palpate.Simulation(model, threads=1)
    chosen = np.arange(1000)
    exact = chosen.astype(np.int32)
    mask = np.zeros(len(simulation.positions), dtype=bool)
    mask[:1000] = True
    values = np.random.default_rng(1).normal(size=(1000, 3))
    triangles = np.arange(1000)
    probe = simulation.bodies["probe"]
    rows = [
        ("set_forces(indices, (1000, 3))", lambda: simulation.set_forces(chosen, values), lambda: simulation._set_forces(exact, values)),
        ("set_forces(mask, (3))", lambda: simulation.set_forces(mask, values[0]), lambda: simulation._set_forces(exact, values)),
        ("set_pressure(1000 triangles)", lambda: simulation.set_pressure(triangles, 1.0),
         lambda: simulation._set_pressure(triangles.astype(np.int32), 1.0)),
        ("set_velocities((1000, 3), indices)", lambda: simulation.set_velocities(values, chosen),
         lambda: simulation._set_velocities(exact, values)),
        ("set_positions((1000, 3), indices)", lambda: simulation.set_positions(points[:1000], chosen),
         lambda: simulation._set_positions(exact, points[:1000])),
        ("bodies['probe'].move_to(matrix)", lambda: probe.move_to(np.eye(4)),
         lambda: simulation._move_to(0, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))),
    ]
    print("Python, us   compiled part, us   beyond it, us")
    for name, python, compiled in rows:
        whole, inner, beyond = compared(python, compiled)
        print(f"{whole:10.1f}   {inner:17.1f}   {beyond:13.1f}   {name}")


def measure_fields():
    """All fields against a step of the eye."""
    simulation = palpate.Simulation(ROOT / "scenes/eye.json", threads=1, reactions=True)
    steps = []
    for _ in range(40):
        start = time.thread_time_ns()
        simulation.step()
        steps.append((time.thread_time_ns() - start) / 1e6)
    step = statistics.mean(steps)
    tets = microseconds(simulation.tissue, 3) / 1000
    both = microseconds(lambda: simulation.tissue_at_points(simulation.tissue()), 3) / 1000
    points = microseconds(simulation.tissue_at_points, 3) / 1000
    surface = microseconds(simulation.tractions, 3) / 1000
    print(f"{len(simulation.bodies.tets)} tets: a step {step:.1f} ms (mean of the first 40, {min(steps):.1f} to {max(steps):.1f})")
    for what, time_of in [("all fields of the tets", tets), ("with those of the points", both), ("those of the points alone", points),
                          ("tractions", surface), ("all of them", both + surface)]:
        print(f"{time_of:7.2f} ms {100 * time_of / step:5.1f} %  {what}")


def inclusive(text, function):
    """Instructions of a function with all that it calls, of callgrind_annotate --inclusive=yes."""
    found = [int(line.split("(")[0].replace(",", "")) for line in text.splitlines()
             if re.search(rf"\b{function}\(", line) and re.match(r"\s*[\d,]+ \(", line)]
    return max(found, default=0)


def traced(command, scene, folder, steps, *flags):
    """What callgrind counts in a run of a scene, by function, with what it calls."""
    trace = pathlib.Path(folder) / "trace"
    subprocess.run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={trace}", command, "run", scene, "--out", f"{folder}/out",
                    "--no-picture", "--quiet", "--threads", "1", "--steps", str(steps), *flags], check=True, capture_output=True, cwd=folder)
    return subprocess.run(["callgrind_annotate", "--inclusive=yes", "--threshold=100", "--show-percs=yes", trace],
                          check=True, capture_output=True, text=True).stdout


def count_instructions(command):
    """Shares of the instructions of a step."""
    command = pathlib.Path(command).resolve()
    with tempfile.TemporaryDirectory() as folder:
        scene = palpate.stacking_scene(8, (5, 5, 1))
        scene["duration"], scene["output"] = 1.0, {"every": 1000}
        file = pathlib.Path(folder) / "scene.json"
        file.write_text(json.dumps(scene))
        text = traced(command, file, folder, STEPS)
    step = inclusive(text, r"palpate::Simulation::step")
    print(f"a step of the stack: {step / STEPS / 1e6:.2f} million instructions")
    for what, function in [("copying what acted", r"StepForces::take"), ("sums over bodies", r"StepForces::sum_over_bodies"),
                           ("reactions (the command asks for them)", r"Dynamics::holding_forces"),
                           ("fixed axes, without any", r"AxisHolds::\w+"), ("forces.csv, beside the step", r"ForceProbe::forces")]:
        print(f"{100 * inclusive(text, function) / step:7.3f} %  {what}")
    with tempfile.TemporaryDirectory() as folder:
        every = 10
        text = traced(command, ROOT / "scenes/eye.json", folder, STEPS, "--every", str(every),
                      "--set", f"output.fields={json.dumps(typing.get_args(Field))}")
    step = inclusive(text, r"palpate::Simulation::step") / STEPS
    frames = STEPS // every + 1
    print(f"a step of the eye: {step / 1e6:.1f} million instructions")
    for what, function in [("all fields of the tets", r"fem::tissue_of_tets"), ("those of the points besides", r"fem::tissue_of_points"),
                           ("tractions", r"palpate::tractions_of"), ("all of them, with the copies of a frame", r"palpate::field_arrays")]:
        print(f"{100 * inclusive(text, function) / frames / step:7.2f} %  {what}")


if __name__ == "__main__":
    parts = set(sys.argv[2:]) or {"--calls", "--fields", "--instructions"}
    if "--calls" in parts:
        measure_calls()
    if "--fields" in parts:
        measure_fields()
    if "--instructions" in parts:
        count_instructions(sys.argv[1])
