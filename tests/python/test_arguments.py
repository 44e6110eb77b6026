"""Arguments of a wrong type: one line, which says what was found and what was expected, in every public function."""

import inspect
import re

import numpy as np
import pytest

import palpate

POINTS, TETS = palpate.box((2, 2, 2), (0.1, 0.1, 0.1))
ALL = np.arange(len(POINTS))
KEY = palpate.Keyframe(0.0)
MOTION = palpate.Motion([KEY])
TISSUE = palpate.Material(young_modulus=1e5)
SCENE = {"bodies": [{"ball": {"radius": 1.0, "resolution": 1}, "material": {}}]}
ABOUT = (0.0, 0.0, 0.0)


def a_model():
    model = palpate.Model()
    model.add_body(POINTS, TETS, name="block", material=TISSUE)
    model.prescribe(0, ALL[:2], MOTION)
    model.add_body(POINTS + [0.0, 0.0, 0.3], TETS, name="probe", motion=MOTION)
    return model


def a_simulation():
    made = palpate.Simulation(a_model(), reactions=True)
    made.step()
    return made


SIMULATION = a_simulation()

# For each public function with parameters a call that is right, but for what it would change.
CALLS = {
    "Bodies.__getitem__": (lambda: a_model().bodies.__getitem__, {"": 0}),
    "Fibres": (lambda: palpate.Fibres, {"direction": (1, 0, 0), "stiffness": 1.0, "exponent": 1.0, "active_stress": 1.0, "activation": None}),
    "Grab.move": (lambda: SIMULATION.grab(0, ABOUT, 1.0).move, {"target": ABOUT}),
    "Keyframe": (lambda: palpate.Keyframe, {"time": 0.0, "translate": ABOUT, "quaternion": (1, 0, 0, 0)}),
    "Material": (lambda: palpate.Material, {
        "young_modulus": 1e5, "poisson_ratio": 0.3, "density": 1.0, "mass_damping": 0.0, "stiffness_damping": 0.0, "plastic_yield": None,
        "plastic_creep": 0.0, "plastic_maximum": None, "model": "corotational", "mooney_fraction": 0.5, "elements": "linear", "fibres": None,
        "viscosity": None}),
    "Material.tissue": (lambda: palpate.Material.tissue, {"name": "liver"}),
    "Model.add_body": (lambda: a_model().add_body, {
        "points": POINTS, "tets": TETS, "name": "a", "material": TISSUE, "fixed": (), "velocity": ABOUT, "angular_velocity": ABOUT,
        "gravity": ABOUT, "obstacle": False, "motion": None, "self_collision": False}),
    "Model.add_region": (lambda: a_model().add_region, {"body": 0, "tets": [0], "material": TISSUE}),
    "Model.attach": (lambda: a_model().attach, {"body": 0, "points": [5], "to": 1, "stiffness": None}),
    "Model.from_scene": (lambda: palpate.Model.from_scene, {"scene": SCENE}),
    "Model.grab": (lambda: a_model().grab, {"body": 0, "point": 3, "target": ABOUT, "stiffness": 1.0}),
    "Model.load": (lambda: a_model().load, {"body": 0, "points": [3], "force": ABOUT, "ramp": None}),
    "Model.load_surface": (lambda: a_model().load_surface, {"body": 0, "points": ALL, "pressure": 1.0, "traction": ABOUT, "ramp": None}),
    "Model.prescribe": (lambda: a_model().prescribe, {"body": 0, "points": [3], "motion": MOTION}),
    "Model.set_fibres": (lambda: a_model().set_fibres, {"body": 0, "directions": np.ones((len(TETS), 3))}),
    "Model.set_fibres_between": (lambda: a_model().set_fibres_between, {"body": 0, "start": [0], "end": [26]}),
    "Motion": (lambda: palpate.Motion, {"keyframes": [KEY], "center": ABOUT, "interpolation": "smooth"}),
    "Ramp": (lambda: palpate.Ramp, {"times": [0.0], "factors": [1.0]}),
    "Simulation": (lambda: palpate.Simulation, {"scene": SCENE, "threads": 1, "time_step": 0.01}),
    "Simulation.body_number": (lambda: SIMULATION.body_number, {"body": "probe"}),
    "Simulation.center_of_mass": (lambda: SIMULATION.center_of_mass, {"body": 0}),
    "Simulation.change": (lambda: SIMULATION.change, {"gravity": ABOUT}),
    "Simulation.contact_wrench": (lambda: SIMULATION.contact_wrench, {"body": 0, "about": ABOUT}),
    "Simulation.field": (lambda: SIMULATION.field, {"name": "stress", "of": "tets"}),
    "Simulation.grab": (lambda: SIMULATION.grab, {"point": 0, "target": ABOUT, "stiffness": 1.0}),
    "Simulation.grab_wrench": (lambda: SIMULATION.grab_wrench, {"body": 0, "about": ABOUT}),
    "Simulation.insert": (lambda: SIMULATION.insert, {"body": 0}),
    "Simulation.motor": (lambda: SIMULATION.motor, {"body": "probe", "about": ABOUT}),
    "Simulation.move_prescribed": (lambda: SIMULATION.move_prescribed, {"number": 0, "pose": ABOUT, "quaternion": (1, 0, 0, 0)}),
    "Simulation.move_to": (lambda: SIMULATION.move_to, {"body": 1, "pose": ABOUT, "quaternion": (1, 0, 0, 0)}),
    "Simulation.pair_wrenches": (lambda: SIMULATION.pair_wrenches, {"about": ABOUT}),
    "Simulation.reaction": (lambda: SIMULATION.reaction, {"body": "probe", "about": ABOUT}),
    "Simulation.reaction_of_prescribed": (lambda: SIMULATION.reaction_of_prescribed, {"number": 0, "about": ABOUT}),
    "Simulation.record_reactions": (lambda: SIMULATION.record_reactions, {"on": True}),
    "Simulation.remove": (lambda: SIMULATION.remove, {"body": 0}),
    "Simulation.restore": (lambda: SIMULATION.restore, {"saved": b""}),
    "Simulation.run": (lambda: SIMULATION.run, {"steps": 0, "callback": None}),
    "Simulation.set_force": (lambda: SIMULATION.set_force, {"point": 0, "force": ABOUT}),
    "Simulation.set_forces": (lambda: SIMULATION.set_forces, {"points": [0], "forces": ABOUT}),
    "Simulation.set_motion": (lambda: SIMULATION.set_motion, {"body": "probe", "motion": MOTION}),
    "Simulation.set_positions": (lambda: SIMULATION.set_positions, {"positions": POINTS[5:7], "points": [5, 6]}),
    "Simulation.set_prescribed": (lambda: SIMULATION.set_prescribed, {"number": 0, "motion": MOTION}),
    "Simulation.set_pressure": (lambda: SIMULATION.set_pressure, {"triangles": [0, 1], "pressure": [1.0, 2.0]}),
    "Simulation.set_velocities": (lambda: SIMULATION.set_velocities, {"velocities": ABOUT, "points": [5]}),
    "Simulation.tie": (lambda: SIMULATION.tie, {"points": [5], "to": "probe", "stiffness": 1.0}),
    "Simulation.tie_wrench": (lambda: SIMULATION.tie_wrench, {"body": 0, "about": ABOUT}),
    "Simulation.to_pyvista": (lambda: SIMULATION.to_pyvista, {"fields": ["stress"]}),
    "Simulation.untie": (lambda: SIMULATION.untie, {"body": 0, "other": 1}),
    "SimulationBodies.__getitem__": (lambda: SIMULATION.bodies.__getitem__, {"body": 0}),
    "SimulationBody.contact_wrench": (lambda: SIMULATION.bodies[0].contact_wrench, {"about": ABOUT}),
    "SimulationBody.fix": (lambda: SIMULATION.bodies[0].fix, {"points": [5]}),
    "SimulationBody.grab_wrench": (lambda: SIMULATION.bodies[0].grab_wrench, {"about": ABOUT}),
    "SimulationBody.motor": (lambda: SIMULATION.bodies[1].motor, {"about": ABOUT}),
    "SimulationBody.move": (lambda: SIMULATION.bodies[0].move, {"motion": MOTION, "points": [7]}),
    "SimulationBody.move_to": (lambda: SIMULATION.bodies[1].move_to, {"pose": ABOUT, "quaternion": (1, 0, 0, 0)}),
    "SimulationBody.reaction": (lambda: SIMULATION.bodies[1].reaction, {"about": ABOUT}),
    "SimulationBody.tie_wrench": (lambda: SIMULATION.bodies[0].tie_wrench, {"about": ABOUT}),
    "Simulation.tissue_at_points": (lambda: SIMULATION.tissue_at_points, {"of_tets": SIMULATION.tissue()}),
    "SimulationBody.release": (lambda: SIMULATION.bodies[0].release, {"points": [5]}),
    "SimulationBody.set_forces": (lambda: SIMULATION.bodies[0].set_forces, {"forces": ABOUT, "points": [5]}),
    "SimulationBody.set_motion": (lambda: SIMULATION.bodies[1].set_motion, {"motion": MOTION}),
    "SimulationBody.set_positions": (lambda: SIMULATION.bodies[0].set_positions, {"positions": POINTS[5:6], "points": [5]}),
    "SimulationBody.set_pressure": (lambda: SIMULATION.bodies[0].set_pressure, {"pressure": 1.0, "triangles": [0]}),
    "SimulationBody.set_velocities": (lambda: SIMULATION.bodies[0].set_velocities, {"velocities": ABOUT, "points": [5]}),
    "Viscosity": (lambda: palpate.Viscosity, {"fractions": [0.1], "times": [1.0]}),
    "World": (lambda: palpate.World, {
        "structure": "compact", "order": "z", "sort": "radix", "cell_size": 1.0, "cells_per_primitive": 8, "edge_contacts": True,
        "coherence": True, "budget": None, "threads": 1}),
    "World.add": (lambda: palpate.World().add, {"points": POINTS, "tets": TETS, "name": "a"}),
    "World.from_scene": (lambda: palpate.World.from_scene, {"scene": SCENE, "threads": 1}),
    "World.set_pair_filter": (lambda: palpate.World().set_pair_filter, {"ignored": []}),
    "World.to_pyvista": (lambda: palpate.World.from_scene(SCENE).to_pyvista, {"positions": np.zeros((1, 3))}),
    "World.update": (lambda: palpate.World.from_scene(SCENE).update, {"positions": np.zeros((1, 3))}),
    "Wrench.moved_to": (lambda: SIMULATION.contact_wrench(0).moved_to, {"about": ABOUT}),
    "ball": (lambda: palpate.ball, {"radius": 1.0, "resolution": 1}),
    "box": (lambda: palpate.box, {"cells": (1, 1, 1), "size": (1, 1, 1)}),
    "detect": (lambda: palpate.detect, {
        "points": POINTS, "tets": TETS, "body": [0] * len(TETS), "structure": "compact", "cells_per_primitive": 8,
        "threads": 1}),
    "read_mesh": (lambda: palpate.read_mesh, {"file": "none.msh"}),
    "read_scene": (lambda: palpate.read_scene, {"scene": "none.json"}),
    "set_threads": (lambda: palpate.set_threads, {"count": 0}),
    "stacking_scene": (lambda: palpate.stacking_scene, {"count": 2, "cells": (1, 1, 1), "seed": 1}),
    "sweep": (lambda: palpate.sweep, {"scene": SCENE, "parameters": {"time_step": [0.01]}, "steps": 1, "workers": 1, "threads": 1}),
    "sweep_rows": (lambda: palpate.sweep_rows, {"scene": SCENE, "parameters": {"time_step": [0.01]}, "steps": 1, "workers": 1, "threads": 1}),
    "to_pyvista": (lambda: palpate.to_pyvista, {"points": POINTS, "tets": TETS}),
    "write_mesh": (lambda: palpate.write_mesh, {"file": "none/none.vtk", "points": POINTS, "tets": TETS, "point_data": None, "cell_data": None}),
    "write_scene": (lambda: palpate.write_scene, {"scene": SCENE, "file": "none/none.json"}),
}

# Taken as they come: anything is true or false, or a function of the caller's own that is called later.
ANY = {"Simulation.run": {"until_rest", "progress"}, "Simulation": {"reactions"}, "detect": {"self_collision"}, "World.add": {"movable", "self_collision"},
       **{name: {"until_rest", "progress", "retry_failed", "client", "apply", "measure", "folder"} for name in ("sweep", "sweep_rows")}}


def names_of(function):
    """Names of parameters, of compiled functions too."""
    signature = getattr(function, "__nb_signature__", None)
    if signature is None:
        kinds = (inspect.Parameter.VAR_KEYWORD, inspect.Parameter.VAR_POSITIONAL)
        return [p.name for p in inspect.signature(function).parameters.values() if p.name not in ("self", "cls") and p.kind not in kinds]
    inside = re.sub(r"\[[^][]*\]", "", re.sub(r"\[[^][]*\]", "", signature[0][0].split("(", 1)[1].rsplit(" ->", 1)[0]))
    return [name for name in re.findall(r"(\w+): ", inside) if name != "arg"]


def public_functions():
    for name in palpate.__all__:
        value = getattr(palpate, name)
        if not inspect.isclass(value):
            if callable(value):
                yield name, value
            continue
        if issubclass(value, (Exception, palpate.Outcome)):
            continue
        members = {key: member for base in reversed(value.__mro__) if base.__module__.startswith("palpate")
                   for key, member in vars(base).items()}
        for key, member in members.items():
            member = getattr(member, "__func__", member)
            if key == "__init__" and name not in ("Grab", "SimulationBodies", "SimulationBody"):
                yield name, member
            elif (not key.startswith("_") or key == "__getitem__") and callable(member):
                yield f"{name}.{key}", member


def test_every_public_function_is_in_the_table():
    checked = 0
    for name, function in public_functions():
        parameters = [] if str(inspect.signature(function) if not hasattr(function, "__nb_signature__") else "") == "(self, /, *args, **kwargs)" else names_of(function)
        if not parameters:
            continue
        assert name in CALLS, f"{name}({', '.join(parameters)})"
        assert set(parameters) - ANY.get(name, set()) <= set(CALLS[name][1]), name
        checked += 1
    assert checked > 60


class Odd:
    """No number, text, sequence or function."""


@pytest.mark.parametrize("name", CALLS)
def test_a_wrong_type_is_one_line(name):
    function, right = CALLS[name]
    for parameter in right:
        values = {**right, parameter: Odd()}
        with pytest.raises(palpate.Error) as caught:
            function()(*values.values()) if "" in values else function()(**values)
        text = str(caught.value)
        assert re.fullmatch(r"[^\n]+: found [^\n]+, expected [^\n]+", text), text
        assert "incompatible function" not in text and "_core" not in text and " _" not in text
        assert "Odd" in text, f"{parameter}: {text}"


def test_properties_say_their_names():
    material, key, motion, ramp = palpate.Material(), palpate.Keyframe(0.0), palpate.Motion([KEY]), palpate.Ramp([], [])
    for owner in (material, key, motion, ramp):
        setters = [name for name, member in vars(type(owner)).items() if getattr(member, "fset", None) is not None]
        assert len(setters) >= 2
        for name in setters:
            with pytest.raises(palpate.Error, match=rf"^{type(owner).__name__}: {name}: found an Odd, expected [^\n]+$"):
                setattr(owner, name, Odd())


def test_what_is_said():
    """By hand, word by word. It is a TypeError too, as Python programmers expect it."""
    model = a_model()
    for text, wrong in [
        ("Simulation.set_motion: motion: found 3, expected a palpate.Motion", lambda: SIMULATION.set_motion("probe", 3)),
        ("SimulationBody.move: motion: found None, expected a palpate.Motion", lambda: SIMULATION.bodies[0].move(None)),
        ("Model.load_surface: pressure: found [1.0, 2], expected a number", lambda: model.load_surface(0, ALL, pressure=[1.0, 2])),
        ("Simulation.record_reactions: on: found 'x', expected True or False", lambda: SIMULATION.record_reactions("x")),
        ("Simulation.grab: stiffness: found 'x', expected a number", lambda: SIMULATION.grab(0, ABOUT, "x")),
        ("Keyframe: translate: found (1, 2), expected a sequence of numbers of another length", lambda: palpate.Keyframe(0.0, (1, 2))),
        ("Motion: keyframes: found [3], expected a sequence of Keyframe objects", lambda: palpate.Motion([3])),
        ("Motion: centre: found an argument of this name, expected 'center'",
         lambda: palpate.Motion([KEY], centre=3)),
        ("Material: young_modulus: found 'a', expected a number", lambda: palpate.Material(young_modulus="a")),
        ("Material: tissue: found 'liver', expected palpate.Material.tissue('liver')", lambda: palpate.Material(tissue="liver")),
        ("Material: found ('liver'), expected palpate.Material.tissue('liver')", lambda: palpate.Material("liver")),
        ("Material: found (1000.0), expected arguments by name, as young_modulus=1e4", lambda: palpate.Material(1e3)),
        ("Material: young_modulu: found an argument of this name, expected 'young_modulus'", lambda: palpate.Material(young_modulu=1.0)),
        ("Keyframe: found 4 arguments, expected at most 3", lambda: palpate.Keyframe(0.0, ABOUT, (1, 0, 0, 0), 5)),
        ("Ramp: factors: found nothing, expected a value", lambda: palpate.Ramp([0.0])),
        ("Simulation.step: found an argument, expected at most 0", lambda: SIMULATION.step(1)),
        ("ball: resolution: found 1.5, expected an integer", lambda: palpate.ball(1.0, 1.5)),
        ("stacking_scene: seed: found None, expected an integer", lambda: palpate.stacking_scene(seed=None)),
    ]:
        with pytest.raises(palpate.Error) as caught:
            wrong()
        assert str(caught.value) == text and isinstance(caught.value, TypeError)


def test_errors_of_callers_pass():
    """An error inside an argument is not ours."""

    class Broken:
        def __len__(self):
            raise RuntimeError("mine")

        def __getitem__(self, _):
            raise RuntimeError("mine")

    with pytest.raises(RuntimeError, match="mine"):
        SIMULATION.run(1, callback=lambda s: Broken()[0])
    with pytest.raises(KeyError):
        SIMULATION.bodies["nobody"]


def test_numbers_of_models_are_finite():
    model = a_model()
    for wrong, message in [(lambda: model.load(0, ALL, (np.nan, 0, 0)), "force: found .nan"),
                           (lambda: model.load_surface(0, ALL, traction=(0, np.inf, 0)), "traction: found .0.0, inf"),
                           (lambda: model.load_surface(0, ALL, pressure=np.float32(np.nan)), "pressure: found nan"),
                           (lambda: model.grab(0, 0, (0, 0, np.nan), 1.0), "target: found "),
                           (lambda: model.add_body(POINTS, TETS, material=TISSUE, gravity=(0, 0, np.inf)), "gravity: found ")]:
        with pytest.raises(palpate.Error, match=message):
            wrong()
    assert len(model.bodies) == 2, "what is refused adds no body"


def test_names_of_bodies_are_as_in_scenes():
    """Not empty, no NUL, each once; those that are given for None, too."""
    world, model = palpate.World(), palpate.Model()
    for owner, add in [("World.add", lambda name: world.add(POINTS, TETS, name=name)),
                       ("Model.add_body", lambda name: model.add_body(POINTS, TETS, name=name, obstacle=True))]:
        assert add("liver") == 0
        for name, message in [("liver", "'liver' for the second time"), ("", "an empty text"), ("a\0b", "a NUL character")]:
            with pytest.raises(palpate.Error, match=f"{owner}: name: found {message}"):
                add(name)
        assert add(None) == 1 and add("body 3") == 2
        with pytest.raises(palpate.Error, match="'body 3' for the second time"):
            add(None)
    assert [len(owner.bodies) for owner in (world, model)] == [3, 3]


def test_a_model_without_bodies_says_so():
    for wrong in [lambda: palpate.Model().load_surface(0, ALL, pressure=1.0), lambda: palpate.Model().load("a", ALL, ABOUT)]:
        with pytest.raises(palpate.Error, match="there is none yet"):
            wrong()


def test_values_of_scenes_that_are_not_finite_are_named():
    box = {"box": {"cells": [1, 1, 1], "size": [1, 1, np.float64(np.inf)]}, "material": {"density": np.nan}}
    for scene, message in [({"bodies": [box]}, r"bodies\[0\].box.size\[2\]: found inf, expected a finite number"),
                           ({"gravity": np.array([0, 0, np.nan]), "bodies": []}, r"gravity\[2\]: found nan")]:
        with pytest.raises(palpate.Error, match=message):
            palpate.Simulation(scene)
