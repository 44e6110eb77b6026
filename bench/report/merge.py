#!/usr/bin/env python3
"""Makes one report of several: merge.py OUT.json REPORT.json…

Machine, commit and effort must be the same in all; the date is that of the first. One line a section, so that kept reports compare well.
"""

import json
import pathlib
import sys


def merged(reports):
    first = reports[0]
    for report in reports[1:]:
        for key in ("machine", "effort"):
            if report[key] != first[key]:
                raise SystemExit(f"merge.py: found {key} {report[key]} in '{report['kind']}', expected {first[key]} as in '{first['kind']}'")
    return {"kind": "all", "date": first["date"], "machine": first["machine"], "effort": first["effort"],
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
    report = merged([json.loads(pathlib.Path(name).read_text()) for name in arguments[1:]])
    beside = out.with_name(out.name + ".new")
    beside.write_text(text_of(report))
    beside.rename(out)


if __name__ == "__main__":
    main(sys.argv[1:])
