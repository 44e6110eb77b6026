"""First use of the package: repr of objects, wrong values, notebooks, processes, the command."""

import copy
import json
import os
import pathlib
import pickle
import re
import subprocess
import sys
import typing

import numpy as np
import pytest

import palpate
from palpate import _names

SCENE = {"duration": 0.05, "bodies": [{"name": "ball", "ball": {"radius": 0.05, "resolution": 1}, "material": {}}]}


@pytest.fixture(scope="module")
def objects():
    """One of each class."""
    simulation = palpate.Simulation(palpate.stacking_scene(count=2, cells=(2, 2, 1)))
    simulation.step()
    world = palpate.World.from_scene(palpate.stacking_scene(count=2, cells=(2, 2, 1)))
    relaxed = palpate.Simulation({**palpate.stacking_scene(count=2, cells=(2, 2, 1)), "relax": {}}).relaxed
    key = palpate.Keyframe(1.0, (0.0, 0.0, 1.0))
    return [simulation, world, palpate.World(), palpate.Model.from_scene(palpate.stacking_scene(count=2)), palpate.Material(),
            key, palpate.Motion([key], interpolation="smooth"), simulation.grab(30, (0, 0, 0), 1.0), simulation.bodies,
            simulation.bodies[1], simulation.contacts, simulation.crossings, simulation.edge_contacts, simulation.metrics, simulation.metrics.detection,
            world.times, relaxed, simulation.acting_contacts, simulation.contact_wrench(0), *pressed_pairs()[:1], simulation.tractions(),
            simulation.tissue(), palpate.Ramp([0.0, 1.0], [0.0, 1.0]), world.bodies, world.bodies[0],
            palpate.Fibres(direction=(0, 1, 0), stiffness=1000.0, exponent=1.0),
            palpate.Viscosity(fractions=[0.5], times=[1.0]),
            palpate.Simulation({**SCENE, "outcomes": [{"name": "way", "displacement": {"body": "ball"}}]}).outcomes()["way"]]


def pressed_pairs():
    """Wrenches of two membranes that lie on each other."""
    simulation = palpate.Simulation(palpate.stacking_scene(count=2, cells=(2, 2, 1)))
    while not simulation.pair_wrenches():
        simulation.step()
    return simulation.pair_wrenches()


def test_every_class_is_among_them(objects):
    classes = {name for name in palpate.__all__ if isinstance(getattr(palpate, name), type)} - {"Error", "NotConverged"}
    assert {type(one).__name__ for one in objects} == classes


def test_every_object_says_what_it_is(objects):
    for one in objects:
        text = repr(one)
        assert type(one).__name__ in text and " at 0x" not in text and text.startswith(("palpate.", "<palpate.")), text
    texts = {type(one).__name__: repr(one) for one in objects}
    assert texts["Simulation"] == "<palpate.Simulation: step 1, t = 0.005 s, 2 bodies, 0 contacts>"
    assert texts["Model"] == "<palpate.Model: 2 bodies, 484 points, 1000 tets>"
    assert "young_modulus=100000.0" in texts["Material"] and "solves=" in texts["StepMetrics"]
    assert repr(objects[2]) == "<palpate.World: 0 bodies, 0 points, no update() yet>"


def test_objects_are_pickled_and_copied_or_refuse_it_in_one_line(objects):
    values = (palpate.Ramp, palpate.Fibres, palpate.Viscosity, palpate.Material, palpate.Keyframe, palpate.Motion, palpate.Outcome)
    for one in objects:
        if isinstance(one, values):
            for again in (pickle.loads(pickle.dumps(one)), copy.deepcopy(one), copy.copy(one)):
                assert repr(again) == repr(one) and again is not one and again == one
            continue
        for attempt in (pickle.dumps, copy.deepcopy):
            with pytest.raises(TypeError, match=rf"^a palpate\.{type(one).__name__} cannot be pickled or copied: \w+") as caught:
                attempt(one)
            assert "\n" not in str(caught.value)


def test_values_are_equal_where_all_of_their_parts_are():
    key = palpate.Keyframe(1.0, (0.0, 0.0, 1.0))
    ramp = palpate.Ramp([0.0, 1.0], [0.0, 1.0])
    fibres = palpate.Fibres(stiffness=1e3, activation=ramp)
    viscosity = palpate.Viscosity(fractions=[0.5], times=[1.0])
    for one, others in [
        (palpate.Material(fibres=fibres, viscosity=viscosity, model="stable-neo-hookean"),
         [palpate.Material(), palpate.Material(fibres=fibres, model="stable-neo-hookean")]),
        (palpate.Material(), [palpate.Material(**{name: value}) for name, value in [
            ("young_modulus", 1e4), ("poisson_ratio", 0.3), ("density", 900.0), ("mass_damping", 1.0), ("stiffness_damping", 0.01),
            ("plastic_yield", 0.1), ("plastic_creep", 0.1), ("plastic_maximum", 0.1), ("model", "mooney-rivlin"),
            ("mooney_fraction", 0.4), ("elements", "smoothed")]]),
        (ramp, [palpate.Ramp([0.0, 2.0], [0.0, 1.0]), palpate.Ramp([0.0, 1.0], [0.0, 0.5])]),
        (fibres, [palpate.Fibres(stiffness=1e3), palpate.Fibres(direction=(0, 1, 0), stiffness=1e3, activation=ramp)]),
        (viscosity, [palpate.Viscosity(fractions=[0.4], times=[1.0]), palpate.Viscosity(fractions=[0.5], times=[2.0])]),
        (key, [palpate.Keyframe(2.0, (0.0, 0.0, 1.0)), palpate.Keyframe(1.0), palpate.Keyframe(1.0, (0, 0, 1), (0, 1, 0, 0))]),
        (palpate.Motion([key]), [palpate.Motion([key, palpate.Keyframe(2.0)]), palpate.Motion([key], interpolation="smooth"),
                                 palpate.Motion([key], center=(1, 0, 0))]),
    ]:
        again = pickle.loads(pickle.dumps(one))
        assert again == one and not again != one
        for other in [*others, None, 1, "text"]:
            assert one != other and not one == other
        with pytest.raises(TypeError, match="unhashable"):  # its values can change
            hash(one)


def test_outcomes_are_equal_where_their_vectors_are():
    one = palpate.Outcome("displacement", 1.0, "m", np.array([1.0, 0.0, 0.0]))
    assert one == palpate.Outcome("displacement", 1.0, "m", np.array([1.0, 0.0, 0.0])) and len({one, pickle.loads(pickle.dumps(one))}) == 1
    for other in [palpate.Outcome("displacement", 1.0, "m", np.array([0.0, 1.0, 0.0])), palpate.Outcome("displacement", 1.0, "m", None),
                  palpate.Outcome("displacement", 1.0, "mm", np.array([1.0, 0.0, 0.0])), 1.0]:
        assert one != other
    assert palpate.Outcome("gap", 1.0, "m", None) == palpate.Outcome("gap", 1.0, "m", None)


def test_a_truth_value_is_no_number_of_a_material():
    material = palpate.Material()
    for truth in (True, np.True_):
        for attempt in (lambda: palpate.Material(young_modulus=truth), lambda: setattr(material, "young_modulus", truth),
                        lambda: palpate.Material(plastic_yield=truth), lambda: palpate.Fibres(stiffness=truth)):
            with pytest.raises(palpate.Error, match=r": found .*, expected a number( or None)?$"):
                attempt()
    assert palpate.Material(young_modulus=1, density=np.float32(2), plastic_yield=np.int64(1)).density == 2.0
    assert material == palpate.Material()


def test_friction_is_looked_for_where_it_is():
    with pytest.raises(palpate.Error) as caught:
        palpate.Material(friction=1)
    assert str(caught.value) == ("Material: friction: found an argument of this name, expected it in the settings of contacts: "
                                 "contact={'friction': 0.3} of a Simulation or a scene")
    assert palpate.Simulation(SCENE, contact={"friction": 0.3}).metrics.step == 0


@pytest.mark.parametrize(("name", "value", "expected"), [
    ("young_modulus", -1.0, "a number > 0"), ("young_modulus", float("nan"), "a finite number"),
    ("poisson_ratio", 0.5, "a number in (-1, 0.5)"), ("density", 0.0, "a number > 0"), ("mass_damping", -0.1, "a number >= 0"),
    ("stiffness_damping", float("inf"), "a finite number"), ("plastic_yield", -0.1, "a number >= 0"),
])
def test_a_material_is_checked_when_it_is_made_and_changed(name, value, expected):
    material = palpate.Material()
    before = repr(material)
    for attempt in (lambda: palpate.Material(**{name: value}), lambda: setattr(material, name, value)):
        with pytest.raises(palpate.Error) as caught:
            attempt()
        assert (caught.value.source, caught.value.where, caught.value.expected) == ("Material", name, expected)
    assert repr(material) == before


def test_names_for_type_checkers_are_those_of_scenes(root):
    contact = json.loads((root / "docs/scene.schema.json").read_text())["properties"]["contact"]["properties"]
    for key, names in [("structure", _names.Structure), ("order", _names.Order), ("sort", _names.Sort)]:
        assert set(typing.get_args(names)) == set(contact[key]["enum"]), key
    assert set(typing.get_args(_names.CellSizeRule)) == set(contact["cell_size"]["oneOf"][0]["enum"])
    schema = json.loads((root / "docs/scene.schema.json").read_text())
    assert list(typing.get_args(_names.Field)) == schema["properties"]["output"]["properties"]["fields"]["items"]["enum"]
    for method, parameter in [(palpate.Simulation.field, "name"), (palpate.Simulation.to_pyvista, "fields")]:
        assert "Field" in method.__annotations__[parameter]
    tissues = schema["$defs"]["material"]["properties"]["tissue"]["enum"]
    assert list(typing.get_args(_names.Tissue)) == tissues
    # The types of the compiled module: constructor, getters and setters of a material.
    types = pathlib.Path(palpate.__file__).with_name("_core.pyi").read_text()
    material, = re.findall(r"(?ms)^class Material:\n(.*?)^class ", types)
    assert re.search(r"def tissue\(name: (typing\.)?Literal\[" + re.escape(str(tissues)[1:-1]), material)
    for key, names, default in [("model", _names.MaterialModel, "corotational"), ("elements", _names.ElementKind, "linear")]:
        known = schema["$defs"]["material"]["properties"][key]["enum"]
        assert list(typing.get_args(names)) == known
        literal = re.escape(str(known)[1:-1])
        assert len(re.findall(rf"{key}: (?:typing\.)?Literal\[{literal}\] = '{default}'", material)) == 1
        assert re.search(rf"def {key}\(self\) -> (?:typing\.)?Literal\[{literal}\]:", material)
        assert re.search(rf"def {key}\(self, arg: (?:typing\.)?Literal\[{literal}\], /\) -> None", material)


def notebook(code):
    """Runs code like a notebook: its functions belong to a __main__ without a file."""
    return subprocess.run([sys.executable, "-"], input=code, capture_output=True, text=True, timeout=300)


STUDY = f"""
import palpate
factor = 2.0
def measure(simulation):
    return {{"twice": factor * simulation.metrics.step}}
table = palpate.sweep({SCENE!r}, {{"time_step": [0.01, 0.025]}}, measure=measure, workers=2)
print(table["twice"].tolist(), table["status"].tolist())
"""


def test_a_sweep_takes_functions_of_a_notebook():
    done = notebook(STUDY)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "[10.0, 4.0] ['done', 'done']\n"


def test_a_sweep_without_cloudpickle_says_what_a_notebook_needs():
    done = notebook("import sys\nsys.modules['cloudpickle'] = None\n" + STUDY)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].endswith("sweep: measure: found a function of a notebook, without the package "
                                                 "cloudpickle, expected the package cloudpickle, which can send it to other "
                                                 "processes: pip install 'palpate[study]'")


def test_a_sweep_takes_lambdas_and_says_where_a_function_failed():
    def fails(simulation):
        return {"share": 1 / (simulation.metrics.step - 5)}

    table = palpate.sweep(SCENE, {"time_step": [0.01, 0.025]}, measure=fails, workers=1,
                          apply=lambda scene, values: scene.update(time_step=values["time_step"]))
    assert table["status"].tolist() == ["failed", "done"] and table["share"][1] == pytest.approx(-1 / 3)
    line = fails.__code__.co_firstlineno + 1
    assert table["error"][0] == f"ZeroDivisionError: division by zero (line {line} of {__file__}, in fails)"
    assert table["traceback"][0].startswith("Traceback") and "in fails" in table["traceback"][0]
    assert table["traceback"][1] == ""


def test_python_m_palpate_is_the_command(command, tmp_path):
    """The package with the command in it, as in a wheel, and without."""
    package = os.path.dirname(palpate.__file__)
    run = [sys.executable, "-m", "palpate", "--version"]
    without = subprocess.run(run, capture_output=True, text=True)
    assert without.returncode == 1 and without.stderr.startswith("palpate: error: this package was built without the palpate command")
    (tmp_path / "palpate/bin").mkdir(parents=True)
    for name in os.listdir(package):
        if name != "bin":
            os.symlink(os.path.join(os.path.realpath(package), name), tmp_path / "palpate" / name)
    os.unlink(tmp_path / "palpate/__main__.py")
    (tmp_path / "palpate/__main__.py").write_bytes(open(os.path.join(package, "__main__.py"), "rb").read())
    os.symlink(command, tmp_path / "palpate/bin/palpate")
    with_it = subprocess.run(run, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": str(tmp_path)})
    assert with_it.stdout.startswith(f"palpate {palpate.__version__} (")


def test_errors_name_types_with_their_article():
    for value, words in [(object(), "an object"), (range(3), "a range"), (3, "3")]:
        with pytest.raises(palpate.Error, match=f"found {words}, expected the path of a scene file"):
            palpate.Simulation(value)
