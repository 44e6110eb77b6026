"""Builds and tests a conda recipe by rattler-build where conda-forge cannot be reached, with packages of its names that are filled from this Debian.

Usage: conda_channel.py RECIPE FOLDER SITE NUMPY_SITE; called by the Python that makes wheels, with patchelf in PATH. SITE and NUMPY_SITE are
the site-packages that have the build's tools and NumPy. Prints what the tests said, and the package. Compilers, libraries and headers are Debian's: their packages
here are empty, with the versions that Debian has. So the solver, the script of the recipe, the content of the package and its tests are real.
Whether it compiles with the libraries of conda-forge is not tested.
"""

import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

import rattler_build as conda

SUBDIR = "linux-64"
SYSROOT = "2.28"
SYSTEM = "/usr/bin/python3.11"
# Name in conda-forge, and the Debian package used instead.
DEBIAN = {"gxx_linux-64": "g++", "cmake": "cmake", "ninja": "ninja-build", "libhwy": "libhwy-dev", "libboost-headers": "libboost-dev",
          "nlohmann_json": "nlohmann-json3-dev", "fmt": "libfmt-dev", "spdlog": "libspdlog-dev", "cli11": "libcli11-dev", "zlib": "zlib1g-dev",
          "vtk-base": "libvtk9-dev", "embree": "libembree-dev"}
# Name in conda-forge, and its parts of site-packages.
MODULES = {"pip": ["pip", "setuptools", "pkg_resources"], "scikit-build-core": ["scikit_build_core", "packaging", "pathspec"], "nanobind": ["nanobind"]}


def answer_of(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def debian_version(package):
    return re.match(r"(?:\d+:)?(\d[0-9.]*\d)", answer_of("dpkg-query", "-W", "-f", "${Version}", package))[1]


def installed_version(site, module):
    info, = site.glob(f"{module}-*.dist-info")
    return info.name.removesuffix(".dist-info").split("-")[1]


class Channel:
    """Packages in a folder, with the list that a solver reads."""

    def __init__(self, folder):
        self.folder = folder
        self.packages = {}
        for name in (SUBDIR, "noarch"):
            (folder / name).mkdir(parents=True)

    def add(self, name, version, files=None, depends=()):
        made = conda.assemble_package(name, version, SUBDIR, "0", self.folder / SUBDIR, files_dir=files, depends=list(depends), compression_level=1)
        content = pathlib.Path(made.path).read_bytes()
        self.packages[pathlib.Path(made.path).name] = {
            "name": name, "version": version, "build": "0", "build_number": 0, "depends": list(depends), "subdir": SUBDIR, "size": len(content),
            "sha256": hashlib.sha256(content).hexdigest()}

    def write_list(self):
        for name, packages in [(SUBDIR, self.packages), ("noarch", {})]:
            text = {"info": {"subdir": name}, "packages": {}, "packages.conda": packages, "repodata_version": 1}
            (self.folder / name / "repodata.json").write_text(json.dumps(text))


def python_files(folder):
    """A virtual environment of the system's Python in the prefix, as conda's Python is."""
    (folder / "bin").mkdir(parents=True)
    (folder / "bin/python3.11").symlink_to(SYSTEM)
    for name in ("python", "python3"):
        (folder / "bin" / name).symlink_to("python3.11")
    (folder / "pyvenv.cfg").write_text("home = /usr/bin\ninclude-system-site-packages = false\n")
    return folder


def node_files(folder):
    (folder / "bin").mkdir(parents=True)
    for name in ("node", "npm"):
        (folder / "bin" / name).symlink_to(pathlib.Path(shutil.which(name)).resolve())
    return folder


def module_files(folder, site, names):
    place = folder / "lib/python3.11/site-packages"
    place.mkdir(parents=True)
    for name in names:
        found = [one for one in site.iterdir() if one.name in (name, f"{name}.libs") or one.name.startswith(f"{name}-")]
        if not found:
            raise SystemExit(f"{site}: found no {name}")
        for one in found:
            shutil.copytree(one, place / one.name, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


def compiler_files(folder):
    """What an environment with a compiler begins with: the compiler; how this machine reaches npm's registry; and ccache as ./dev has it, with
    what ccache takes for part of a call: the compiler's name, its flags and the language."""
    lines = ["export CXX=/usr/bin/c++"]
    if shutil.which("ccache"):
        cache = answer_of("ccache", "--get-config", "cache_dir")
        lines += [f"export CCACHE_DIR={cache} CCACHE_BASEDIR=$SRC_DIR CCACHE_NOHASHDIR=1 CMAKE_CXX_COMPILER_LAUNCHER=ccache",
                  "export SKBUILD_CMAKE_DEFINE=PALPATE_WERROR=ON", "unset LC_ALL"]
    lines += [f"export {name}={value}" for name, value in os.environ.items() if name == "NODE_EXTRA_CA_CERTS"]
    (folder / "etc/conda/activate.d").mkdir(parents=True)
    (folder / "etc/conda/activate.d/cxx.sh").write_text("\n".join(lines) + "\n")
    return folder


def make_channel(folder, site, numpy_site):
    channel, stage = Channel(folder / "channel"), folder / "files"
    for name, package in DEBIAN.items():
        channel.add(name, debian_version(package), compiler_files(stage / name) if name.startswith("gxx") else None)
    channel.add("sysroot_linux-64", SYSROOT)
    channel.add("nodejs", answer_of("node", "--version").lstrip("v"), node_files(stage / "nodejs"))
    channel.add("python", answer_of(SYSTEM, "-c", "import platform; print(platform.python_version())"), python_files(stage / "python"))
    for name, modules in MODULES.items():
        channel.add(name, installed_version(site, modules[0]), module_files(stage / name, site, modules), ["python"])
    channel.add("numpy", installed_version(numpy_site, "numpy"), module_files(stage / "numpy", numpy_site, ["numpy"]), ["python"])
    channel.write_list()
    return channel.folder


def main(recipe, folder, site, numpy_site):
    channel = make_channel(folder, site, numpy_site)
    variants = conda.VariantConfig({"c_stdlib": ["sysroot"], "c_stdlib_version": [SYSROOT]})
    try:
        built, = conda.Stage0Recipe.from_file(recipe).run_build(variants, conda.ToolConfiguration(test_strategy="native"), folder / "out",
                                                                [channel.as_uri()])
    except conda.RattlerBuildError as error:
        logs = "\n".join(log.read_text()[-4000:] for log in (folder / "out").glob("bld/*/work/conda_build.log"))
        raise SystemExit(f"{logs}\n{error}")
    print(*built.log, *built.packages, sep="\n")


if __name__ == "__main__":
    main(*(pathlib.Path(argument).resolve() for argument in sys.argv[1:]))
