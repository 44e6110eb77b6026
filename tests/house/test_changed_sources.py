"""changed_sources.py: which sources clang-tidy reads again. A project of three sources, of which two include a header."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"])
sys.path.insert(0, str(ROOT / "tests" / "house"))
from changed_sources import COMMITS  # noqa: E402


class ChangedSources(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="palpate changed ")
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name).resolve()
        self.build = self.root / "build"
        self.build.mkdir()
        for name in ["a.cpp", "b.cpp", "b.hpp", "c.cpp", "c.hpp"]:
            (self.root / name).write_text("int x;\n")
        (self.root / ".gitignore").write_text("build\nbin\n")
        commands = [{"file": str(self.root / f"{n}.cpp"), "command": f"c++ -o {n}.o -c {n}.cpp"} for n in "abc"]
        (self.build / "compile_commands.json").write_text(json.dumps(commands))
        ninja = self.root / "bin" / "ninja"
        ninja.parent.mkdir()
        ninja.write_text("#!/bin/sh\nprintf 'a.o: #deps 1, (VALID)\\n    ../a.cpp\\n\\n"
                         "b.o: #deps 2, (VALID)\\n    ../b.cpp\\n    ../b.hpp\\n\\n"
                         "c.o: #deps 3, (VALID)\\n    ../c.cpp\\n    ../b.hpp\\n    ../c.hpp\\n\\n'\n")
        ninja.chmod(0o755)
        self.git("init", "-q")
        self.git("add", ".")
        self.commit(1)

    def git(self, *arguments):
        subprocess.run(["git", "-c", "user.name=x", "-c", "user.email=x@x", *arguments], cwd=self.root, check=True)

    def commit(self, times):
        for _ in range(times):
            self.git("commit", "-q", "--allow-empty", "-m", "x")

    def found(self):
        path = f"{self.root / 'bin'}:{os.environ['PATH']}"
        text = subprocess.run([sys.executable, ROOT / "tests" / "house" / "changed_sources.py", self.root, self.build, ".*"],
                              env=dict(os.environ, PATH=path), capture_output=True, text=True, check=True).stdout
        return [line.replace("\\", "").strip("^$").removeprefix(f"{self.root}/") for line in text.splitlines()]

    def test_all_of_a_young_project(self):
        self.assertEqual(self.found(), ["a.cpp", "b.cpp", "c.cpp"])

    def test_nothing_after_many_commits_of_other_files(self):
        self.commit(COMMITS)
        self.assertEqual(self.found(), [])

    def test_what_changed_and_one_that_includes_each_header(self):
        self.commit(COMMITS)
        (self.root / "a.cpp").write_text("int y;\n")
        self.assertEqual(self.found(), ["a.cpp"])
        (self.root / "b.hpp").write_text("int y;\n")
        self.assertEqual(self.found(), ["a.cpp", "b.cpp"])
        (self.root / "c.hpp").write_text("int y;\n")
        self.assertEqual(self.found(), ["a.cpp", "c.cpp"])
        (self.root / "b.cpp").write_text("int y;\n")
        (self.root / "c.hpp").write_text("int x;\n")
        self.assertEqual(self.found(), ["a.cpp", "b.cpp"])

    def test_all_where_the_checks_changed(self):
        self.commit(COMMITS)
        (self.root / ".clang-tidy").write_text("Checks: '*'\n")
        self.assertEqual(self.found(), ["a.cpp", "b.cpp", "c.cpp"])


if __name__ == "__main__":
    unittest.main()
