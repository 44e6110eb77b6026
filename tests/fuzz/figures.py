"""Prints a line for each log that './dev fuzz' left: executions, edges of the program reached, and how it ended.

    python3 tests/fuzz/figures.py FOLDER
"""

import pathlib
import re
import sys


def main():
    print(f"{'fuzzer':<16}{'executions':>12}{'edges':>8}{'inputs':>8}  ended")
    for log in sorted(pathlib.Path(sys.argv[1]).glob("*.log")):
        text = log.read_text(errors="replace")
        executions = re.findall(r"stat::number_of_executed_units:\s*(\d+)", text) or re.findall(r"(?m)^#(\d+)", text) or ["0"]
        edges = re.findall(r"cov: (\d+)", text) or ["0"]
        inputs = re.findall(r"corp: (\d+)", text) or ["0"]
        fault = re.search(r"ERROR: (.*)|SUMMARY: (.*)", text)
        ended = fault.group(0) if fault else "without a fault"
        print(f"{log.stem:<16}{executions[-1]:>12}{edges[-1]:>8}{inputs[-1]:>8}  {ended[:90]}")


if __name__ == "__main__":
    main()
