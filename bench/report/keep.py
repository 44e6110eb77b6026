#!/usr/bin/env python3
"""Keeps a report under its date and machine: keep.py REPORT.json FOLDER

One a day for each machine and effort: a later one takes the place of an earlier one.
"""

import pathlib
import re
import shutil
import sys

from reports import read


def name_of(report):
    machine = report["machine"]
    words = f"{report['date'][:10]} {machine['cpu']} {machine['cores']} cores {report['effort']}"
    return re.sub(r"[^a-z0-9]+", "-", words.lower()).strip("-") + ".json"


if __name__ == "__main__":
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    source = pathlib.Path(sys.argv[1])
    target = pathlib.Path(sys.argv[2]) / name_of(read(source))
    beside = target.with_name(target.name + ".new")
    shutil.copyfile(source, beside)
    beside.rename(target)
    print(f"kept: {target}", file=sys.stderr)
