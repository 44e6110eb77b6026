"""Kills runs with SIGKILL at random moments and resumes them: results must be those without the kill.

    python3 tests/apps/kill_runs.py PALPATE --runs 50 [--scene SCENE] [--steps N] [--interval N] [--seed N]

PALPATE is the command. For each run: start it with checkpoints, kill it, see that no more than the interval is lost, continue
from the last checkpoint (with another number of threads), and compare with the run that nobody killed: state hash, the rows of
metrics.csv but for times, and the list of frames. Exit code 0 where all are equal; prints a line of JSON.
"""

import argparse
import json
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import time


def rows_without_times(folder):
    lines = (folder / "metrics.csv").read_text().splitlines()
    names = lines[0].split(",")
    kept = [i for i, name in enumerate(names) if not name.startswith("wall_")]
    return [[line.split(",")[i] for i in kept] for line in lines]


def outcome(folder):
    report = json.loads((folder / "run.json").read_text())
    keys = ["state_hash", "steps", "at_rest", "contacts", "candidates", "movers", "solver", "kinetic_energy", "bodies"]
    return {key: report[key] for key in keys}, rows_without_times(folder), (folder / "frames.pvd").read_text()


def last_frame(folder):
    """The number of the last frame, which is the last completed step: each step has a frame."""
    found = [int(m.group(1)) for p in folder.glob("frames/frame_*.vtu") if (m := re.match(r"frame_(\d+)\.vtu", p.name))]
    return max(found, default=-1)


def last_checkpoint(folder):
    return max((int(p.stem.split("_")[1]) for p in folder.glob("checkpoints/step_*.palpate")), default=None)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("palpate")
    parser.add_argument("--scene", default=str(pathlib.Path(__file__).parents[2] / "scenes/ball-on-plate.json"))
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--steps", type=int, default=300)
    parser.add_argument("--interval", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    moments = random.Random(args.seed)
    first = [args.palpate, "run", args.scene, "--steps", str(args.steps), "--every", "1", "--no-picture", "--quiet"]
    lost_most, resumed_again, before_first = 0, 0, 0
    with tempfile.TemporaryDirectory() as temporary:
        root = pathlib.Path(temporary)
        started = time.monotonic()
        subprocess.run([*first, "--out", str(root / "whole")], check=True)
        duration = time.monotonic() - started
        whole = outcome(root / "whole")
        killed = 0
        while killed < args.runs:
            folder = root / f"run{killed}"
            process = subprocess.Popen([*first, "--out", str(folder), "--checkpoint-every", str(args.interval), "--threads", "1"])
            try:
                process.wait(timeout=moments.uniform(0.0, duration))
                continue  # it ended before the random moment: not killed
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            killed += 1
            step, checkpoint = last_frame(folder), last_checkpoint(folder)
            if checkpoint is None:
                assert step <= args.interval, f"step {step} was done, and there is no checkpoint"
                before_first += 1
                lost = max(step, 0)
                subprocess.run([*first, "--out", str(folder)], check=True)
            else:
                lost = step - checkpoint
                command = [args.palpate, "run", "--resume", str(folder), "--threads", "2", "--quiet"]
                again = subprocess.Popen(command)
                try:  # some of them are killed once more
                    again.wait(timeout=moments.uniform(0.0, 3.0 * duration))
                except subprocess.TimeoutExpired:
                    again.kill()
                    again.wait()
                    resumed_again += 1
                    again = subprocess.Popen(command)
                assert again.wait() == 0, f"exit code {again.returncode}"
            assert lost <= args.interval, f"{lost} steps lost, with a checkpoint every {args.interval}"
            lost_most = max(lost_most, lost)
            assert outcome(folder) == whole, f"run {killed}, killed at step {step}, ended otherwise"
    print(json.dumps({"killed": killed, "killed_again": resumed_again, "before_first_checkpoint": before_first,
                      "most_steps_lost": lost_most, "interval": args.interval, "state_hash": whole[0]["state_hash"]}))


if __name__ == "__main__":
    sys.exit(main())
