#!/usr/bin/env python3
"""Counts cache misses of a detection with cells in linear order and along the Z-curve: cache_misses.py PROGRAM HEAD.json OUT.json

PROGRAM is palpate_bench_order; HEAD.json is a report whose machine, date and effort the new report OUT.json takes over. Counts with the
processor's counters (perf) where there are any, otherwise with valgrind's callgrind, which simulates two levels of cache. Callgrind knows
no AVX-512 and says so to programs, so that a narrower SIMD target runs there.
"""

import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SCENES = {10: "stacking 10000", 18: "stacking 32400"}
FRAMES = {10: 10, 18: 4}
ORDERS = ("linear", "z")
# Functions of the program, and what the table calls the time in them and in what they call.
PHASES = {"whole detection": "counted_frames(", "edge-triangle crossings": "palpate::ClusteredCrossings::find("}


def call(command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"cache_misses.py: '{' '.join(map(str, command))}' ended with {done.returncode}: {done.stderr.strip()[-300:]}")
    return done


def perf_works():
    if shutil.which("perf") is None:
        return False
    done = subprocess.run(["perf", "stat", "-x,", "-e", "cache-misses,L1-dcache-load-misses", "true"], capture_output=True, text=True, check=False)
    return done.returncode == 0 and "not supported" not in done.stderr and "not counted" not in done.stderr


def perf_counts(program, order, cells):
    """{phase: {event: count a frame}}, from the difference of a long and a short run; perf cannot see phases."""
    totals = []
    for frames in (FRAMES[cells], 11 * FRAMES[cells]):
        text = call(["perf", "stat", "-x,", "-e", "cache-misses,L1-dcache-load-misses", program, order, str(cells), str(frames)]).stderr
        rows = [line.split(",") for line in text.splitlines() if line.count(",") > 2]
        totals.append({row[2]: float(row[0]) for row in rows})
    long, short = totals[1], totals[0]
    each = {event: (long[event] - short[event]) / (10 * FRAMES[cells]) for event in long}
    return {"whole detection": {"first level": each["L1-dcache-load-misses"], "last level": each["cache-misses"]}}


def callgrind_counts(program, order, cells):
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out"
        call(["valgrind", "--tool=callgrind", "--cache-sim=yes", "--collect-atstart=no", "--toggle-collect=*counted_frames*",
              f"--callgrind-out-file={out}", program, order, str(cells), str(FRAMES[cells])])
        text = call(["callgrind_annotate", "--inclusive=yes", "--threshold=100", "--show=D1mr,D1mw,DLmr,DLmw", str(out)]).stdout
    found = {}
    for phase, function in PHASES.items():
        line = next((line for line in text.splitlines() if function in line), None)
        if line is None:
            raise SystemExit(f"cache_misses.py: callgrind counted nothing in {function})")
        numbers = [int(n.replace(",", "")) for n in re.findall(r"(?<![\w.])([\d,]+)(?= \(| )", line.split("  /")[0])[:4]]
        found[phase] = {"first level": (numbers[0] + numbers[1]) / FRAMES[cells], "last level": (numbers[2] + numbers[3]) / FRAMES[cells]}
    return found


def section_of(program):
    perf = perf_works()
    counts = perf_counts if perf else callgrind_counts
    how = "the processor's counters (perf)" if perf else "valgrind's callgrind, simulated caches, SIMD up to AVX2"
    rows, texts = [], []
    # Simulated counts do not depend on what else runs.
    with concurrent.futures.ThreadPoolExecutor(1 if perf else os.cpu_count()) as pool:
        counted = {(cells, order): pool.submit(counts, program, order, cells) for cells in SCENES for order in ORDERS}
    for cells, scene in SCENES.items():
        found = {order: counted[cells, order].result() for order in ORDERS}
        results = {order: call([program, order, str(cells), "1"]).stdout for order in ORDERS}
        if len(set(results.values())) != 1:
            raise SystemExit(f"cache_misses.py: {scene}: found other contacts with another order of cells: {results}")
        for phase in found["linear"]:
            for level in ("first level", "last level"):
                linear, z = found["linear"][phase][level], found["z"][phase][level]
                rows.append([scene, phase, level, linear, z, z / linear if linear else None])
                if level == "first level" and linear:
                    texts.append(f"{scene}, {phase}: {z / linear:.2f}")
    return {
        "id": "cache-misses", "title": "Cache misses: Z-curve against linear order",
        "paper": "Z-order makes edge-triangle queries about 8 % faster, because of the cache.",
        "ours": f"Data cache misses for each frame of a detection, counted by {how}; one thread; one order of cells after the other.",
        "verdict": "agrees" if all(row[5] is None or row[5] < 0.96 for row in rows if row[1] != "whole detection" and row[2] == "first level")
        and not perf else "not comparable" if perf else "differs",
        "why": "first-level misses with the Z-curve, divided by those with linear order: " + "; ".join(texts),
        "result_hash": "", "table": {"columns": ["scene", "phase", "cache", "linear, misses a frame", "Z-curve, misses a frame",
                                                 "Z-curve / linear"], "rows": rows},
        "charts": [], "measures": []}


def main(arguments):
    if len(arguments) != 3:
        raise SystemExit(__doc__)
    program, head, out = arguments
    report = {key: value for key, value in json.loads(pathlib.Path(head).read_text()).items() if key != "sections"}
    if shutil.which("valgrind") is None and not perf_works():
        raise SystemExit("cache_misses.py: found neither counters for perf nor valgrind")
    report.update(kind="cache misses", sections=[section_of(program)])
    pathlib.Path(out).write_text(json.dumps(report, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
