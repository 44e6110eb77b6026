#!/usr/bin/env python3
"""Writes the table of collision handling in docs/benchmarks-detection.md from handling.json of `palpate bench speed`.

Usage: handling_table.py JSON [MARKDOWN]   (without MARKDOWN: prints)

In MARKDOWN the text between the two marks 'handling table' is replaced.
"""

import page


def rows(cases):
    yield "| scene | work | ms | part for contacts, ms |"
    yield "|---|---|---:|---:|"
    for case in cases:
        if "border_edges" in case:
            edges = case["border_edges"]
            yield f"| {case['name']} | {case['edges']} border edges against triangles | {edges['ms']:.3f} | – |"
            yield f"| {case['name']} | {case['edges']} border edges against triangles, Embree: {edges['embree_mode']} | {edges['embree_ms']:.3f} | – |"
        for mode, words in (("clustered", "whole detection, without coherence"), ("coherent", "whole detection, with coherence")):
            if mode in case:
                yield f"| {case['name']} | {words} | {case[mode]['all_ms']:.3f} | {case[mode]['contacts_ms']:.3f} |"


def table(report):
    return "\n".join([page.machine(report), "", *rows(report["cases"])]) + "\n"


if __name__ == "__main__":
    page.write_table(__doc__, "handling", table)
