#!/usr/bin/env python3
"""Writes the table of measured speed-ups in docs/benchmarks-instructions.md from threads.json of `palpate bench speed`.

Usage: threads_table.py JSON [MARKDOWN]   (without MARKDOWN: prints)

In MARKDOWN the text between the two marks 'threads table' is replaced.
"""

import page

PHASES = {"all": "whole", "grid": "update of the grid", "contacts": "contacts of points", "border edges": "border edges",
          "crossings": "crossings, edge contacts", "depth": "depths", "forces": "contact forces", "solver": "solver"}


def rows(cases):
    counts = [times["threads"] for times in cases[0]["times"]]
    yield f"| scene | part | 1 thread, ms | {' | '.join(f'{count} threads' for count in counts[1:])} |"
    yield "|---|---|---:|" + "---:|" * (len(counts) - 1)
    for case in cases:
        one, *others = case["times"]
        for phase, words in PHASES.items():
            if phase in one:
                faster = " | ".join(f"{times[phase]['faster']:.2f}×" for times in others)
                yield f"| {case['name']} | {words} | {one[phase]['ms']:.3f} | {faster} |"


def table(report):
    return "\n".join([page.machine(report), "", *rows(report["cases"])]) + "\n"


if __name__ == "__main__":
    page.write_table(__doc__, "threads", table)
