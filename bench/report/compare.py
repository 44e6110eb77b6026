#!/usr/bin/env python3
"""Compares what two reports measured: compare.py OLD.json NEW.json

For each thing measured in both: the ratio of medians, new over old, and bounds of noise. Work that is not ours (std::sort, memcpy, other
libraries) tells how fast the machine was: all ratios are divided by its median ratio. The bounds are those of the quartiles of both
samples, widened by how far the ratios of that other work spread. A thing counts as slower or faster where the bounds exclude 1, and by more
than 3 %.

Exit codes: 0 nothing is slower and all results are the same, 1 something is slower or other results were found, 2 bad usage,
no report, one that was not measured to its end, or nothing that is in both.
"""

import statistics
import sys

from reports import read

# What differs by less is nothing to act upon, however quiet the machine.
SMALLEST = 0.03


def measures_of(report):
    """{(section, name): measure}"""
    return {(section["id"], measure["name"]): measure for section in report["sections"] for measure in section.get("measures", [])}


def quartiles(values):
    if len(values) < 2:
        return (values[0], values[0]) if values else (1.0, 1.0)
    low, _, high = statistics.quantiles(values, n=4, method="inclusive")
    return low, high


def machine_ratio(old, new):
    """(median, lower quartile, upper quartile) of the ratios of work that is not ours, and how much there is of it."""
    ratios = [new[key]["median"] / old[key]["median"] for key in sorted(old.keys() & new.keys())
              if old[key]["reference"] and old[key]["median"] > 0]
    if not ratios:
        return 1.0, 1.0, 1.0, 0
    return statistics.median(ratios), *quartiles(ratios), len(ratios)


def compared(old_report, new_report):
    """Yields (section, name, ratio, low, high, verdict)."""
    old, new = measures_of(old_report), measures_of(new_report)
    middle, low_machine, high_machine, _ = machine_ratio(old, new)
    for key in new:
        if key not in old or new[key]["reference"] or not old[key]["lower_quartile"] > 0:
            continue
        before, after = old[key], new[key]
        ratio = after["median"] / before["median"] / middle
        low = after["lower_quartile"] / before["upper_quartile"] / high_machine
        high = after["upper_quartile"] / before["lower_quartile"] / low_machine
        verdict = "slower" if low > 1.0 and ratio > 1.0 + SMALLEST else "faster" if high < 1.0 and ratio < 1.0 - SMALLEST else "-"
        yield *key, ratio, low, high, verdict


def other_results(old_report, new_report):
    old = {section["id"]: section.get("result_hash") for section in old_report["sections"]}
    return [section["id"] for section in new_report["sections"]
            if old.get(section["id"]) and section.get("result_hash") and old[section["id"]] != section["result_hash"]]


def missing_sections(old_report, new_report):
    there = {section["id"] for section in new_report["sections"]}
    return [section["id"] for section in old_report["sections"] if section["id"] not in there]


def main(arguments):
    if len(arguments) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    old, new = read(arguments[0]), read(arguments[1])
    for key in ("cpu", "cores", "compiler", "build_type"):
        if old["machine"][key] != new["machine"][key]:
            print(f"note: {key}: {old['machine'][key]} before, {new['machine'][key]} now")
    if old["effort"] != new["effort"]:
        print(f"note: effort {old['effort']} before, {new['effort']} now: what frames were measured differs")
    middle, low, high, count = machine_ratio(measures_of(old), measures_of(new))
    print(f"before: {old['machine']['commit']}, {old['date']}\nnow:    {new['machine']['commit']}, {new['date']}")
    print(f"the machine: {count} times of work that is not ours took {middle:.3f} times as long (half of them {low:.3f} to {high:.3f})"
          if count else "the machine: no work in both reports tells how fast it was")
    missing = missing_sections(old, new)
    if missing:
        print("not measured now: " + ", ".join(missing))
    rows = list(compared(old, new))
    for section, name, ratio, bound_low, bound_high, verdict in sorted(rows, key=lambda row: -row[2]):
        print(f"{ratio:6.3f}  [{bound_low:6.3f}, {bound_high:6.3f}]  {verdict:6}  {section}: {name}")
    slower = sum(row[5] == "slower" for row in rows)
    print(f"{len(rows)} compared: {slower} slower, {sum(row[5] == 'faster' for row in rows)} faster, the rest within noise")
    # With another effort other frames are measured, so that other results are no fault.
    changed = other_results(old, new) if old["effort"] == new["effort"] else []
    if changed:
        print("other results than before: " + ", ".join(changed))
    if not rows and not changed:
        print(f"compare.py: {arguments[1]}: found nothing that {arguments[0]} has measured too, expected the same items", file=sys.stderr)
        return 2
    return 1 if slower or changed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
