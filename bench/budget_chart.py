"""The result of palpate_bench_budget as a chart, a smaller file without the single steps, and the rows of docs/budget.md.

    python3 bench/budget_chart.py RESULT.json SUMMARY.json CHART.png
"""

import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt


def draw(result, path):
    runs = [(None, result["exact"]["milliseconds"], None)]
    runs += [(b["budget"], b["milliseconds"], b["put_aside"]) for b in result["budgets"]]
    figure, axes = plt.subplots(len(runs), 1, figsize=(8, 2.1 * len(runs)), sharex=True, constrained_layout=True)
    longest = max(max(times) for _, times, _ in runs)
    shortest = min(min(times) for _, times, _ in runs)
    bins = [shortest * (longest / shortest) ** (i / 120) for i in range(121)]
    for axis, (budget, times, aside) in zip(axes, runs):
        axis.hist(times, bins=bins, color="#c9c9c9", label="all")
        if budget is not None:
            undisturbed = [t for t, a in zip(times, aside) if a == 0]
            axis.hist(undisturbed, bins=bins, color="#2a6f97", label="not put aside by the system")
            axis.axvline(budget, color="#bc4b51", linewidth=1.2, label="budget")
            axis.axvline(1.1 * budget, color="#bc4b51", linewidth=1.2, linestyle="--", label="budget + 10 %")
            axis.legend(fontsize=7, loc="upper right")
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_ylabel("detections")
        axis.set_title("no budget" if budget is None else f"budget {budget:g} ms", loc="left", fontsize=10)
    axes[-1].set_xlabel("time of a detection, ms")
    figure.savefig(path, dpi=110)


def table(result):
    unit = "the scene's unit"
    exact = result["exact"]["detections"]
    print(f"Without a budget: median {exact['time']['median']:.3g} ms, 99.9 % {exact['time']['p999']:.3g} ms, "
          f"{exact['contacts']['median']:.0f} contacts.\n")
    print("| budget | detections within budget + 10 % | of those not put aside | median, 99.9 % of these | clusters asked: mean, least "
          f"| contacts, median | end of the run: deviation max, mean, standard ({unit}) |")
    print("|---|---|---|---|---|---|---|")
    for b in result["budgets"]:
        d, k = b["deviation"], b["detections"]
        u = k["time_undisturbed"]
        print(f"| {b['budget']:g} ms | {100 * k['share_within']:.2f} % of {k['count']} "
              f"| {100 * k['share_within_undisturbed']:.2f} % of {k['count'] - k['put_aside']} "
              f"| {u['median']:.3g}, {u['p999']:.3g} ms | {100 * k['completeness']['mean']:.1f} %, "
              f"{100 * k['least_completeness']:.0f} % | {k['contacts']['median']:.0f} "
              f"| {d['max']:.2g}, {d['mean']:.2g}, {d['standard_deviation']:.2g} |")


def main():
    result = json.load(open(sys.argv[1]))
    draw(result, sys.argv[3])
    table(result)
    for run in [result["exact"], *result["budgets"]]:
        run.pop("milliseconds", None)
        run.pop("put_aside", None)
    result["scene"] = result["scene"].rsplit("/", 1)[-1]
    json.dump(result, open(sys.argv[2], "w"), indent=1)


if __name__ == "__main__":
    main()
