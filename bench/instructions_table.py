#!/usr/bin/env python3
"""Writes the table of instructions in docs/benchmarks.md from instructions.json of `palpate bench speed`.

Usage: instructions_table.py JSON [MARKDOWN]   (without MARKDOWN: prints)

In MARKDOWN the text between the two marks 'instructions table' is replaced.
"""

import page


def rows(cases):
    yield "| kernel | instructions | for each | of them in a frame | frames |"
    yield "|---|---:|---|---:|---:|"
    for case in cases:
        each = case["units"] / case["frames"]
        yield f"| {case['name']} | {case['per_unit']:.1f} | {case['unit']} | {each:.0f} | {case['frames']} |"


def table(report):
    machine = report["machine"]
    head = (f"{machine['cpu']}; {machine['compiler']}, {machine['build_type']}; commit `{machine['commit']}`; {report['date']}; "
            "one thread, AVX2, counted by callgrind.")
    return "\n".join([head, "", *rows(report["cases"])]) + "\n"


if __name__ == "__main__":
    page.write_table(__doc__, "instructions", table)
