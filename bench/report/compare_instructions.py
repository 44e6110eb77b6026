#!/usr/bin/env python3
"""Compares counts of instructions: compare_instructions.py OLD.json NEW.json   (instructions.json of `palpate bench speed`)

For each kernel: instructions a unit of work (tet, contact, …), new over old. Counts of one compiler repeat to a thousandth, whatever else the
machine does, so a kernel counts as dearer or cheaper where the ratio is off by more than 2 %.

Exit codes: 0 nothing is dearer, 1 something is, or a kernel is no longer counted, 2 bad usage.
"""

import json
import pathlib
import sys

SMALLEST = 0.02


def read(name):
    try:
        report = json.loads(pathlib.Path(name).read_text())
        report["machine"]["compiler"], report["date"]
        return report, {case["name"]: (case["per_unit"], case["unit"]) for case in report["cases"]}
    except (OSError, ValueError, KeyError, TypeError) as error:
        print(f"compare_instructions.py: {name}: found no counts ({error}), expected those of './dev bench instructions'", file=sys.stderr)
        raise SystemExit(2) from None


def work_of(report):
    """What was counted on: other work has other counts for that alone."""
    return sorted({(case.get("cells"), case["frames"]) for case in report["cases"]})


def verdict_of(ratio):
    return "dearer" if ratio > 1.0 + SMALLEST else "cheaper" if ratio < 1.0 - SMALLEST else "-"


def main(arguments):
    if len(arguments) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    (old, before), (new, now) = read(arguments[0]), read(arguments[1])
    for key in ("cpu", "compiler", "build_type"):
        if old["machine"].get(key) != new["machine"].get(key):
            print(f"note: {key}: {old['machine'].get(key)} before, {new['machine'].get(key)} now: counts differ for that alone")
    if work_of(old) != work_of(new):
        print(f"note: (cells, frames) {work_of(old)} before, {work_of(new)} now: counts differ for that alone")
    print(f"before: {old['machine']['commit']}, {old['date']}\nnow:    {new['machine']['commit']}, {new['date']}")
    verdicts = []
    for name, (count, unit) in now.items():
        if name not in before:
            print(f"   new  {count:10.1f} instructions a {unit}: {name}")
            continue
        ratio = count / before[name][0]
        verdicts.append(verdict_of(ratio))
        print(f"{ratio:6.3f}  {before[name][0]:10.1f} to {count:10.1f} instructions a {unit}  {verdicts[-1]:7}  {name}")
    lost = [name for name in before if name not in now]
    if lost:
        print("no longer counted: " + ", ".join(lost))
    print(f"{len(verdicts)} compared: {verdicts.count('dearer')} dearer, {verdicts.count('cheaper')} cheaper, the rest within {100 * SMALLEST:.0f} %")
    return 1 if "dearer" in verdicts or lost else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
