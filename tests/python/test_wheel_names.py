"""The lines of the docs and the Dockerfile that install a wheel, verbatim, where dist/ has all that './dev wheel --arch aarch64' makes."""

import os
import pathlib
import platform
import re
import subprocess
import sys
import zipfile

import pytest

TAGS = ["cp311-cp311-manylinux_2_35_x86_64", "cp312-abi3-manylinux_2_35_x86_64", "cp311-cp311-manylinux_2_35_aarch64",
        "cp312-abi3-manylinux_2_35_aarch64"]


def version(root):
    return re.search(r"palpate VERSION ([0-9.]+)", (root / "CMakeLists.txt").read_text())[1]


@pytest.fixture
def place(root, tmp_path):
    """A folder with a dist/ of empty wheels that contain their own name."""
    (tmp_path / "dist").mkdir()
    info = f"palpate-{version(root)}.dist-info"
    for tag in TAGS:
        with zipfile.ZipFile(tmp_path / f"dist/palpate-{version(root)}-{tag}.whl", "w") as wheel:
            wheel.writestr("tag.txt", tag)
            wheel.writestr(f"{info}/METADATA", f"Metadata-Version: 2.1\nName: palpate\nVersion: {version(root)}\n")
            wheel.writestr(f"{info}/WHEEL", f"Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: false\nTag: {tag}\n")
            wheel.writestr(f"{info}/RECORD", "")
    return tmp_path


def installed_by(line, python, machine, place):
    """The wheel that pip chooses for this line, Python and machine."""
    target = place / f"site-{python}-{machine}"
    (place / "bin").mkdir(exist_ok=True)
    for name, text in [("pip", f'exec "{sys.executable}" -m pip "$@"'), ("uname", f"echo {machine}")]:
        (place / "bin" / name).write_text(f"#!/bin/sh\n{text}\n")
        (place / "bin" / name).chmod(0o755)
    settings = {"PIP_TARGET": str(target), "PIP_PYTHON_VERSION": python, "PIP_PLATFORM": f"manylinux_2_35_{machine}", "PIP_ONLY_BINARY": ":all:",
                "PIP_NO_INDEX": "1", "PIP_DISABLE_PIP_VERSION_CHECK": "1", "PATH": f"{place}/bin:{os.environ['PATH']}", "HOME": str(place)}
    done = subprocess.run(["bash", "-c", line], cwd=place, env=settings, capture_output=True, text=True)
    assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"
    return (target / "tag.txt").read_text()


@pytest.mark.parametrize("page", ["docs/install.md", "docs/python.md"])
def test_the_lines_of_the_docs_take_the_wheel_of_that_python(root, place, page):
    first, second = (line for line in (root / page).read_text().splitlines() if line.startswith("pip install dist/"))
    assert installed_by(first, "3.11", "x86_64", place) == TAGS[0]
    assert installed_by(second, "3.12", "x86_64", place) == TAGS[1]
    assert installed_by(second, "3.13", "x86_64", place) == TAGS[1]


@pytest.mark.parametrize(("machine", "tag"), [("x86_64", TAGS[0]), ("aarch64", TAGS[2])])
def test_the_dockerfile_takes_the_wheel_of_its_machine(root, place, machine, tag):
    lines = (root / "Dockerfile").read_text().splitlines()
    pattern, = (line.split()[1] for line in lines if line.startswith("COPY "))
    (place / "tmp").mkdir()
    for file in place.glob(pattern):
        os.link(file, place / "tmp" / file.name)
    install, = (part for line in lines if line.startswith("RUN ") for part in line.split("&&") if "pip install" in part)
    line = install.strip().replace("/opt/palpate/bin/pip", "pip").replace("/tmp/", f"{place}/tmp/")
    assert installed_by(line, "3.11", machine, place) == tag


def test_the_test_of_real_wheels_takes_that_of_this_machine(place):
    import test_wheel

    found = test_wheel.wheel_of(place / "dist", "/usr/bin/python3")
    assert found.name.endswith(f"_{platform.machine()}.whl") and isinstance(found, pathlib.Path)
