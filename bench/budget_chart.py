"""The result of palpate_bench_budget as a chart, a smaller file without the single steps, and the rows of docs/budget.md.

    python3 bench/budget_chart.py RESULT.json SUMMARY.json CHART.png
"""

import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt


def histogram(axis, times, budget, bins, what):
    axis.hist(times, bins=bins, color="#2a6f97")
    if budget is not None:
        axis.axvline(budget, color="#bc4b51", linewidth=1.2, label="budget")
        axis.axvline(1.1 * budget, color="#bc4b51", linewidth=1.2, linestyle="--", label="budget + 10 %")
        axis.legend(fontsize=7, loc="upper right")
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_ylabel(what)
    axis.set_title("no budget" if budget is None else f"budget {budget:g} ms", loc="left", fontsize=10)


def draw(result, path):
    """A row for each budget: steps with disturbances on the left, detections of the same positions on the right."""
    rows = [(None, result["exact"]["step_milliseconds"], result["exact"]["milliseconds"])]
    rows += [(b["budget"], b["many_steps_milliseconds"], b["milliseconds"]) for b in result["budgets"]]
    figure, axes = plt.subplots(len(rows), 2, figsize=(10, 2.1 * len(rows)), sharex=True, constrained_layout=True)
    every = [t for _, steps, detections in rows for t in [*steps, *detections]]
    bins = [min(every) * (max(every) / min(every)) ** (i / 120) for i in range(121)]
    for (left, right), (budget, steps, detections) in zip(axes, rows):
        histogram(left, steps, budget, bins, "steps")
        histogram(right, detections, budget, bins, "detections")
    axes[-1][0].set_xlabel("time of all detections of a step, ms")
    axes[-1][1].set_xlabel("time of a detection, ms")
    figure.savefig(path, dpi=110)


def table(result):
    unit = "the scene's unit"
    exact = result["exact"]
    for what in ("steps", "detections"):
        of = exact[what]
        print(f"Without a budget, {of['count']} {what}: median {of['time']['median']:.3g} ms, 99.9 % "
              f"{of['time']['p999']:.3g} ms, {of['contacts']['median']:.0f} contacts.")
    print("\n| budget | what | within budget + 10 % | median, 99.9 %, longest | clusters queried: mean, smallest | depths not recomputed, mean | contacts, median |")
    print("|---|---|---|---|---|---|---|")
    for b in result["budgets"]:
        for name, what in (("many_steps", "steps, disturbed"), ("steps", "steps"), ("detections", "detections")):
            k = b[name]
            print(f"| {b['budget']:g} ms | {k['count']} {what} | {100 * k['share_within']:.2f} % "
                  f"| {k['time']['median']:.3g}, {k['time']['p999']:.3g}, {k['time']['max']:.3g} ms "
                  f"| {100 * k['completeness']['mean']:.1f} %, {100 * k['least_completeness']:.0f} % | {100 * k['rough_depths']['mean']:.1f} % "
                  f"| {k['contacts']['median']:.0f} |")
    print(f"\n| budget | deviation of the end of the run ({unit}): max | mean | standard |\n|---|---|---|---|")
    for b in result["budgets"]:
        d = b["deviation"]
        print(f"| {b['budget']:g} ms | {d['max']:.2g} | {d['mean']:.2g} | {d['standard_deviation']:.2g} |")


def main():
    result = json.load(open(sys.argv[1]))
    draw(result, sys.argv[3])
    table(result)
    for run in [result["exact"], *result["budgets"]]:
        for series in ("milliseconds", "step_milliseconds", "many_steps_milliseconds", "put_aside"):
            run.pop(series, None)
    result["scene"] = result["scene"].rsplit("/", 1)[-1]
    json.dump(result, open(sys.argv[2], "w"), indent=1)


if __name__ == "__main__":
    main()
