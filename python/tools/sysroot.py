#!/usr/bin/env python3
"""Unpacks packages of Debian for another architecture, and all that they need, into a folder: sysroot.py ARCHITECTURE FOLDER PACKAGE...

Nothing is installed, root is not needed, and the apt of this machine is not changed: lists and packages are in
FOLDER.apt. A folder with exactly these packages is left as it is. Scripts of packages do not run: what alternatives
would link is absent.
"""

import os
import pathlib
import shutil
import subprocess
import sys


def call(*arguments):
    done = subprocess.run([str(argument) for argument in arguments], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"sysroot.py: {arguments[0]} failed:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")


def fetch(architecture, folder, packages):
    """The .deb files of the packages and of what they depend on."""
    for part in ("state/lists/partial", "cache/archives/partial"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    status = folder / "state/status"  # nothing is installed
    status.write_text("")
    apt = ["apt-get", "-y", "-o", f"APT::Architecture={architecture}", "-o", f"APT::Architectures={architecture}", "-o", f"Dir::State={folder / 'state'}",
           "-o", f"Dir::State::status={status}", "-o", f"Dir::Cache={folder / 'cache'}", "-o", "APT::Sandbox::User=root", "-o", "Acquire::Retries=3"]
    call(*apt, "update")
    call(*apt, "install", "--no-install-recommends", "--download-only", *packages)
    return sorted((folder / "cache/archives").glob("*.deb"))


def make_links_relative(root):
    """Makes links relative: in packages they are absolute paths in the target system."""
    for folder, folders, files in os.walk(root):
        for name in folders + files:
            place = os.path.join(folder, name)
            if os.path.islink(place) and os.readlink(place).startswith("/"):
                target = os.path.relpath(str(root) + os.readlink(place), folder)
                os.unlink(place)
                os.symlink(target, place)


def main(arguments):
    if len(arguments) < 3:
        raise SystemExit(__doc__)
    architecture, folder, packages = arguments[0], pathlib.Path(arguments[1]).resolve(), sorted(arguments[2:])
    stamp = folder / "packages"
    wanted = "\n".join([architecture, *packages]) + "\n"
    if stamp.exists() and stamp.read_text() == wanted:
        return
    beside = folder.with_name(folder.name + ".new")
    shutil.rmtree(beside, ignore_errors=True)
    beside.mkdir(parents=True)
    for file in fetch(architecture, folder.with_name(folder.name + ".apt"), packages):
        call("dpkg-deb", "-x", file, beside)
    make_links_relative(beside)
    (beside / "packages").write_text(wanted)
    shutil.rmtree(folder, ignore_errors=True)
    beside.rename(folder)


if __name__ == "__main__":
    main(sys.argv[1:])
