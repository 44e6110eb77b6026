#!/usr/bin/env python3
"""Writes the table of the steps of many scenes in docs/benchmarks-steps.md from step-scenes.json of `palpate bench step`.

Usage: step_scenes_table.py JSON [MARKDOWN]   (without MARKDOWN: prints)

In MARKDOWN the text between the two marks 'step scenes table' is replaced.
"""

import page


def short(value):
    """Three digits, and no exponent in what people compare."""
    if value == 0:
        return "0"
    if 100 <= abs(value) < 1e7:
        return f"{value:.0f}"
    return f"{value:.3g}"


def tally(value):
    return f"{short(value['mean'])} ({value['most']})"


def row_line(row):
    if "steps" not in row:
        return f"| {row['name']} | – | – | **failed**: {row['error']} |" + " |" * 10
    end = "at rest" if row["at_rest"] else ""
    if row["error"] is not None:
        end = f"**failed**: {row['error']}"
    bad = str(row["not_converged"]) if row["not_converged"] == 0 else f"**{row['not_converged']}**"
    divided = row.get("divided", "–")  # reports of earlier versions have none
    return (f"| {row['name']} | {row['tets']} | {row['steps']} | {tally(row['solves'])} | {tally(row['iterations'])} | {short(row['detections']['mean'])} | "
            f"{short(row['work'])} | {short(row['ms'])} | {100 * row['solver_share']:.0f} % | {divided} | {bad} | {row['inverted_tets']['most']} | "
            f"{short(row['deepest_um']['last'])} | {short(row['fastest_body_mm_s'])} | {end} |")


def table(report):
    threads = report["threads"]
    work = "one thread, processor time" if threads == 1 else f"{threads} threads"
    lines = [page.machine(report), "", f"A {report['effort']} run; {work}.", "",
             "| scene | tets | steps | solves | iterations | detections | work | ms | solver | divided | not converged | inverted tets | deepest, µm | fastest, mm/s | how it ended |",
             "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---|"]
    lines += [row_line(row) for row in report["rows"]]
    if report["left_out"]:
        reasons = {}
        for absent in report["left_out"]:
            reasons.setdefault(absent["reason"], []).append(absent["name"])
        lines += ["", "| left out | reason |", "|---|---|"]
        lines += [f"| {', '.join(names)} | {reason} |" for reason, names in reasons.items()]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    page.write_table(__doc__, "step scenes", table)
