#!/usr/bin/env python3
"""Runs palpate_bench_sort and writes one JSON file: run_sorts.py PROGRAM JSON

One process for each size and motion; within it the repetitions of all competitors are interleaved at random, so that
a disturbance of the machine meets all of them. Exits with 1 if any result was wrong.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

REPETITIONS = {8192: 7, 131072: 7, 1048576: 5, 10000000: 2}
MOTIONS = ["0", "2_near", "10_near", "100_near", "100_random"]


def run_group(program, entries, motion, folder):
    out = folder / "group.json"
    subprocess.run([program, f"--benchmark_filter=/{entries}/{motion}$", "--benchmark_enable_random_interleaving=true",
                    f"--benchmark_repetitions={REPETITIONS[entries]}", "--benchmark_min_time=0.02",
                    f"--benchmark_out={out}", "--benchmark_out_format=json"],
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return json.loads(out.read_text())


def main(arguments):
    if len(arguments) != 2:
        raise SystemExit(__doc__)
    program, result = arguments
    merged = None
    with tempfile.TemporaryDirectory() as folder:
        for entries in REPETITIONS:
            for motion in MOTIONS:
                try:
                    report = run_group(program, entries, motion, pathlib.Path(folder))
                except subprocess.CalledProcessError as error:
                    raise SystemExit(f"{entries} entries, {motion}: exit {error.returncode}") from error
                report["context"]["executable"] = pathlib.Path(program).name  # not where it lay on this machine
                report["benchmarks"] = [run for run in report["benchmarks"] if run["run_type"] == "iteration"]
                if merged is None:
                    merged = report
                else:
                    merged["benchmarks"] += report["benchmarks"]
                # After each group, so that a run that is broken off leaves what it has.
                pathlib.Path(result).write_text(json.dumps(merged, indent=1) + "\n")
                print(f"{entries} entries, {motion}: done", file=sys.stderr)


if __name__ == "__main__":
    main(sys.argv[1:])
