#!/usr/bin/env python3
"""Puts the figures of bench/results into the docs: docs.py ROOT [--check]

Between its marks each page gets what the newest report there says, and the tables of the other benchmarks. With --check nothing is
written, and the exit code is 1 where a page says something else.
"""

import json
import pathlib
import sys
import textwrap

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import dynamics_table
import handling_table
import instructions_table
import page
import query_table
import sort_table
import speed_table
import step_scenes_table
import step_table
import threads_table

PAPER_ITEMS = ("table-1", "figure-6", "figure-7", "sorting", "z-curve", "cache-misses", "cell-size", "structures", "table-2")
LONGEST_TABLE = 120
WIDEST_LINE = 120
# Of `palpate bench speed`, with a table of goals.
SPEED_PARTS = ("query", "handling", "threads", "movers", "dynamics", "step", "tissue")

TABLES_OF_PAGES = {
    "docs/benchmarks.md": ["speed"],
    "docs/benchmarks-detection.md": ["query", "handling"],
    "docs/benchmarks-sorts.md": ["sort"],
    "docs/benchmarks-steps.md": ["dynamics", "step", "step scenes"],
    "docs/benchmarks-instructions.md": ["instructions", "threads"],
    "docs/notes/benchmarks.md": ["step scenes before"],
}


def reports_of(folder):
    """(file, report), the newest first."""
    reports = []
    for file in sorted(folder.glob("*.json")):
        report = json.loads(file.read_text())
        if isinstance(report, dict) and report.get("kind") == "all":
            reports.append((report["date"], file, report))
    if not reports:
        raise SystemExit(f"docs.py: found no report in {folder}, expected one of './dev bench'")
    return [entry[1:] for entry in sorted(reports, key=lambda entry: entry[0], reverse=True)]


def cell(value):
    if value is None:
        return "–"
    if isinstance(value, float):
        return page.number(value)
    return str(value).replace("|", "\\|")


def markdown_table(table):
    columns, rows = table["columns"], table["rows"]
    if not columns:
        return ""
    numeric = [all(not isinstance(row[c], str) for row in rows) for c in range(len(columns))]
    lines = ["| " + " | ".join(columns) + " |", "|" + "|".join("---:" if n else "---" for n in numeric) + "|"]
    lines += ["| " + " | ".join(cell(value) for value in row) + " |" for row in rows[:LONGEST_TABLE]]
    return "\n".join(lines) + "\n"


def sentence(text):
    return text.rstrip(".") + "."


def wrapped(block):
    """Lines of tables and headings stay whole, as Markdown asks."""
    return "\n".join(line if line.startswith(("|", "#"))
                     else textwrap.fill(line, WIDEST_LINE, subsequent_indent="  " if line.startswith("- ") else "",
                                        break_long_words=False, break_on_hyphens=False)
                     for line in block.split("\n"))


def section_text(section):
    text = f"## {section['title']}\n\n"
    if section["paper"]:
        text += (f"- *The paper*: {sentence(section['paper'])}\n- *Here*: {sentence(section['ours'])}\n"
                 f"- **{section['verdict'].capitalize()}**: {sentence(section['why'])}\n\n")
    else:
        text += f"{sentence(section['ours'])}\n\n{sentence(section['why'])}\n\n"
    return text + markdown_table(section["table"])


def facts(file, report):
    machine = report["machine"]
    remarks = f" Remarks: {sentence(report['remarks'])}" if report.get("remarks") else ""
    return (f"Measured on {machine['cpu']}, {machine['cores']} cores; {machine['compiler']}, {machine['build_type']}; "
            f"commit `{page.short_commit(machine['commit'])}`; {report['date']}; load of the machine up to {report['load']:.1f}. "
            f"Parts and their effort: {report['effort']}. All figures: [JSON]({{path}}bench/results/{file.name}).{remarks}")


def benchmarks(file, report):
    return facts(file, report).format(path="../") + "\n\n" + "\n".join(section_text(section) for section in report["sections"])


def findings(file, report):
    lines = [facts(file, report).format(path="../"), "", "| item | the paper | here | |", "|---|---|---|---|"]
    for section in report["sections"]:
        if section["id"] in PAPER_ITEMS:
            lines.append(f"| {section['title']} | {cell(sentence(section['paper']))} | {cell(sentence(section['why']))} | {section['verdict']} |")
    return "\n".join(lines) + "\n"


def peer_rows(section, scene_part, threads):
    """(ours, fastest peer) of the first scene of that name with few movers."""
    rows = [row for row in section["table"]["rows"] if scene_part == row[0] and row[1] < 5 and row[3] == threads]
    peers = [row for row in rows if row[2] != "Palpate"]
    ours = [row for row in rows if row[2] == "Palpate"]
    return (ours[0], min(peers, key=lambda row: row[6])) if ours and peers else None


# Of README.md: (section, scene, what a user asks).
QUESTIONS = (("peers-points", "stacking 10000", "Which points are inside another body? A stack of 20 membranes, 10 000 tets"),
             ("peers-points", "stacking 1000000", "Which points are inside another body? A stack of membranes, a million tets"),
             ("peers-edges", "stacking 10000", "Through which triangles do border edges leave a body? The stack of 10 000 tets"),
             ("peers-edges", "stacking 1000000", "Through which triangles do border edges leave a body? The stack of a million tets"))


def answers(report):
    """(ours, fastest peer) for each question; None if the report lacks one, as quick ones do."""
    sections = {section["id"]: section for section in report["sections"]}
    rows = [peer_rows(sections[key], scene, 1) if key in sections else None for key, scene, _ in QUESTIONS]
    return rows if all(rows) else None


def newest_with_answers(reports):
    """The newest report that answers all questions."""
    found = next(((file, report) for file, report in reports if answers(report)), None)
    if found is None:
        raise SystemExit("docs.py: found no report with a million tets, expected one of './dev bench' for README.md")
    return found


def four_rows(report):
    lines = ["| question, answered in each frame | Palpate | fastest other library | times as long |", "|---|---:|---:|---:|"]
    for (_, _, question), (ours, peer) in zip(QUESTIONS, answers(report)):
        lines.append(f"| {question} | {ours[6]:.3g} ms | {peer[6]:.3g} ms, {peer[2]} | {peer[6] / ours[6]:.3g} |")
    return "\n".join(lines) + "\n"


def figures(reports):
    """Of README.md."""
    file, report = newest_with_answers(reports)
    conditions = ("*Conditions*: one thread; 2 % of the points changed their cell since the frame before; medians over frames; each other library in its fastest mode. "
                  "Palpate reuses results of the frame before (coherence), which is the default. "
                  "These times are for detection only. In a whole step of a simulation, the solver takes most of the time "
                  "([steps](docs/benchmarks-steps.md)).")
    return f"{four_rows(report)}\n{conditions}\n\n{facts(file, report).format(path='')}\n"


def four_answers(reports):
    """Of docs/benchmarks.md."""
    file, report = newest_with_answers(reports)
    return f"{four_rows(report)}\n{facts(file, report).format(path='../')}\n"


def pages(root):
    """{page: {block: text}}"""
    results = root / "bench/results"
    reports = reports_of(results)
    file, report = reports[0]
    kept = {name: json.loads((results / f"{name}.json").read_text()) for name in SPEED_PARTS + ("instructions", "sorts")}
    tables = {"sort": sort_table.table(kept["sorts"]), "speed": speed_table.table([kept[name] for name in SPEED_PARTS + ("instructions",)])}
    for module in (query_table, handling_table, threads_table, dynamics_table, step_table, instructions_table):
        name = module.__name__.removesuffix("_table")
        tables[name] = module.table(kept[name])
    for name in ("step scenes", "step scenes before"):
        tables[name] = step_scenes_table.table(json.loads((results / f"{name.replace(' ', '-')}.json").read_text()))
    blocks = {
        "docs/benchmarks.md": {"answers": four_answers(reports)},
        "docs/benchmarks-report.md": {"report": benchmarks(file, report)},
        "docs/paper-map.md": {"findings": findings(file, report)},
        "README.md": {"figures": figures(reports)},
    }
    for place, names in TABLES_OF_PAGES.items():
        blocks.setdefault(place, {}).update({f"{name} table": tables[name] for name in names})
    return {root / place: named for place, named in blocks.items()}


def main(arguments):
    if not arguments or arguments[1:] not in ([], ["--check"]):
        raise SystemExit(__doc__)
    stale = []
    for path, blocks in pages(pathlib.Path(arguments[0])).items():
        text = new = path.read_text()
        for name, block in blocks.items():
            new = page.with_block(new, name, wrapped(block), path)
        if new == text:
            continue
        stale.append(str(path))
        if arguments[1:] != ["--check"]:
            beside = path.with_name(path.name + ".new")
            beside.write_text(new)
            beside.rename(path)
    if stale and arguments[1:]:
        raise SystemExit("docs.py: other figures than in bench/results: " + ", ".join(stale) + " (bench/report/docs.py writes them)")


if __name__ == "__main__":
    main(sys.argv[1:])
