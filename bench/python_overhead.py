"""Overhead of World.update over the C++ call that it makes, at 10k tets.

    ./dev python bench/python_overhead.py [--instructions]

The paper's stacking scene (10000 tets), at its start, where nothing touches yet, and while it falls. A loop in Python that
calls update() is compared with a loop in C++ that makes the same calls, alternately, by the time that the processor spent;
what is told are medians over the rounds. A detection with contacts varies by more than the overhead, so the same is done
with two bodies of one tet each, where little else is left; and --instructions counts the instructions of both loops in
the fallen stack under valgrind, which no other program disturbs.
"""

import re
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np

import palpate

CALLS = 50
ROUNDS = 41


def scenes():
    """(name, world, positions): the stack, and as good as nothing."""
    simulation = palpate.Simulation(palpate.stacking_scene(), threads=1)
    simulation.run(10)
    stack = palpate.World.from_scene(palpate.stacking_scene(), threads=1)
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    nothing = palpate.World(threads=1)
    nothing.add(corners, [[0, 1, 2, 3]])
    nothing.add(corners + 100, [[0, 1, 2, 3]])
    return [("stacking while it falls, 10000 tets", stack, simulation.positions),
            ("stacking at its start, 10000 tets", stack, stack.bodies.points_rest),
            ("two tets", nothing, np.concatenate([corners, corners + 100]))]


def in_python(world, positions, calls):
    """The loop in Python."""
    for _ in range(calls):
        world.update(positions)


def in_cpp(world, positions, calls):
    """The loop in C++."""
    world._update_again(positions, calls)


def microseconds(loop, world, positions):
    """Of one call in a loop."""
    start = time.thread_time_ns()
    loop(world, positions, CALLS)
    return (time.thread_time_ns() - start) / 1000 / CALLS


def measure_times():
    """Prints a row for each scene."""
    print("Python, us   C++, us   difference, us")
    for name, world, positions in scenes():
        world.update(positions)
        pairs = [(microseconds(in_python, world, positions), microseconds(in_cpp, world, positions))
                 for _ in range(ROUNDS)]
        python, cpp = (statistics.median(column) for column in zip(*pairs))
        print(f"{python:10.2f}   {cpp:7.2f}   {statistics.median(a - b for a, b in pairs):14.2f}   {name}")


def count(script):
    """Instructions that a program executes."""
    done = subprocess.run(["valgrind", "--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null",
                           sys.executable, "-c", script], capture_output=True, text=True, check=True,
                          env={"PYTHONHASHSEED": "0", "PYTHONPATH": ":".join(sys.path), "PATH": "/usr/bin:/bin",
                               "OPENBLAS_NUM_THREADS": "1"})
    return int(re.search(r"I\s+refs:\s+([\d,]+)", done.stderr)[1].replace(",", ""))


def count_instructions():
    """Prints how many instructions more a call from Python is: slopes, so that what comes before counts nothing."""
    _, world, positions = scenes()[0]
    with tempfile.NamedTemporaryFile(suffix=".npz") as file:
        np.savez(file, positions=positions)
        file.flush()
        slopes = []
        for loop in ["for _ in range({}): world.update(p)", "world._update_again(p, {})"]:
            script = (f"import numpy, palpate; p = numpy.load({file.name!r})['positions']\n"
                      "world = palpate.World.from_scene(palpate.stacking_scene(), threads=1); world.update(p)\n")
            few, many = (count(script + loop.format(calls)) for calls in (2, 22))
            slopes.append((many - few) / 20)
    print(f"instructions of a call: {slopes[0]:.0f} from Python, {slopes[1]:.0f} from C++, {slopes[0] - slopes[1]:.0f} more")


if __name__ == "__main__":
    count_instructions() if "--instructions" in sys.argv[1:] else measure_times()
