#!/usr/bin/env python3
"""Writes the table of measured speed-ups in docs/benchmarks-instructions.md from threads.json of `palpate bench speed`.

Usage: threads_table.py JSON [MARKDOWN]   (without MARKDOWN: prints)

In MARKDOWN the text between the two marks 'threads table' is replaced.
"""

import page

PHASES = {"all_ms": "whole", "grid_ms": "update of the grid", "contacts_ms": "contacts of points", "border_edges_ms": "border edges",
          "crossings_ms": "crossings, edge contacts", "depth_ms": "depths", "forces_ms": "contact forces", "solver_ms": "solver"}


def rows(cases):
    counts = [times["threads"] for times in cases[0]["times"]]
    yield f"| scene | part | 1 thread, ms | {' | '.join(f'{count} threads' for count in counts[1:])} |"
    yield "|---|---|---:|" + "---:|" * (len(counts) - 1)
    for case in cases:
        one, *others = case["times"]
        for phase in (phase for phase in PHASES if phase in one):
            faster = " | ".join(f"{one[phase] / times[phase]:.2f}×" if times[phase] > 0.0 else "–" for times in others)
            yield f"| {case['name']} | {PHASES[phase]} | {one[phase]:.3f} | {faster} |"


def table(report):
    return "\n".join([page.machine(report), "", *rows(report["cases"])]) + "\n"


if __name__ == "__main__":
    page.write_table(__doc__, "threads", table)
