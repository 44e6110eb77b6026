#!/usr/bin/env python3
"""Writes the table of instructions in docs/benchmarks-instructions.md from instructions.json of `palpate bench speed`.

Usage: instructions_table.py JSON [MARKDOWN]   (without MARKDOWN: prints)

In MARKDOWN the text between the two marks 'instructions table' is replaced.
"""

import page


def rows(cases):
    threads = cases[0]["parallel"]["speed_up"].keys()
    yield f"| kernel | instructions per unit | unit | units in a frame | frames | in parallel | {' | '.join(f'{n} threads' for n in threads)} |"
    yield "|---|---:|---|---:|---:|---:|" + "---:|" * len(threads)
    for case in cases:
        each = case["units"] / case["frames"]
        faster = " | ".join(f"{ratio:.2f}×" for ratio in case["parallel"]["speed_up"].values())
        yield (f"| {case['name']} | {case['per_unit']:.1f} | {case['unit']} | {each:.0f} | {case['frames']} | "
               f"{100 * case['parallel']['share']:.0f} % | {faster} |")


def table(report):
    machine = report["machine"]
    head = (f"Counted by callgrind on one thread with AVX2: {machine['cpu']}; {machine['compiler']}, {machine['build_type']}; "
            f"commit `{page.short_commit(machine['commit'])}`; {report['date']}.")
    return "\n".join([head, "", *rows(report["cases"])]) + "\n"


if __name__ == "__main__":
    page.write_table(__doc__, "instructions", table)
