"""The wheel: its content, its dependencies, and that it works alone. The quick one uses the existing build."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import zipfile

import pytest

TEN_LINES = "examples/detect.py"


def run(*arguments, **options):
    done = subprocess.run(arguments, capture_output=True, text=True, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def check_wheel(wheel, root, tmp_path, python):
    """Its files, the system libraries that it needs, and an example without any other of our files."""
    names = [pathlib.PurePath(name) for name in zipfile.ZipFile(wheel).namelist()]
    own = {name.name for name in names if name.parts[0] == "palpate"}
    assert {"__init__.py", "_core.pyi", "py.typed", "_world.py"} <= own
    assert all(name.parts[0] == "palpate" or name.parts[0].endswith(".dist-info") for name in names)
    module = next(name for name in own if name.startswith("_core.") and name.endswith(".so"))
    zipfile.ZipFile(wheel).extractall(tmp_path / "site")
    needed = run("ldd", tmp_path / "site/palpate" / module)
    assert "vtk" not in needed.lower() and "not found" not in needed
    allowed = ("linux-vdso", "libhwy", "libz.", "libstdc++", "libm.", "libgcc_s", "libc.", "ld-linux", "libpthread")
    for line in needed.splitlines():
        assert pathlib.PurePath(line.split()[0]).name.startswith(allowed), line
    assert str(tmp_path) in next(line for line in needed.splitlines() if "libhwy" in line)  # its own copy
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    output = run(python, root / TEN_LINES, env={**environment, "PYTHONPATH": str(tmp_path / "site")}, cwd=tmp_path)
    assert "contacts, the deepest" in output
    assert os.path.getsize(wheel) < 5e6


def test_the_wheel_of_what_is_compiled(root, tmp_path):
    run(sys.executable, "-m", "pip", "wheel", root, "--no-deps", "--no-build-isolation", "--quiet",
        "--disable-pip-version-check", "--wheel-dir", tmp_path, "--config-settings", f"build-dir={tmp_path / 'build'}",
        "--config-settings", f"cmake.define.PALPATE_PYTHON_COMPILED={os.environ['PALPATE_BUILD_DIR']}/python/palpate")
    wheel, = tmp_path.glob("*.whl")
    check_wheel(wheel, root, tmp_path, sys.executable)


@pytest.mark.long
def test_the_sdist_compiles_in_a_fresh_environment(root, tmp_path):
    """Like a user: a new virtual environment, pip install of the sdist, the ten lines of README.md. The test Wheel.made makes it."""
    version = re.search(r"palpate VERSION ([0-9.]+)", (root / "CMakeLists.txt").read_text())[1]
    sdist = root / f"dist/palpate-{version}.tar.gz"
    assert os.path.getsize(sdist) < 2e6
    run(sys.executable, "-m", "venv", tmp_path / "venv")
    python = tmp_path / "venv/bin/python"
    flags, environment = [], {**os.environ, "TMPDIR": str(tmp_path)}
    if shutil.which("ccache"):  # the compiler and flags of ./dev wheel, so that ccache has most of it
        environment |= {"CXX": "c++", "CMAKE_CXX_COMPILER_LAUNCHER": "ccache", "CCACHE_BASEDIR": str(tmp_path), "CCACHE_NOHASHDIR": "1"}
        flags = ["--config-settings", "cmake.define.PALPATE_WERROR=ON"]
    run(python, "-m", "pip", "wheel", sdist, "--no-deps", "--quiet", "--disable-pip-version-check", "--wheel-dir", tmp_path, *flags, env=environment)
    wheel, = tmp_path.glob(f"palpate-{version}-*.whl")
    run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", wheel)
    check_wheel(wheel, root, tmp_path, python)
