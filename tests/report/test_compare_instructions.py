"""bench/report/compare_instructions.py and the table of speed, on invented counts."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"])
sys.path.insert(0, str(ROOT / "bench"))
import speed_table


def counts(compiler="GNU 12.2.0", **per_unit):
    return {"kind": "speed", "part": "instructions", "date": "2026-01-01T00:00:00Z",
            "machine": {"cpu": "Abacus", "cores": 2, "compiler": compiler, "build_type": "Release", "commit": "0" * 40},
            "cases": [{"name": name, "unit": "tet", "frames": 4, "units": 100, "instructions": 100 * value, "per_unit": value}
                      for name, value in per_unit.items()]}


class CompareInstructions(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def compare(self, old, new):
        for name, content in (("old.json", old), ("new.json", new)):
            (self.folder / name).write_text(content if isinstance(content, str) else json.dumps(content))
        return subprocess.run([sys.executable, ROOT / "bench/report/compare_instructions.py", self.folder / "old.json", self.folder / "new.json"],
                              capture_output=True, text=True, check=False)

    def test_the_same_counts_are_fine(self):
        done = self.compare(counts(query=250.0, depth=9000.0), counts(query=250.0, depth=9000.0))
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("2 compared: 0 dearer, 0 cheaper", done.stdout)

    def test_two_percent_is_the_bound(self):
        done = self.compare(counts(query=1000.0, depth=1000.0), counts(query=1019.0, depth=981.0))
        self.assertEqual(done.returncode, 0)
        done = self.compare(counts(query=1000.0, depth=1000.0), counts(query=1021.0, depth=500.0))
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stdout, r"(?m)^ 1\.021 .* dearer +query$")
        self.assertRegex(done.stdout, r"(?m)^ 0\.500 .* cheaper +depth$")
        self.assertIn("2 compared: 1 dearer, 1 cheaper", done.stdout)

    def test_a_kernel_that_is_gone_fails_and_a_new_one_does_not(self):
        done = self.compare(counts(query=1.0, depth=1.0), counts(query=1.0))
        self.assertEqual(done.returncode, 1)
        self.assertIn("no longer counted: depth", done.stdout)
        done = self.compare(counts(query=1.0), counts(query=1.0, depth=1.0))
        self.assertEqual(done.returncode, 0)
        self.assertRegex(done.stdout, r"(?m)^ +new .*: depth$")

    def test_another_compiler_is_told(self):
        done = self.compare(counts(query=1.0), counts(compiler="Clang 16.0.6", query=1.0))
        self.assertIn("note: compiler: GNU 12.2.0 before, Clang 16.0.6 now", done.stdout)

    def test_what_is_no_count_is_2(self):
        for bad in ["{", "[]", "{}", '{"cases": [1], "machine": {"compiler": ""}, "date": ""}']:
            with self.subTest(bad=bad):
                done = self.compare(bad, counts(query=1.0))
                self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1))
                self.assertIn("old.json", done.stderr)

    def test_the_kept_counts_are_counts(self):
        kept = (ROOT / "bench/results/instructions.json").read_text()
        self.assertEqual(self.compare(kept, kept).returncode, 0)


class SpeedTable(unittest.TestCase):
    def test_goals_and_verdicts_are_those_of_the_rows(self):
        row = {"table": "detection", "work": "contacts", "ours": 0.5, "other": 15.0, "unit": "ms", "other_side": "Embree", "ratio": 30.0,
               "ratio_unit": "×", "must": 27.0, "aim": 40.0, "at_most": False, "verdict": "met"}
        missed = row | {"work": "whole", "ratio": 3.0, "must": 2.5, "aim": 1.6, "at_most": True, "verdict": "missed"}
        share = row | {"work": "share", "ratio": 75.0, "ratio_unit": "%", "must": 70.0, "aim": 85.0}
        references = {"memcpy_GB_per_s": 20.0, "sort_ms": 70.0, "multiply_add_ms": 30.0}
        text = speed_table.table([counts() | {"part": "query", "load": 1.0, "references": references, "table": [row, missed, share]}])
        self.assertIn("| contacts | 0.5 ms | 15 ms | Embree | 30× | ≥ 27× | ≥ 40× | met |", text)
        self.assertIn("| whole | 0.5 ms | 15 ms | Embree | 3× | ≤ 2.5× | ≤ 1.6× | **missed** |", text)
        self.assertIn("| 75 % | ≥ 70 % | ≥ 85 % |", text)
        self.assertIn("| 1.0 | 20.0 | 70 | 30 |", text)
        self.assertNotIn("Dynamics", text)


if __name__ == "__main__":
    unittest.main()
