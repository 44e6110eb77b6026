"""What a run has left in its folder."""

from __future__ import annotations

import dataclasses
import json
import pathlib
import xml.etree.ElementTree as ElementTree


@dataclasses.dataclass
class Frame:
    time: float
    file: pathlib.Path


@dataclasses.dataclass
class Results:
    bodies: list[str]
    """Their names; the array `body` of frames has indices of this list."""
    time_unit: str
    frames: list[Frame]
    outcomes: list[dict]
    """As in outcomes.json: name, value, unit, in_words, stages; empty without."""
    warnings: list[str]


def read_results(folder: pathlib.Path) -> Results:
    """Raises OSError or ValueError, with the name of the file, if something is missing or damaged."""
    run = _json(folder / "run.json")
    outcomes = _json(folder / "outcomes.json") if (folder / "outcomes.json").exists() else {"outcomes": []}
    return Results([body["name"] for body in run["bodies"]], run["units"]["time"], read_frames(folder / "frames.pvd"),
                   outcomes["outcomes"], _warnings(run))


def read_frames(file: pathlib.Path) -> list[Frame]:
    """The frames of a collection of ParaView, by time."""
    try:
        sets = ElementTree.parse(file).getroot().iter("DataSet")
        frames = [Frame(float(one.attrib["timestep"]), file.parent / one.attrib["file"]) for one in sets]
    except (ElementTree.ParseError, KeyError) as error:
        raise ValueError(f"{file}: no collection of frames ({error})") from None
    return sorted(frames, key=lambda frame: frame.time)


def outcome_rows(results: Results) -> list[tuple[str, str]]:
    """Name and value in words of each outcome."""
    return [(outcome["name"], outcome["in_words"]) for outcome in results.outcomes]


def _warnings(run: dict) -> list[str]:
    warnings = []
    if run["error"]:
        warnings.append(run["error"])
    if run["solver"]["steps_not_converged"]:
        warnings.append(f"{run['solver']['steps_not_converged']} steps did not converge: do not trust positions")
    if run["inverted_tets"]["last"]:
        warnings.append(f"{run['inverted_tets']['last']} tets are inverted at the end")
    for stage in run["stages"]:
        if not stage["reached"]:
            warnings.append(f"stage '{stage['name']}' ended by its time")
        for overlap in stage["overlaps"]:
            placed, other = overlap["bodies"]
            warnings.append(f"stage '{stage['name']}' puts '{placed}' into '{other}'")
    return warnings


def _json(file: pathlib.Path) -> dict:
    try:
        return json.loads(file.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{file}: no JSON ({error})") from None
