"""The steps of the Dockerfile in a clean root of Debian 12, and then the command in it. Without docker; as root.

Usage: check_docker.py SOURCE_FOLDER WORK_FOLDER. Exit code 77 (skipped) where mmdebstrap or the rights are missing.
"""

import json
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import time

SKIPPED = 77
source, work = (pathlib.Path(argument).resolve() for argument in sys.argv[1:])
root = work / "root"


def skip(why):
    print(f"skipped: {why}")
    sys.exit(SKIPPED)


def instructions():
    """(instruction, rest) of each line of the Dockerfile."""
    for line in (source / "Dockerfile").read_text().splitlines():
        if line and not line.startswith("#"):
            name, _, rest = line.partition(" ")
            yield name, rest


def make_root():
    """Like the image debian:12-slim: the required packages of Debian, and apt."""
    if not (root / "usr/bin/apt-get").exists():
        shutil.rmtree(root, ignore_errors=True)
        subprocess.run(["mmdebstrap", "--variant=apt", "bookworm", root], check=True, stdin=subprocess.DEVNULL)
    for name in ("opt/palpate", "work"):  # of an earlier run
        shutil.rmtree(root / name, ignore_errors=True)
    shutil.copy("/etc/resolv.conf", root / "etc/resolv.conf")
    # Access to the package index depends on the machine.
    shutil.copy(os.environ.get("PIP_CERT", "/etc/ssl/certs/ca-certificates.crt"), root / "etc/machine.pem")


def in_root(command, environment, folder="/"):
    passed = {name: value for name, value in os.environ.items() if name.lower().endswith("_proxy") or name == "PIP_INDEX_URL"}
    passed["PIP_CERT"] = "/etc/machine.pem"
    # With /proc, as in a container, for the duration of the command.
    in_own_mounts = 'mount -t proc proc "$1/proc" && exec /usr/sbin/chroot "$1" sh -c "$2"'
    subprocess.run([shutil.which("unshare"), "-m", "sh", "-c", in_own_mounts, "sh", root, f"cd {folder} && {command}"],
                   check=True, stdin=subprocess.DEVNULL,
                   env={"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", **passed, **environment})


def main():
    if os.geteuid() != 0 or shutil.which("mmdebstrap") is None:
        skip("needs root and mmdebstrap")
    if not list(source.glob(f"dist/palpate-*-cp311-*_{platform.machine()}.whl")):
        raise SystemExit("there is no wheel in dist/: './dev wheel' makes it, as the test Wheel.made does")
    work.mkdir(parents=True, exist_ok=True)
    make_root()
    start = time.monotonic()
    environment, folder, entry = {}, "/", []
    for name, rest in instructions():
        if name == "RUN":
            in_root(rest, environment, folder)
        elif name == "COPY":
            pattern, place = rest.split()
            for file in source.glob(pattern):
                shutil.copy(file, root / place.lstrip("/"))
        elif name == "ENV":
            variable, _, value = rest.partition("=")
            environment[variable] = value
        elif name == "WORKDIR":
            folder = rest
            (root / rest.lstrip("/")).mkdir(exist_ok=True)
        elif name == "ENTRYPOINT":
            entry = json.loads(rest)
        elif name not in ("FROM", "CMD"):
            raise SystemExit(f"the test does not know {name}")
    installed = time.monotonic()
    command = " ".join(entry)
    in_root(f"{command} generate ball --radius 40 --resolution 3 --out ball.vtu && {command} new ball.vtu --out ball.json "
            f"&& {command} run ball.json --set duration=0.2 --replace && ls -l results/ball/picture.png "
            "&& python3 -I -c 'import palpate; print(palpate.__version__)'", environment, folder)
    done = time.monotonic()
    print(f"from apt-get to the command: {installed - start:.1f} s; from a mesh to a picture: {done - installed:.1f} s")


main()
