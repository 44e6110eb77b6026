"""The wheel of the stable ABI: its symbols, and that every installed Python from 3.12 on runs it."""

import json
import os
import pathlib
import platform
import re
import subprocess
import zipfile

import pytest
from test_wheel import run, wheel_of

pytestmark = pytest.mark.long

# The folders in which ./dev wheel looks for the newest Python.
PLACES = [pathlib.Path.home() / ".pyenv/versions", "3.1[2-9]*/bin/python"], ["/usr/local/bin", "python3.1[2-9]"], ["/usr/bin", "python3.1[2-9]"]
PYTHONS = [str(python) for folder, pattern in PLACES for python in sorted(pathlib.Path(folder).glob(pattern))]


@pytest.fixture(scope="module")
def wheel(root):
    """The test Wheel.made makes it if there is such a Python."""
    version = re.search(r"palpate VERSION ([0-9.]+)", (root / "CMakeLists.txt").read_text())[1]
    (found,) = (root / "dist").glob(f"palpate-{version}-cp312-abi3-manylinux_*_{platform.machine()}.whl")
    return found


@pytest.mark.skipif(not PYTHONS, reason="there is no Python 3.12 or later")
def test_its_module_asks_for_nothing_but_the_stable_abi(root, wheel, tmp_path):
    """By abi3audit, which has CPython's list. It must find the other symbols in the module for Python 3.11."""
    audit = [root / "build/wheel-python-3.11/bin/python", "-m", "abi3audit", "--strict", "--report"]
    (report,) = json.loads(run(*audit, wheel))["specs"].values()
    (module,) = report["wheel"]
    assert module["result"]["is_abi3"] and (module["result"]["baseline"], module["result"]["non_abi3_symbols"]) == ("3.12", [])

    other = wheel_of(root / "dist", "/usr/bin/python3", wheel.name.split("-")[1])
    name = next(name for name in zipfile.ZipFile(other).namelist() if name.startswith("palpate/_core."))
    (tmp_path / "_core.abi3.so").write_bytes(zipfile.ZipFile(other).read(name))
    failed = subprocess.run([*audit, "--assume-minimum-abi3", "3.12", tmp_path / "_core.abi3.so"], capture_output=True, text=True)
    assert failed.returncode == 1 and '"is_abi3": false' in failed.stdout, failed.stderr


@pytest.mark.parametrize("python", PYTHONS or [pytest.param("", marks=pytest.mark.skip("there is no Python 3.12 or later"))])
def test_it_runs_with_each_python_and_has_the_bits_of_the_command(wheel, python, command, root, tmp_path):
    outside = {name: value for name, value in os.environ.items() if name.startswith("PIP_")}
    alone = {"PATH": f"{tmp_path}/venv/bin:/usr/bin:/bin", "HOME": str(tmp_path)}
    run(python, "-m", "venv", tmp_path / "venv")
    run(tmp_path / "venv/bin/pip", "install", "--quiet", "--disable-pip-version-check", "--only-binary", ":all:", wheel, env={**outside, **alone})
    scene = root / "scenes/ball-on-plate.json"
    code = "import palpate, sys; s = palpate.Simulation(sys.argv[1]); s.run(3); print(s.state_hash, '%d.%d' % sys.version_info[:2], repr(s))"
    hash_, version, shown = run(tmp_path / "venv/bin/python", "-I", "-c", code, scene, env=alone, cwd=tmp_path).split(maxsplit=2)
    assert version in run(python, "--version") and shown.startswith("<palpate.Simulation: step 3")
    by_the_build = run(command, "run", scene, "--steps", "3", "--json", "--no-picture", "--out", "build", cwd=tmp_path)
    by_the_wheel = run("palpate", "run", scene, "--steps", "3", "--json", "--out", "wheel", env=alone, cwd=tmp_path)
    assert f'"state_hash": "{hash_}"' in by_the_build and f'"state_hash": "{hash_}"' in by_the_wheel
    assert (tmp_path / "wheel/picture.png").read_bytes().startswith(b"\x89PNG")
    assert run(tmp_path / "venv/bin/python", "-m", "palpate", "-V", env=alone) == run("palpate", "--version", env=alone)
