"""A study of 200 coarse runs of scenes/skull.json on a local Dask cluster that loses a worker on the way.

    ./dev python bench/skull_study.py [FOLDER] [RUNS]

20 plans of the lower jaw (1 to 10.5 mm forwards) with 10 stiffnesses of the soft tissue. Coarse: the plan is driven in
eight long steps, no overlaps are removed first, the solver stops early. When a tenth of the runs are done a worker
process is killed (SIGKILL). Then the last rows are made again in this process: they must have the same bits. Writes
bench/results/skull_study.csv, and keeps finished runs in FOLDER (default: build/skull-study): started again, it continues
where it was.
"""

import os
import pathlib
import signal
import sys
import threading
import time

import numpy as np
from distributed import Client, LocalCluster

import palpate

ROOT = pathlib.Path(__file__).parent.parent
STEPS = 8


def plan(scene, values):
    """The jaw's path and the tissue's stiffness, in eight coarse steps."""
    scene.update(time_step=0.05, solver={"tolerance": 0.01, "max_solves": 4})
    scene.pop("relax", None)
    bodies = {body["name"]: body for body in scene["bodies"]}
    bodies["lower jaw"]["motion"]["keyframes"] = [{"time": 0.0}, {"time": 0.4, "translate": [0, -values["forward"], 0]}]
    bodies["upper jaw"]["motion"]["keyframes"] = [{"time": 0.0}]
    bodies["soft tissue"]["material"]["young_modulus"] = values["young_modulus"]


def outcome(simulation):
    """How far the chin's side of the soft tissue followed, mm."""
    tissue = simulation.bodies["soft tissue"].points
    rest = simulation.bodies.points_rest[tissue]
    moved = simulation.positions[tissue] - rest
    low = rest[:, 2] < -60
    return {"chin_forward": -float(moved[low, 1].mean()), "largest_move": float(np.linalg.norm(moved, axis=1).max())}


def kill_a_worker(client, folder, after):
    """Once `after` runs are kept: ends a worker process at once."""
    while len(list((folder / "runs").glob("*.json"))) < after:
        time.sleep(0.2)
    workers = client.scheduler_info()["workers"]
    address, pid = next(iter(client.run(os.getpid).items()))
    busy = client.processing().get(address, ())
    os.kill(pid, signal.SIGKILL)
    print(f"killed worker {address} of {len(workers)}, which had {len(busy)} runs to do", flush=True)


def main(folder, runs):
    """Makes the study, and says what became of it."""
    samples = [{"forward": f, "young_modulus": e} for e in np.linspace(5e3, 50e3, 10) for f in 1.0 + 0.5 * np.arange(20)]
    samples = samples[:runs]
    start = time.perf_counter()
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        killer = threading.Thread(target=kill_a_worker, args=(client, folder, runs // 10), daemon=True)
        killer.start()
        table = palpate.sweep(ROOT / "scenes/skull.json", samples, apply=plan, measure=outcome, steps=STEPS,
                              client=client, folder=folder, progress=True)
    seconds = time.perf_counter() - start
    again = palpate.sweep(ROOT / "scenes/skull.json", samples[-2:], apply=plan, measure=outcome, steps=STEPS, workers=1)
    same = list(again["state_hash"]) == list(table["state_hash"][-2:])
    done = (table["status"] == "done").sum()
    print(f"{done} of {runs} runs done, {(table['status'] == 'failed').sum()} failed, in {seconds:.0f} s "
          f"({table['seconds'].sum():.0f} s of runs); bits of runs made again in this process: "
          f"{'the same' if same else 'OTHERS'}")
    if runs == 200:
        table.to_csv(ROOT / "bench/results/skull_study.csv", index=False)
    return 0 if done == runs and same else 1


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/skull-study"),
                  int(sys.argv[2]) if len(sys.argv) > 2 else 200))
