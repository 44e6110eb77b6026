"""Reading a report, for what works on reports."""

import json
import pathlib
import sys

FACTS = ("cpu", "cores", "compiler", "build_type", "commit")
TIMES = ("least", "lower_quartile", "median", "upper_quartile", "most")


def fault_of(report):
    """What keeps it from being a report of './dev bench', or None."""
    if not isinstance(report, dict) or not isinstance(report.get("machine"), dict) or not isinstance(report.get("sections"), list):
        return "no report"
    missing = [key for key in ("kind", "date", "effort") if not isinstance(report.get(key), str)] + \
              [f"machine.{key}" for key in FACTS if key not in report["machine"]]
    if missing:
        return f"a report without {', '.join(missing)}"
    for place, section in enumerate(report["sections"]):
        if not isinstance(section, dict) or not isinstance(section.get("id"), str) or not isinstance(section.get("measures", []), list):
            return f"no section at {place}"
        for measure in section.get("measures", []):
            if not isinstance(measure, dict) or not isinstance(measure.get("name"), str) or not isinstance(measure.get("reference"), bool) or \
                    not all(isinstance(measure.get(key), (int, float)) for key in TIMES):
                return f"a section '{section['id']}' with a measure that has no name or no times"
    # Older reports do not have the key.
    if report.get("complete", True) is not True:
        return "a report that was not measured to its end"
    return None


def read(name):
    """The report in a file; where there is none, or one that is not complete, the program ends with 2 and one line."""
    try:
        report = json.loads(pathlib.Path(name).read_text())
        fault = fault_of(report)
    except (OSError, ValueError) as error:
        fault = f"no report ({error})"
    if fault:
        print(f"{pathlib.Path(sys.argv[0]).name}: {name}: found {fault}, expected one of './dev bench'", file=sys.stderr)
        raise SystemExit(2)
    return report
