"""The public package: documented, typed, fast to import, with docstrings from the C++ comments."""

import inspect
import os
import pathlib
import re
import subprocess
import sys

import pytest

import palpate


def public_names():
    """(name, object) of all public names of the package and members of its classes."""
    for name in palpate.__all__:
        value = getattr(palpate, name)
        if name == "__version__":
            continue
        yield name, value
        if inspect.isclass(value):
            for member in dir(value):
                if not member.startswith("_"):
                    yield f"{name}.{member}", inspect.getattr_static(value, member)


def text_of(value):
    if isinstance(value, (classmethod, staticmethod)):
        value = value.__func__
    return (getattr(value, "__doc__", None) or "").strip()


def test_every_public_name_is_documented():
    names = dict(public_names())
    assert len(names) > 100
    inherited = {name for name in dir(ValueError)}
    for name, value in names.items():
        if name.startswith(("Error.", "NotConverged.")):
            if name.split(".")[1] in inherited:
                continue
        # The first line of a nanobind method's docstring is its signature.
        text = re.sub(r"^\w+\(.*\)( -> .*)?\n?", "", text_of(value)).strip()
        assert text, f"{name} has no docstring"


def test_the_check_of_docstrings_sees_a_missing_one():
    def bare(a: int) -> int:
        return a

    assert not text_of(bare)


def test_docstrings_are_the_comments_of_the_headers(root):
    header = re.sub(r"\s+", " ", (root / "include/palpate/detection.hpp").read_text().replace("///<", "").replace("///", ""))
    for value in [palpate.Contacts, palpate.Contacts.depth, palpate.Contacts.certainty, palpate.DetectionCounts.movers]:
        assert re.sub(r"\s+", " ", text_of(value)) in header
    assert "n x 3" in text_of(palpate.Contacts.direction)


def test_types_of_the_package_hold(root, tmp_path):
    """mypy, strict, on the installed package, a right program and a wrong one."""
    package = pathlib.Path(palpate.__file__).parent
    assert (package / "py.typed").exists() and "class Contacts" in (package / "_core.pyi").read_text()
    (tmp_path / "use.py").write_text("""
import numpy as np
import palpate

points, tets = palpate.box((2, 2, 2), (1.0, 1.0, 1.0))
contacts: palpate.Contacts = palpate.detect(points, tets)
deepest: float = contacts.depth.max()
world = palpate.World(structure="hash")
number: int = world.add(points, tets)
world.update(points)
movers: int = world.stats.movers
simulation = palpate.Simulation({"bodies": []}, gravity=(0, 0, 0))
energy: float = simulation.metrics.kinetic_energy
grab: palpate.Grab = simulation.grab(0, np.zeros(3), 1.0)
""")
    (tmp_path / "misuse.py").write_text("import palpate\nx: str = palpate.World().stats.movers\npalpate.detect(1)\n")
    cache = pathlib.Path(os.environ["PALPATE_BUILD_DIR"]) / "mypy"
    checked = subprocess.run([sys.executable, "-m", "mypy", "--config-file", root / "pyproject.toml", "--cache-dir", cache,
                              package, tmp_path / "use.py", tmp_path / "misuse.py"], capture_output=True, text=True,
                             cwd=package.parent)
    errors = [line for line in checked.stdout.splitlines() if "error:" in line]
    assert len(errors) == 2 and all("misuse.py" in line for line in errors), checked.stdout + checked.stderr


def test_import_does_not_load_what_few_need():
    script = "import sys, palpate; print([m for m in ('pandas', 'pyvista', 'meshio', 'dask', 'tqdm') if m in sys.modules])"
    output = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    assert output == "[]\n"


@pytest.mark.parametrize("package,call", [
    ("pandas", "palpate.sweep({}, {})"),
    ("pyvista", "palpate.to_pyvista(points, tets)"),
    ("meshio", "palpate.write_mesh('a.vtu', points, tets)"),
    ("tqdm", "palpate.Simulation(palpate.stacking_scene(2, (1, 1, 1))).run(1, progress=True)"),
])
def test_a_package_that_is_missing_is_named(package, call):
    script = (f"import sys; sys.modules[{package!r}] = None\nimport palpate\npoints, tets = palpate.box((1, 1, 1), (1, 1, 1))\n"
              f"try:\n    {call}\nexcept palpate.Error as error:\n    print(error)")
    output = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    assert f"no package {package}" in output and "pip install" in output
