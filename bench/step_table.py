#!/usr/bin/env python3
"""Writes the table of whole steps in docs/benchmarks-steps.md from step.json of `palpate bench speed`.

Usage: step_table.py JSON [MARKDOWN]   (without MARKDOWN: prints)

In MARKDOWN the text between the two marks 'step table' is replaced.
"""

import page

# Those that a result has; before multigrid there were two others.
PRECONDITIONERS = ("auto", "jacobi", "two-level", "factor", "multigrid")


def rows(cases):
    yield "| scene | step | ms | largest ms | iterations | contacts | SOFA ms | ratio | SOFA ms, scaled | ratio |"
    yield "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|"
    for case in cases:
        runs = [("25 iterations, one solve", case["fixed"])]
        runs += [(f"to an error of 1e-3, {key}", case["converged"][key]) for key in PRECONDITIONERS if key in case["converged"]]
        for words, run in runs:
            sofa, scaled = case["sofa_ms"], case["sofa_scaled_ms"]
            yield (f"| {case['name']} ({case['tets']} tets) | {words} | {run['ms']:.2f} | {run['largest_ms']:.2f} | "
                   f"{run['iterations']:.0f} | {run['contacts']} | {sofa} | {sofa / run['ms']:.1f}× | {scaled:.1f} | {scaled / run['ms']:.1f}× |")


def table(report):
    return "\n".join([page.machine(report), "", *rows(report["cases"])]) + "\n"


if __name__ == "__main__":
    page.write_table(__doc__, "step", table)
