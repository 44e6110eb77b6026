#!/usr/bin/env python3
"""Writes the table of whole steps in docs/benchmarks.md from the JSON of palpate_bench_step.

Usage: step_table.py JSON [MARKDOWN]   (without MARKDOWN: prints)

In MARKDOWN the text between the two marks 'step table' is replaced.
"""

import page

# What we set out to reach, times SOFA's step with 25 iterations: with as many, and converged.
MUST = {"stacking at rest": (12, 5), "head": (6, 3)}
PRECONDITIONERS = ("auto", "jacobi", "two-level", "factor")


def rows(cases):
    yield "| scene | step | ms | largest ms | iterations | contacts | SOFA ms | ratio | must |"
    yield "|---|---|---:|---:|---:|---:|---:|---:|---|"
    for case in cases:
        fixed_must, converged_must = MUST[case["name"]]
        runs = [("25 iterations, one solve", case["fixed"], fixed_must)]
        runs += [(f"to an error of 1e-3, {key}", case["converged"][key], converged_must) for key in PRECONDITIONERS]
        for words, run, must in runs:
            ratio = case["sofa_ms"] / run["ms"]
            yield (f"| {case['name']} ({case['tets']} tets) | {words} | {run['ms']:.2f} | {run['largest_ms']:.2f} | "
                   f"{run['iterations']:.0f} | {run['contacts']} | {case['sofa_ms']} | {ratio:.1f}× | "
                   f"{must}×, {'met' if ratio >= must else 'missed'} |")


def table(report):
    return "\n".join([page.machine(report), "", *rows(report["cases"])]) + "\n"


if __name__ == "__main__":
    page.write_table(__doc__, "step", table)
