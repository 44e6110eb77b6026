"""The wheels of ./dev wheel in bare virtual environments, without a compiler and our libraries."""

import os
import platform
import re
import subprocess
import zipfile

import pytest

pytestmark = pytest.mark.long


ALONE = {"PATH": "/usr/bin:/bin", "HOME": "/nonexistent"}  # without PYTHONPATH to the package of the build


def run(*arguments, env=ALONE, **options):
    done = subprocess.run([str(argument) for argument in arguments], capture_output=True, text=True, env=env, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def wheel_of(dist, python, version="*"):
    """The wheel in that folder for that Python and this machine."""
    tag = run(python, "-c", "import sys; print('cp%d%d' % sys.version_info[:2])").strip()
    found, = dist.glob(f"palpate-{version}-{tag}-*_{platform.machine()}.whl")
    return found


@pytest.fixture(scope="module")
def wheel(root):
    """The wheel for the system's Python; the test Wheel.made makes it: ./dev wheel --python /usr/bin/python3."""
    version = re.search(r"palpate VERSION ([0-9.]+)", (root / "CMakeLists.txt").read_text())[1]
    return wheel_of(root / "dist", "/usr/bin/python3", version)


@pytest.fixture(scope="module")
def venv(wheel, tmp_path_factory):
    """An environment with the wheel and NumPy only, and a PATH without compilers."""
    folder = tmp_path_factory.mktemp("wheel")
    run("/usr/bin/python3", "-m", "venv", folder / "venv")
    run(folder / "venv/bin/pip", "install", "--quiet", "--disable-pip-version-check", "--only-binary", ":all:", wheel,
        env={**{name: value for name, value in os.environ.items() if name.startswith("PIP_")}, "PATH": "/nowhere",
             "HOME": str(folder)})
    return folder / "venv"


def test_it_is_a_manylinux_wheel_with_all_that_it_needs(wheel):
    assert re.search(r"-manylinux_2_\d+_x86_64\.whl$", wheel.name), wheel.name
    assert wheel.stat().st_size < 100e6  # accepted by a package index
    names = zipfile.ZipFile(wheel).namelist()
    assert "palpate/bin/palpate" in names and any(name.startswith("palpate.libs/libvtk") for name in names)
    metadata = zipfile.ZipFile(wheel).read(next(name for name in names if name.endswith("/METADATA"))).decode()
    assert re.findall(r"(?m)^License.*$", metadata) == ["License-Expression: Apache-2.0", "License-File: LICENSE"]


def foreign_libraries(site):
    """Libraries that command and module need but are neither in the wheel nor on every Linux."""
    # Libraries that manylinux assumes: https://peps.python.org/pep-0600/
    allowed = r"linux-vdso|ld-linux|lib(c|m|dl|rt|pthread|gcc_s|stdc\+\+|z|expat)\.so"
    return [line for file in [site / "palpate/bin/palpate", *site.glob("palpate/_core*.so")] for line in run("ldd", file).splitlines()
            if str(site) not in line and not re.match(rf"\s*(/\S*/)?({allowed})", line)]


def test_its_libraries_are_its_own_or_every_linux_has_them(venv):
    site, = venv.glob("lib/python3*/site-packages")
    assert foreign_libraries(site) == []


def test_from_pip_to_a_picture(venv, tmp_path):
    """The command: a mesh, a scene of it, a run with frames and a picture, the page of the viewer."""
    palpate = venv / "bin/palpate"
    environment = {"PATH": f"{venv}/bin:/usr/bin:/bin", "HOME": str(tmp_path)}
    run(palpate, "generate", "ball", "--radius", "40", "--resolution", "3", cwd=tmp_path, env=environment)
    run(palpate, "new", "ball.vtu", cwd=tmp_path, env=environment)
    said = run(palpate, "run", "ball.json", "--set", "duration=0.2", cwd=tmp_path, env=environment)
    assert "picture       results/ball/picture.png" in said
    assert (tmp_path / "results/ball/picture.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "results/ball/frames.pvd").exists()
    assert run(palpate, "--version") == run(venv / "bin/python", "-m", "palpate", "--version")
    server = subprocess.Popen([palpate, "view", "ball.json", "--no-browser", "--json"], cwd=tmp_path, env=environment,
                              stdout=subprocess.PIPE, text=True)
    try:
        assert '"address":"http://127.0.0.1:' in server.stdout.readline()
    finally:
        server.terminate()
        assert server.wait(30) == 0


def test_the_package_works_and_has_the_bits_of_the_command(venv, command, root, tmp_path):
    code = ("import palpate, sys; s = palpate.Simulation(sys.argv[1]); s.run(3); print(s.state_hash)")
    scene = root / "scenes/ball-on-plate.json"
    hash_ = run(venv / "bin/python", "-I", "-c", code, scene, cwd=tmp_path).strip()
    assert f'"state_hash": "{hash_}"' in run(command, "run", scene, "--steps", "3", "--json", "--no-picture", cwd=tmp_path)
    output = run(venv / "bin/python", root / "examples/detect.py", cwd=tmp_path, env={"PATH": "/nowhere"})
    assert "contacts, the deepest" in output


@pytest.fixture(scope="module")
def arm(root, tmp_path_factory):
    """The wheel for 64-bit Arm and NumPy in a folder, and how to run a program of Arm there: on a Debian with Python and nothing else, in qemu."""
    run(root / "dev", "wheel", "--python", "/usr/bin/python3", "--arch", "aarch64", env=os.environ)
    found, = (root / "dist").glob("palpate-*-cp311-*_aarch64.whl")
    assert re.search(r"-manylinux_2_\d+_aarch64\.whl$", found.name), found.name
    bare = root / "build/aarch64/bare"
    run("python3", root / "python/tools/sysroot.py", "arm64", bare, "python3", "libstdc++6", env=os.environ)
    site = tmp_path_factory.mktemp("arm")
    run(root / "build/wheel-python-3.11/bin/python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--target", site, "--platform", "manylinux_2_36_aarch64",
        "--platform", "manylinux_2_35_aarch64", "--platform", "manylinux_2_28_aarch64", "--platform", "manylinux_2_27_aarch64", "--platform", "manylinux2014_aarch64", "--only-binary", ":all:",
        "--python-version", "3.11", found, env=os.environ)

    def emulate(program, *arguments, **options):
        environment = {"PATH": "/usr/bin:/bin", "HOME": "/nonexistent", "PYTHONPATH": str(site)}
        return run("qemu-aarch64-static", "-L", bare, program, *arguments, env=environment, **options)

    return site, bare, emulate


def test_the_wheel_of_arm_runs(arm, venv, root, tmp_path):
    """Package and command end in one state; positions equal those here up to rounding. No picture: minutes in qemu."""
    site, bare, emulate = arm
    scene = root / "scenes/ball-on-plate.json"
    code = "import palpate, sys; s = palpate.Simulation(sys.argv[1]); s.run(3); print(s.state_hash, *s.positions.ravel())"
    hash_, *there = emulate(bare / "usr/bin/python3.11", "-I", "-c", f"import sys; sys.path.insert(0, {str(site)!r}); {code}", scene, cwd=tmp_path).split()
    here = run(venv / "bin/python", "-I", "-c", code, scene, cwd=tmp_path).split()[1:]
    assert [float(x) for x in there] == pytest.approx([float(x) for x in here], abs=1e-9)
    emulate(site / "palpate/bin/palpate", "run", scene, "--steps", "3", "--no-picture", "--out", tmp_path / "arm", cwd=tmp_path)
    assert f'"state_hash": "{hash_}"' in (tmp_path / "arm/run.json").read_text()
