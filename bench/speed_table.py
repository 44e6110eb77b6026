"""The tables of what we set out to reach, of all parts of `palpate bench speed`; goals and verdicts are in their JSON."""

import page

TABLES = {"detection": "Detection", "dynamics": "Dynamics", "whole": "Whole steps"}


def goal_row(row):
    bound = "≤" if row["at_most"] else "≥"

    def ratio(value):
        if row["ratio_unit"] == "":  # a number of its own, not a ratio
            return f"{value:.0f}"
        return f"{value:.0f} %" if row["ratio_unit"] == "%" else f"{value:.3g}×"

    verdict = "**missed**" if row["verdict"] == "missed" else row["verdict"]
    return (f"| {row['work']} | {row['ours']:.4g} {row['unit']} | {row['other']:.4g} {row['unit']} | {row['other_side']} | {ratio(row['ratio'])} | "
            f"{bound} {ratio(row['must'])} | {bound} {ratio(row['aim'])} | {verdict} |")


def table(reports):
    """Of the JSON of each part."""
    lines = [f"| part | {page.CONDITIONS}", "|---|---|---|---|---|---:|---:|---:|---:|"]
    lines += [f"| {report['part']} | {page.conditions(report)}" for report in reports]
    for name, title in TABLES.items():
        rows = [goal_row(row) for report in reports for row in report["table"] if row["table"] == name]
        if rows:
            lines += ["", f"| {title} | Palpate | reference | what the reference is | ratio | must | aim | verdict |", "|---|---:|---:|---|---:|---:|---:|---|", *rows]
    return "\n".join(lines) + "\n"
