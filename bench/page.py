"""What the scripts that write the tables of docs/benchmarks*.md have in common."""

import json
import pathlib
import re
import sys


CONDITIONS = ("processor | compiler, build | commit | date | load of the machine, up to | `memcpy` of 64 MiB, GB/s | "
              "`std::sort` of a million floats, ms | 20 million dependent multiply-adds, ms |")


def short_commit(commit):
    """Ten digits, and '-dirty' where there was that."""
    digits, _, dirty = commit.partition("-")
    return digits[:10] + (f"-{dirty}" if dirty else "")


def conditions(report):
    """The cells under CONDITIONS: where and with what the figures of a part of `palpate bench speed` were taken."""
    taken, references = report["machine"], report["references"]
    load = f"{report['load']:.1f}" if "load" in report else "–"
    return (f"{taken['cpu']}, {taken['cores']} cores | {taken['compiler']}, {taken['build_type']} | `{short_commit(taken['commit'])}` | "
            f"{report['date']} | {load} | {references['memcpy_GB_per_s']:.1f} | {references['sort_ms']:.0f} | "
            f"{references['multiply_add_ms']:.0f} |")


def machine(report):
    """The conditions as a table of one row."""
    return f"| {CONDITIONS}\n|---|---|---|---|---:|---:|---:|---:|\n| {conditions(report)}"


def number(value):
    """Four digits of a measured number; a count in full."""
    if value == int(value) or abs(value) >= 1e4:
        return f"{value:.0f}"
    return f"{value:.4g}"


def with_block(page, name, block, source):
    """The page with other text between the marks of a name; `source` names it in errors."""
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    marked = re.compile(re.escape(begin) + ".*?" + re.escape(end), re.DOTALL)
    if not marked.search(page):
        raise SystemExit(f"{source}: found no marks '{begin}' and '{end}'")
    return marked.sub(lambda _: f"{begin}\n{block}{end}", page)


def write_table(usage, name, table):
    """Writes table(report) of the JSON file argv[1] between the marks 'NAME table' of the page argv[2]; without argv[2] prints it."""
    arguments = sys.argv[1:]
    if len(arguments) not in (1, 2):
        raise SystemExit(usage)
    text = table(json.loads(pathlib.Path(arguments[0]).read_text()))
    if len(arguments) == 1:
        print(text, end="")
        return
    path = pathlib.Path(arguments[1])
    path.write_text(with_block(path.read_text(), f"{name} table", text, path))
