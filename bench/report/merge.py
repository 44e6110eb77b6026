#!/usr/bin/env python3
"""Makes one report of several: merge.py OUT.json REPORT.json…

All must be complete, and of the same machine and commit; the date is that of the first. Where efforts differ, each is told with its report. One line a section, so
that kept reports compare well.
"""

import json
import pathlib
import sys

from reports import read


def merged(reports):
    first = reports[0]
    for report in reports[1:]:
        if report["machine"] != first["machine"]:
            raise SystemExit(f"merge.py: found machine {report['machine']} in '{report['kind']}', expected {first['machine']} as in '{first['kind']}'")
    efforts = {report["effort"] for report in reports}
    effort = first["effort"] if len(efforts) == 1 else ", ".join(f"{report['kind']} {report['effort']}" for report in reports)
    return {"kind": "all", "date": first["date"], "machine": first["machine"], "effort": effort, "complete": True,
            "load": max(report.get("load", 0.0) for report in reports),
            "sections": [section for report in reports for section in report["sections"]]}


def text_of(report):
    head = {key: value for key, value in report.items() if key != "sections"}
    lines = ",\n".join(json.dumps(section, ensure_ascii=False) for section in report["sections"])
    return json.dumps(head, ensure_ascii=False)[:-1] + ', "sections": [\n' + lines + "\n]}\n"


def main(arguments):
    if len(arguments) < 2:
        raise SystemExit(__doc__)
    out = pathlib.Path(arguments[0])
    report = merged([read(name) for name in arguments[1:]])
    beside = out.with_name(out.name + ".new")
    beside.write_text(text_of(report))
    beside.rename(out)


if __name__ == "__main__":
    main(sys.argv[1:])
