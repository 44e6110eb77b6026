#!/usr/bin/env python3
"""Writes the table of the query in docs/benchmarks.md from the JSON of palpate_bench_query.

Usage: query_table.py JSON [MARKDOWN]   (without MARKDOWN: prints)

In MARKDOWN the text between the two marks 'query table' is replaced.
"""

import json
import pathlib
import re
import sys

BEGIN, END = "<!-- query table: begin -->", "<!-- query table: end -->"


def row(scene):
    times = scene["median_ms"]
    ours = times["clustered"]
    embree = {name: time for name, time in times.items() if name.startswith("Embree")}
    best = min(embree, key=embree.get)

    def share(name):
        return f"{ours / times[name]:.0%}" if name in times else "–"

    cells = [
        scene["scene"], f"{scene['tets']}", f"{scene['points']}", f"{scene['pairs']}", f"{ours:.3f}",
        f"{times['single tets']:.3f} ({times['single tets'] / ours:.1f}×)",
        f"{embree[best]:.2f}, {best.removeprefix('Embree: ')}", f"**{embree[best] / ours:.1f}×**",
        f"{1e6 * ours / scene['tets']:.1f}", share("clustered, AVX2"), share("clustered, SSE4"),
        f"{scene['smallest_ms']['clustered, 1 thread'] / scene['smallest_ms']['clustered, 2 threads']:.2f}×",
    ]
    return "| " + " | ".join(cells) + " |"


def table(report):
    lines = [
        f"{report['cpu']}, {report['cores']} cores; {report['compiler']}; commit `{report['commit']}`; load of the machine "
        f"meanwhile: {', '.join(f'{x:.1f}' for x in report['load'])}.",
        "",
        "| scene | tets | points | pairs | clustered, ms | single tets, ms | best mode of Embree, ms | faster than Embree | ns a tet "
        "| speed with AVX2 | with SSE4 | 2 threads |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    lines += [row(scene) for scene in report["scenes"]]
    return "\n".join(lines) + "\n"


def main(arguments):
    if len(arguments) not in (1, 2):
        raise SystemExit(__doc__)
    text = table(json.loads(pathlib.Path(arguments[0]).read_text()))
    if len(arguments) == 1:
        print(text, end="")
        return
    path = pathlib.Path(arguments[1])
    page = path.read_text()
    marked = re.compile(re.escape(BEGIN) + ".*?" + re.escape(END), re.DOTALL)
    if not marked.search(page):
        raise SystemExit(f"{path}: no marks '{BEGIN}' and '{END}'")
    path.write_text(marked.sub(lambda _: f"{BEGIN}\n{text}{END}", page))


if __name__ == "__main__":
    main(sys.argv[1:])
