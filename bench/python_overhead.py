"""Overhead of World.update over the C++ call that it makes, at 10k tets.

    ./dev python bench/python_overhead.py

Runs the paper's stacking scene (10000 tets) at positions that it takes in a simulation. World.times is measured in C++,
around the phases of the same call, so that the difference of the two is what Python costs: arguments, the lock of the
interpreter, and forgetting the last results. Single calls are compared, and medians of the differences told, since a
call of 0.1 ms varies by more than its overhead. The same is done with a call that finds no work (two far bodies of one
tet), where the clock around the call leaves no room to hide.
"""

import statistics
import time

import numpy as np

import palpate

FRAMES, ROUNDS = 40, 25


def overhead(world, frames):
    """Medians over all calls, in us: of the call, of what C++ says it took, and of the difference."""
    calls, inside = [], []
    for _ in range(ROUNDS):
        for frame in frames:
            start = time.perf_counter_ns()
            world.update(frame)
            calls.append((time.perf_counter_ns() - start) / 1000)
            times = world.times
            inside.append(1e6 * (times.grid + times.contacts + times.border_edges + times.crossings + times.depth))
    differences = [call - part for call, part in zip(calls, inside)]
    return statistics.median(calls), statistics.median(inside), statistics.median(differences)


def main():
    """Prints a table."""
    palpate.set_threads(1)
    simulation = palpate.Simulation(palpate.stacking_scene())
    frames = []
    simulation.run(FRAMES, callback=lambda s: frames.append(s.positions))
    stack = palpate.World.from_scene(palpate.stacking_scene())
    empty = palpate.World()
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    empty.add(corners, [[0, 1, 2, 3]])
    empty.add(corners + 100, [[0, 1, 2, 3]])
    nothing = [np.concatenate([corners, corners + 100])]
    overhead(stack, frames[:2]), overhead(empty, nothing)  # warm
    print("call, us   in C++, us   difference, us")
    for name, world, positions in [("stacking, 10000 tets", stack, frames), ("two tets", empty, nothing * FRAMES)]:
        print("{:8.1f}   {:10.1f}   {:14.2f}   {}".format(*overhead(world, positions), name))


if __name__ == "__main__":
    main()
