#!/usr/bin/env python3
"""Prints the sources that clang-tidy must read again, as regular expressions, one a line: those that changed in the
last commits or in the working tree, or include a source that did (as CMake's joint ones do); and for each header that
changed, at least one source that includes it. Nothing if there are none. All of them if git does not know that many
commits, or if .clang-tidy changed.

    changed_sources.py ROOT BUILD PATTERN

ROOT is the project, BUILD a folder that ninja has built, PATTERN a regular expression for the sources."""

import json
import pathlib
import re
import subprocess
import sys

COMMITS = 30  # more than ever land together, so that each source was read after its last change


def changed_since(root):
    """Paths relative to the project, or None if there are fewer commits."""
    git = ["git", "-C", root]
    old = subprocess.run([*git, "diff", "--name-only", f"HEAD~{COMMITS}"], capture_output=True, text=True)
    new = subprocess.run([*git, "ls-files", "--others", "--exclude-standard"], capture_output=True, text=True)
    return set((old.stdout + new.stdout).split("\n")) - {""} if old.returncode == 0 else None


def dependencies(build):
    """For each object, the files that its compiler read."""
    text = subprocess.run(["ninja", "-C", build, "-t", "deps"], capture_output=True, text=True, check=True).stdout
    files = {}
    for block in text.split("\n\n"):
        first, _, rest = block.strip().partition("\n")
        files[first.split(": #deps")[0]] = {str((build / line.strip()).resolve()) for line in rest.split("\n") if line}
    return files


def to_read(sources, read, changed):
    """Those sources of a dictionary, from file to object, that must be read again. Each object reads files."""
    chosen = {file for file, output in sources.items()
              if output not in read or any(path.endswith(".cpp") for path in read[output] & changed)}
    rest = {file: read[output] & changed for file, output in sorted(sources.items()) if file not in chosen}
    headers = set().union(*rest.values()).difference(*(read.get(sources[file], ()) for file in chosen))
    while headers:
        most = max(rest, key=lambda file: len(rest[file] & headers))
        chosen.add(most)
        headers -= rest[most]
    return chosen


def main(root, build, pattern):
    root, build = pathlib.Path(root).resolve(), pathlib.Path(build).resolve()
    commands = json.loads((build / "compile_commands.json").read_text())
    sources = {c["file"]: c["command"].split(" -o ")[1].split()[0] for c in commands if re.match(pattern, c["file"])}
    changed = changed_since(root)
    if changed is not None and ".clang-tidy" not in changed:
        changed = {str(root / path) for path in changed}
        sources = to_read(sources, dependencies(build), changed)
    for file in sorted(sources):
        print(f"^{re.escape(file)}$")


if __name__ == "__main__":
    main(*sys.argv[1:])
