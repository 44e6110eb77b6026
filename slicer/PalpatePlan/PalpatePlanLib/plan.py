"""What a user asks for, as the command line of `palpate mesh` and the scene that it runs."""

from __future__ import annotations

import copy
import dataclasses
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

KINDS = ("grown", "slides", "open")


@dataclasses.dataclass
class Tissue:
    """A segment and its material, in SI units."""

    name: str
    rigid: bool = False
    young_modulus: float = 20e3  # Pa
    poisson_ratio: float = 0.45
    density: float = 1000.0  # kg/m^3
    color: tuple[float, float, float] | None = None


@dataclasses.dataclass
class Relation:
    """What two tissues do where they touch: one of KINDS."""

    first: str
    second: str
    kind: str = "slides"


@dataclasses.dataclass
class Plan:
    tissues: list[Tissue]
    relations: list[Relation] = dataclasses.field(default_factory=list)
    tets: int | None = None
    gap: float = 0.0  # mm, of relations "open"


def relations_of(text: str) -> list[Relation]:
    """Relations from lines "A : B = slides". Raises ValueError naming a line that is none."""
    relations = []
    for line in text.splitlines():
        if not line.strip():
            continue
        pair, equals, kind = line.rpartition("=")
        first, colon, second = pair.partition(":")
        if not (equals and colon):
            raise ValueError(f"'{line.strip()}': expected A : B = slides, open or grown")
        relations.append(Relation(first.strip(), second.strip(), kind.strip()))
    return relations


def check(plan: Plan) -> None:
    """Raises ValueError, one line, if no scene can come of the plan."""
    names = [tissue.name for tissue in plan.tissues]
    if not names:
        raise ValueError("the segmentation has no segment")
    for name in names:
        if not name or names.count(name) > 1:
            raise ValueError(f"segment '{name}': its name is empty, or another segment has it too")
    if all(tissue.rigid for tissue in plan.tissues):
        raise ValueError("all segments are rigid: nothing can deform")
    for tissue in plan.tissues:
        if not tissue.rigid and not (tissue.young_modulus > 0 and -1 < tissue.poisson_ratio < 0.5 and tissue.density > 0):
            raise ValueError(f"segment '{tissue.name}': Young's modulus and density are > 0, Poisson's ratio is in (-1, 0.5)")
    for relation in plan.relations:
        if relation.kind not in KINDS:
            raise ValueError(f"relation of '{relation.first}' and '{relation.second}': '{relation.kind}' is none of {', '.join(KINDS)}")
        for name in (relation.first, relation.second):
            if name not in names:
                raise ValueError(f"relation of '{relation.first}' and '{relation.second}': there is no segment '{name}'")
        if relation.first == relation.second:
            raise ValueError(f"relation of '{relation.first}' with itself")
        if relation.kind == "open" and not plan.gap > 0:
            raise ValueError(f"relation of '{relation.first}' and '{relation.second}': 'open' needs a gap > 0")


def label_descriptions(tissues: Sequence[Tissue]) -> str:
    """Names of the labels 1, 2, ... as ITK-SNAP writes them: a table for `palpate mesh --labels`."""
    lines = []
    for number, tissue in enumerate(tissues, 1):
        red, green, blue = (round(255 * c) for c in (tissue.color or (0.8, 0.8, 0.8)))
        lines.append(f'{number} {red} {green} {blue} 1 1 1 "{tissue.name}"')
    return "\n".join(lines) + "\n"


def mesh_arguments(plan: Plan, label_map: pathlib.Path, labels: pathlib.Path, folder: pathlib.Path) -> list[str]:
    """Arguments of the command that meshes the label map; meshes are in RAS, as Slicer shows them."""
    arguments = ["mesh", str(label_map), "--conforming", "--labels", str(labels), "--space", "ras", "--json", "--quiet",
                 "--out", str(folder), "--replace"]
    for tissue in plan.tissues:
        if tissue.rigid:
            arguments += ["--rigid", tissue.name]
    for relation in plan.relations:
        arguments += ["--relation", f"{relation.first}:{relation.second}={relation.kind}"]
    if plan.gap > 0 and any(relation.kind == "open" for relation in plan.relations):
        arguments += ["--gap", f"{plan.gap:g}"]
    if plan.tets is not None:
        arguments += ["--tets", str(plan.tets)]
    return arguments


def material(tissue: Tissue) -> dict[str, Any]:
    """In the units of the scene: mm, g, s, so that stresses are in Pa."""
    return {"young_modulus": tissue.young_modulus, "poisson_ratio": tissue.poisson_ratio, "density": 1e-6 * tissue.density,
            "mass_damping": 5.0, "stiffness_damping": 0.02}


def with_materials(scene: Mapping[str, Any], tissues: Sequence[Tissue]) -> dict[str, Any]:
    """The scene of `palpate mesh` with the materials and colours of the tissues. Label n is tissue n - 1."""
    result = copy.deepcopy(dict(scene))
    by_name = {tissue.name: tissue for tissue in tissues}
    for body in result["bodies"]:
        tissue = by_name[body["name"]]
        if tissue.color is not None:
            body["color"] = list(tissue.color)
        if "material" in body:
            body["material"] = material(tissue)
        for region in body.get("regions", ()):
            inner = tissues[region["label"] - 1]
            region["material"] = material(inner)
            if inner.color is not None:
                region["color"] = list(inner.color)
    return result


def merged(scene: Mapping[str, Any], additions: Mapping[str, Any]) -> dict[str, Any]:
    """The scene with what a file of the user adds: bodies are merged by name, all other keys replaced."""
    result = copy.deepcopy(dict(scene))
    for key, value in additions.items():
        if key != "bodies":
            result[key] = copy.deepcopy(value)
            continue
        for addition in value:
            there = [body for body in result["bodies"] if body["name"] == addition.get("name")]
            if there:
                there[0].update(copy.deepcopy(addition))
            else:
                result["bodies"].append(copy.deepcopy(addition))
    return result
