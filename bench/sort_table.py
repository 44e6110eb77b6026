#!/usr/bin/env python3
"""Writes the table of docs/benchmarks-sorts.md from the JSON of palpate_bench_sort.

Usage: sort_table.py JSON [MARKDOWN]   (without MARKDOWN: prints)

Takes the smallest time of each benchmark over its repetitions: what the work costs when nobody disturbs it.
In MARKDOWN the text between the two marks 'sort table' is replaced.
"""

import collections

import page

COLUMNS = {
    "std_sort_last_order": "std::sort, last order", "std_sort_reference_order": "std::sort, reference order",
    "comparison": "comparison", "radix": "radix", "counting": "counting (with C)", "repair": "repair",
    "adaptive": "adaptive", "radix_with_C": "radix + C", "repair_with_C": "repair + C",
}
MOTIONS = {"0": "0", "2_near": "2 % near", "10_near": "10 % near", "100_near": "100 % near", "100_random": "100 % random"}

def smallest_times(report):
    """(entries, motion) -> competitor -> smallest CPU time in ns for each entry."""
    times = collections.defaultdict(dict)
    for run in report["benchmarks"]:
        if run.get("run_type") != "iteration":
            continue
        if run.get("error_occurred"):
            raise SystemExit(f"{run['name']}: {run['error_message']}")
        competitor, entries, motion = run["run_name"].split("/")[:3]
        scale = {"ns": 1.0, "us": 1e3, "ms": 1e6}[run["time_unit"]]
        time = run["cpu_time"] * scale / int(entries)
        row = times[int(entries), motion]
        row[competitor] = min(time, row.get(competitor, time))
    return times


def table(report):
    context = report["context"]
    lines = [
        f"{context['cpu']}, {context['cores']} cores, one used; {context['compiler']}; commit `{page.short_commit(context['commit'])}`; "
        f"{context['date']}; load of the machine during the run: {', '.join(f'{x:.1f}' for x in context['load_avg'])}.",
        "",
        "CPU time per entry, ns. In brackets: the speed-up over std::sort from last frame's order, and the ratio to the time of memcpy.",
        "",
        "| entries | movers | memcpy | " + " | ".join(COLUMNS.values()) + " |",
        "|" + "---:|" * (3 + len(COLUMNS)),
    ]
    times = smallest_times(report)
    for entries in sorted({entries for entries, _ in times}):
        for motion, title in MOTIONS.items():
            row = times.get((entries, motion))
            if row is None:
                continue
            cells = []
            for competitor in COLUMNS:
                time = row[competitor]
                ratios = f" ({row['std_sort_last_order'] / time:.1f}×, {time / row['memcpy']:.1f})"
                cells.append(f"{time:.2f}" + ("" if competitor.startswith("std") else ratios))
            lines.append(f"| {entries} | {title} | {row['memcpy']:.3f} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    page.write_table(__doc__, "sort", table)
