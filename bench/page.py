"""What the scripts that write the tables of docs/benchmarks.md share."""

import json
import pathlib
import re
import sys


def write_table(usage, name, table):
    """Writes table(report) of the JSON file argv[1] between the marks 'NAME table' of the page argv[2]; without argv[2] prints it."""
    arguments = sys.argv[1:]
    if len(arguments) not in (1, 2):
        raise SystemExit(usage)
    text = table(json.loads(pathlib.Path(arguments[0]).read_text()))
    if len(arguments) == 1:
        print(text, end="")
        return
    begin, end = f"<!-- {name} table: begin -->", f"<!-- {name} table: end -->"
    path = pathlib.Path(arguments[1])
    page = path.read_text()
    marked = re.compile(re.escape(begin) + ".*?" + re.escape(end), re.DOTALL)
    if not marked.search(page):
        raise SystemExit(f"{path}: found no marks '{begin}' and '{end}'")
    path.write_text(marked.sub(lambda _: f"{begin}\n{text}{end}", page))
