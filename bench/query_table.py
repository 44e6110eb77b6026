#!/usr/bin/env python3
"""Writes the table of the query in docs/benchmarks.md from the JSON of palpate_bench_query.

Usage: query_table.py JSON [MARKDOWN]   (without MARKDOWN: prints)

In MARKDOWN the text between the two marks 'query table' is replaced.
"""

import page


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


if __name__ == "__main__":
    page.write_table(__doc__, "query", table)
