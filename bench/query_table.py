#!/usr/bin/env python3
"""Writes the tables of the query in docs/benchmarks.md from the JSON of palpate_bench_query.

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

    def share(name):
        return f"{ours / times[name]:.0%}" if name in times else "–"

    cells = [
        scene["scene"], f"{scene['tets']}", f"{scene['points']}", f"{scene['pairs']}", f"{ours:.3f}", f"{coherent:.3f}" if coherent else "–",
        f"{single:.2f} ({times_faster(single, ours)})" if single else "–", f"{embree:.2f}, {mode}" if embree else "–",
        f"**{times_faster(embree, ours)}**", f"**{times_faster(embree, coherent)}**", f"{1e6 * ours / scene['tets']:.1f}",
        share("clustered, AVX2"), share("clustered, SSE4"),
        f"{least['clustered, 1 thread'] / least['clustered, 2 threads']:.2f}×" if single else "–",
    ]
    return "| " + " | ".join(cells) + " |"


def rows_of_musts(scenes):
    """(what, must, measured, met) for each row of the issue's table that this program measures."""
    def rows(what, must, value, form="{:.1f}×", at_most=False):
        if value is not None:
            met = value <= must if at_most else value >= must
            yield what, ("≤ " if at_most else "≥ ") + form.format(must), form.format(value), met

    def ratio(name, way="clustered"):
        scene = scenes.get(name)
        if scene is None or way not in scene["median_ms"]:
            return None
        return embree_of(scene["median_ms"])[1] / scene["median_ms"][way]

    small, large = "stacking 10000", "stacking 1000000"
    for name, must in ((small, 27), ("stacking 102400", 24), (large, 18)):
        yield from rows(f"full rebuild against Embree, {name}", must, ratio(name))
    for name, must in ((small, 50), (large, 28)):
        yield from rows(f"with coherence, {name}", must, ratio(name, "coherent"))
    yield from rows("unstructured (pile), full rebuild", 18, ratio("pile"))
    yield from rows("self-collision, 10000 tets, full rebuild", 20, ratio("self-collision"))
    for name, must in ((small, 1.5), (large, 1.85)):
        if name in scenes:
            least = scenes[name]["smallest_ms"]
            yield from rows(f"2 threads, {name}", must, least["clustered, 1 thread"] / least["clustered, 2 threads"], "{:.2f}×")
    if small in scenes:
        scene = scenes[small]
        times = scene["median_ms"]
        yield from rows(f"AVX2 against the best target, {small}", 0.55, times["clustered"] / times["clustered, AVX2"], "{:.0%}")
        if "handling" in scene:
            whole = scene["handling"]["clustered"]
            yield from rows(f"whole collision handling against finding contacts, {small}", 2.5,
                            whole["all_ms"] / whole["contacts_ms"], at_most=True)
        huge = max(scenes.values(), key=lambda s: s["tets"])
        if huge["tets"] > 5e6:
            growth = huge["median_ms"]["clustered"] / huge["tets"] / (times["clustered"] / scene["tets"])
            yield from rows(f"growth of ns a tet, {scene['tets']} to {huge['tets']}", 2.3, growth, at_most=True)


def table(report):
    scenes = {scene["scene"]: scene for scene in report["scenes"]}
    lines = [
        f"{report['cpu']}, {report['cores']} cores; {report['compiler']}; commit `{report['commit']}`; load of the machine "
        f"meanwhile: {', '.join(f'{x:.1f}' for x in report['load'])}.",
        "",
        "| scene | tets | points | pairs | full rebuild, ms | coherent, ms | single tets, ms | best mode of Embree, ms "
        "| faster than Embree | coherent | ns a tet | speed with AVX2 | with SSE4 | 2 threads |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    lines += [row(scene) for scene in report["scenes"]]
    lines += ["", "| must | at least / at most | measured | |", "|---|---:|---:|---|"]
    lines += [f"| {what} | {must} | {value} | {'met' if met else '**missed**'} |" for what, must, value, met in rows_of_musts(scenes)]
    for scene in report["scenes"]:
        if "handling" in scene:
            clustered, coherent = scene["handling"]["clustered"], scene["handling"]["coherent"]
            lines += ["", f"The whole of a detection, {scene['scene']}: {clustered['all_ms']:.3f} ms, of these {clustered['contacts_ms']:.3f} "
                      f"for contacts; with coherence {coherent['all_ms']:.3f} and {coherent['contacts_ms']:.3f} ms."]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    page.write_table(__doc__, "query", table)
