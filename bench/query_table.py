#!/usr/bin/env python3
"""Writes the tables of the query in docs/benchmarks-detection.md from query.json of `palpate bench speed`.

Usage: query_table.py JSON [MARKDOWN]   (without MARKDOWN: prints)

In MARKDOWN the text between the two marks 'query table' is replaced.
"""

import page


def embree_of(times):
    """Name and time of Embree's best mode."""
    modes = {name.removeprefix("Embree: "): time for name, time in times.items() if name.startswith("Embree")}
    best = min(modes, key=modes.get, default=None)
    return best, modes.get(best)


def times_faster(slow, fast):
    return f"{slow / fast:.1f}×" if slow and fast else "–"


def row(scene):
    times, least = scene["median_ms"], scene["smallest_ms"]
    ours, coherent = times["clustered"], times.get("coherent")
    mode, embree = embree_of(times)
    single = times.get("single tets")

    def relative_time(name):
        return f"{ours / times[name]:.0%}" if name in times else "–"

    cells = [
        scene["name"], f"{scene['tets']}", f"{scene['points']}", f"{scene['pairs']}", f"{ours:.3f}", f"{coherent:.3f}" if coherent else "–",
        f"{single:.2f} ({times_faster(single, ours)})" if single else "–", f"{embree:.2f}, {mode}" if embree else "–",
        f"**{times_faster(embree, ours)}**", f"**{times_faster(embree, coherent)}**", f"{1e6 * ours / scene['tets']:.1f}",
        relative_time("clustered, AVX2"), relative_time("clustered, SSE4"),
        f"{least['clustered, 1 thread'] / least['clustered, 2 threads']:.2f}×" if single else "–",
    ]
    return "| " + " | ".join(cells) + " |"


def table(report):
    lines = [
        page.machine(report),
        "",
        "| scene | tets | points | pairs | full rebuild, ms | coherent, ms | single tets, ms | best mode of Embree, ms "
        "| faster than Embree | coherent | ns a tet | speed with AVX2 | with SSE4 | 2 threads |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    return "\n".join(lines + [row(scene) for scene in report["cases"]]) + "\n"


if __name__ == "__main__":
    page.write_table(__doc__, "query", table)
