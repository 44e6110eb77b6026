"""Validates every scene of the repository, and the examples of docs/scene.md, against docs/scene.schema.json; and
checks that the schema refuses broken scenes. Usage: validate_scenes.py SOURCE_FOLDER"""

import copy
import json
import pathlib
import re
import sys

import jsonschema


def without_comments(text):
    """The text with // and /* */ comments outside of strings taken out."""
    token = re.compile(r'"(?:\\.|[^"\\])*"|//[^\n]*|/\*.*?\*/', re.DOTALL)
    return token.sub(lambda m: m.group(0) if m.group(0).startswith('"') else " ", text)


def scenes_of(root):
    for path in sorted(root.glob("scenes/*.json")) + sorted(root.glob("examples/*/*.json")):
        yield str(path), json.loads(without_comments(path.read_text()))
    blocks = re.findall(r"```json\n(.*?)```", (root / "docs/scene.md").read_text(), re.DOTALL)
    for number, block in enumerate(blocks):
        yield f"docs/scene.md, example {number}", json.loads(without_comments(block))


def broken_scenes(good):
    """Pairs of a defect and a scene with only that defect; the soft body of `good` is bodies[1]."""
    edits = {
        "unknown key": lambda s: s.update(time_steps=1),
        "unknown material key": lambda s: s["bodies"][1]["material"].update(young_modulos=1),
        "zero time step": lambda s: s.update(time_step=0),
        "negative density": lambda s: s["bodies"][1]["material"].update(density=-1),
        "poisson ratio of 0.5": lambda s: s["bodies"][1]["material"].update(poisson_ratio=0.5),
        "unknown structure": lambda s: s.update(contact={"structure": "compakt"}),
        "cell size of zero": lambda s: s.update(contact={"cell_size": 0}),
        "gravity of two numbers": lambda s: s.update(gravity=[0, 1]),
        "text for a number": lambda s: s.update(duration="5"),
        "no bodies": lambda s: s.update(bodies=[]),
        "bodies missing": lambda s: s.pop("bodies"),
        "two sources": lambda s: s["bodies"][1].update(mesh="a.vtu"),
        "no source": lambda s: s["bodies"][1].pop("ball"),
        "no material": lambda s: s["bodies"][1].pop("material"),
        "quaternion and angle": lambda s: s["bodies"][1].update(rotate={"quaternion": [1, 0, 0, 0], "angle": 1}),
        "selection of two kinds": lambda s: s["bodies"][1].update(
            fixed=[{"points": [0], "sphere": {"center": [0, 0, 0], "radius": 1}}]),
        "an axis twice": lambda s: s["bodies"][1].update(fixed=[{"points": [0], "axes": "xx"}]),
        "no axis": lambda s: s["bodies"][1].update(fixed=[{"points": [0], "axes": ""}]),
        "prescribed without a motion": lambda s: s["bodies"][1].update(prescribed=[{"points": [0]}]),
        "fractional index": lambda s: s["bodies"][1].update(fixed=[{"points": [0.5]}]),
        "motion without keyframes": lambda s: s["bodies"][0].update(motion={"keyframes": []}),
        "keyframe without time": lambda s: s["bodies"][0].update(motion={"keyframes": [{"translate": [0, 0, 1]}]}),
        "unknown interpolation": lambda s: s["bodies"][0].update(
            motion={"keyframes": [{"time": 0}], "interpolation": "cubic"}),
        "load of two selections": lambda s: s["bodies"][1].update(
            loads=[{"force": [0, 0, 1], "points": [0], "sphere": {"center": [0, 0, 0], "radius": 1}}]),
        "load of no selection": lambda s: s["bodies"][1].update(loads=[{"force": [0, 0, 1]}]),
        "attached to nothing": lambda s: s["bodies"][1].update(attached=[{"points": [0]}]),
        "grab of no stiffness": lambda s: s["bodies"][1].update(
            grabs=[{"from": [0, 0, 0], "target": [0, 0, 1], "stiffness": 0}]),
        "region without material": lambda s: s["bodies"][1].update(regions=[{"tets": [0]}]),
        "region of two selections": lambda s: s["bodies"][1].update(
            regions=[{"material": {}, "tets": [0], "sphere": {"center": [0, 0, 0], "radius": 1}}]),
        "region of points": lambda s: s["bodies"][1].update(regions=[{"material": {}, "points": [0]}]),
        "yield without creep": lambda s: s["bodies"][1]["material"].update(plastic_yield=0.1),
        "speed limit of zero": lambda s: s.update(limits={"max_speed": 0}),
        "color above 1": lambda s: s["bodies"][1].update(color=[0, 0, 2]),
    }
    for name, edit in edits.items():
        scene = copy.deepcopy(good)
        edit(scene)
        yield name, scene


def main(root):
    schema = json.loads((root / "docs/scene.schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    failures = []
    scenes = dict(scenes_of(root))
    for name, scene in scenes.items():
        failures += [f"{name}: {error.json_path}: {error.message}" for error in validator.iter_errors(scene)]
    good = scenes[str(root / "scenes/ball-on-plate.json")]
    broken = list(broken_scenes(good))
    failures += [f"the schema takes a broken scene: {name}" for name, scene in broken if validator.is_valid(scene)]
    print(f"{len(scenes)} scenes validated, {len(broken)} broken scenes tried, {len(failures)} failures")
    print("\n".join(failures))
    return 1 if failures or len(scenes) < 4 else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
