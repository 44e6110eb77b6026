"""The result of palpate_bench_budget as a chart, a smaller file without the single steps, and the rows of docs/budget.md.

    python3 bench/budget_chart.py RESULT.json SUMMARY.json CHART.png
"""

import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt


def draw(result, path):
    runs = [(None, result["exact"]["steps"], [0] * len(result["exact"]["steps"]))]
    runs += [(b["milliseconds"], b["steps"], b["put_aside"]) for b in result["budgets"]]
    figure, axes = plt.subplots(len(runs), 1, figsize=(8, 2.1 * len(runs)), sharex=True, constrained_layout=True)
    longest = max(max(steps) for _, steps, _ in runs)
    shortest = min(min(steps) for _, steps, _ in runs)
    bins = [shortest * (longest / shortest) ** (i / 120) for i in range(121)]
    for axis, (budget, steps, aside) in zip(axes, runs):
        undisturbed = [t for t, a in zip(steps, aside) if a == 0]
        axis.hist(steps, bins=bins, color="#c9c9c9", label="all steps")
        if budget is not None:
            axis.hist(undisturbed, bins=bins, color="#2a6f97", label="not put aside by the system")
            axis.axvline(budget, color="#bc4b51", linewidth=1.2, label="budget")
            axis.axvline(1.1 * budget, color="#bc4b51", linewidth=1.2, linestyle="--", label="budget + 10 %")
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_ylabel("steps")
        axis.set_title("no budget" if budget is None else f"budget {budget:g} ms", loc="left", fontsize=10)
        if budget is not None:
            axis.legend(fontsize=7, loc="upper right")
    axes[-1].set_xlabel("detection of a step, ms")
    figure.savefig(path, dpi=110)


def table(result):
    print("| budget | within budget + 10 % | steps not put aside: within | median, 99.9 % | clusters asked, mean (least) "
          "| deviation: max, mean, standard |")
    print("|---|---|---|---|---|---|")
    for b in result["budgets"]:
        d = b["deviation"]
        u = b["undisturbed"]
        print(f"| {b['milliseconds']:g} ms | {100 * b['share_within']:.2f} % "
              f"| {100 * (b['share_within_undisturbed'] or 0):.2f} % of {result['steps'] - b['steps_put_aside']} "
              f"| {u['median']:.3g}, {u['p999']:.3g} ms | {100 * b['completeness']['mean']:.1f} % "
              f"({100 * b['least_completeness']:.0f} %) | {d['max']:.2g}, {d['mean']:.2g}, {d['standard_deviation']:.2g} |")


def main():
    result = json.load(open(sys.argv[1]))
    draw(result, sys.argv[3])
    table(result)
    for run in [result["exact"], *result["budgets"]]:
        run.pop("steps", None)
        run.pop("put_aside", None)
    result["scene"] = result["scene"].rsplit("/", 1)[-1]
    json.dump(result, open(sys.argv[2], "w"), indent=1)


if __name__ == "__main__":
    main()
