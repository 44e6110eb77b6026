"""bench/report/compare.py on invented reports with known ratios; and how reports are joined and stored."""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from made_up import measure, report, section

ROOT = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"])


class Compare(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write(self, name, content):
        (self.folder / name).write_text(content if isinstance(content, str) else json.dumps(content))
        return self.folder / name

    def call(self, script, *arguments):
        return subprocess.run([sys.executable, ROOT / "bench/report" / script, *map(str, arguments)], capture_output=True, text=True, check=False)

    def compare(self, old, new):
        return self.call("compare.py", self.write("old.json", old), self.write("new.json", new))

    def row(self, text, name):
        """(ratio, low, high, verdict) of a line of the output."""
        found = re.search(rf"^\s*([\d.]+)\s+\[\s*([\d.]+),\s*([\d.]+)\]\s+(\S+)\s+.*: {re.escape(name)}$", text, re.MULTILINE)
        self.assertIsNotNone(found, f"{name} in {text}")
        return *(float(found[i]) for i in (1, 2, 3)), found[4]

    def test_a_report_is_as_fast_as_itself(self):
        one = report(section("a", [measure("query", 5.0), measure("std::sort", 7.0, reference=True)]))
        done = self.compare(one, one)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(self.row(done.stdout, "query")[0], 1.0)
        self.assertEqual(self.row(done.stdout, "query")[3], "-")

    def test_known_ratios_and_their_bounds(self):
        old = report(section("a", [measure("slow", 10.0), measure("fast", 10.0), measure("noisy", 10.0, 0.3)]))
        new = report(section("a", [measure("slow", 15.0), measure("fast", 8.0), measure("noisy", 12.0, 0.3)]))
        done = self.compare(old, new)
        self.assertEqual(done.returncode, 1, "something is slower")
        ratio, low, high, verdict = self.row(done.stdout, "slow")
        self.assertAlmostEqual(ratio, 1.5, 3)
        self.assertAlmostEqual(low, 15.0 * 0.98 / (10.0 * 1.02), 3)
        self.assertAlmostEqual(high, 15.0 * 1.02 / (10.0 * 0.98), 3)
        self.assertEqual(verdict, "slower")
        self.assertEqual(self.row(done.stdout, "fast")[3], "faster")
        self.assertEqual(self.row(done.stdout, "noisy")[3], "-", "1.2 times as long, but samples spread by 30 %")
        self.assertIn("3 compared: 1 slower, 1 faster", done.stdout)

    def test_a_slower_machine_is_no_regression(self):
        def of(factor, ours):
            return report(section("a", [measure("ours", ours)] + [measure(f"peer {i}", i * factor, reference=True) for i in (1.0, 2.0, 3.0)]))
        done = self.compare(of(1.0, 10.0), of(2.0, 20.0))
        self.assertEqual(done.returncode, 0)
        self.assertAlmostEqual(self.row(done.stdout, "ours")[0], 1.0, 3)
        self.assertIn("took 2.000 times as long", done.stdout)
        self.assertNotRegex(done.stdout, r"(?m)a: peer", "work that is not ours is not judged")
        done = self.compare(of(1.0, 10.0), of(2.0, 30.0))
        self.assertEqual((done.returncode, self.row(done.stdout, "ours")[3]), (1, "slower"))

    def test_a_machine_that_wavers_widens_the_bounds(self):
        def of(factors, ours):
            return report(section("a", [measure("ours", ours)] + [measure(f"peer {i}", f, reference=True) for i, f in enumerate(factors)]))
        done = self.compare(of([1, 1, 1, 1], 10.0), of([0.7, 1.0, 1.0, 1.6], 11.5))
        self.assertEqual((done.returncode, self.row(done.stdout, "ours")[3]), (0, "-"))

    def test_other_results_are_told_and_fail(self):
        done = self.compare(report(section("a", [measure("x", 1.0)])), report(section("a", [measure("x", 1.0)], result_hash="01")))
        self.assertEqual(done.returncode, 1)
        self.assertIn("other results than before: a", done.stdout)

    def test_another_effort_or_machine_is_told(self):
        one = [measure("x", 1.0)]
        done = self.compare(report(section("a", one)), report(section("a", one, result_hash="01"), effort="full"))
        self.assertEqual(done.returncode, 0)
        self.assertIn("effort quick before, full now", done.stdout)

    def test_nothing_to_compare_is_2(self):
        for new in [report(), report(section("b", [measure("x", 1.0)])), report(section("a", [measure("y", 1.0)]))]:
            with self.subTest(new=new["sections"]):
                done = self.compare(report(section("a", [measure("x", 1.0)])), new)
                self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1))
                self.assertIn("found nothing that", done.stderr)

    def test_sections_that_are_missing_are_told(self):
        one = [measure("x", 1.0)]
        done = self.compare(report(section("a", one), section("b", []), section("c", one)), report(section("a", one)))
        self.assertEqual(done.returncode, 0)
        self.assertIn("not measured now: b, c\n", done.stdout)

    def test_times_of_zero_are_skipped(self):
        one = report(section("a", [measure("x", 1.0), measure("none", 0.0), measure("peer", 2.0, reference=True),
                                   measure("no peer", 0.0, reference=True)]))
        done = self.compare(one, one)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("1 times of work that is not ours", done.stdout)
        self.assertIn("1 compared", done.stdout)

    def test_what_is_no_report_is_2(self):
        good = report()
        no_facts = report() | {"machine": {"cpu": "Abacus"}}
        no_times = report(section("a", [{"name": "x", "reference": False}]))
        for bad in ["{", "[]", "{}", '{"sections": []}', '{"sections":[{}],"machine":{}}', no_facts, no_times, report({}), report(date=7)]:
            with self.subTest(bad=bad):
                done = self.compare(bad, good)
                self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
                self.assertIn("old.json", done.stderr)

    def test_what_was_not_measured_to_its_end_is_2(self):
        whole = self.write("whole.json", report(section("a", [measure("x", 1.0)]), complete=True))
        part = self.write("part.json", report(section("a", [measure("x", 1.0)]), complete=False))
        for script, arguments in [("compare.py", [whole, part]), ("compare.py", [part, whole]), ("merge.py", [self.folder / "all.json", whole, part]),
                                  ("keep.py", [part, self.folder])]:
            with self.subTest(script=script, arguments=arguments):
                done = self.call(script, *arguments)
                self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
                self.assertIn("part.json: found a report that was not measured to its end", done.stderr)
        self.assertEqual({file.name for file in self.folder.iterdir()}, {"whole.json", "part.json"})
        self.assertEqual(self.call("compare.py", whole, whole).returncode, 0)

    def test_what_is_no_file_is_2(self):
        self.assertEqual(self.call("compare.py", "nowhere.json", "nowhere.json").returncode, 2)

    def test_reports_are_put_together_only_if_they_are_of_one_build(self):
        a = self.write("a.json", report(section("a", [])))
        b = self.write("b.json", report(section("b", [])))
        other = self.write("other.json", report(section("c", []), effort="full", kind="peers"))
        elsewhere = report(section("d", []))
        elsewhere["machine"] = {**elsewhere["machine"], "commit": "another"}
        elsewhere = self.write("elsewhere.json", elsewhere)
        self.assertEqual(self.call("merge.py", self.folder / "all.json", a, b).returncode, 0)
        self.assertEqual([s["id"] for s in json.loads((self.folder / "all.json").read_text())["sections"]], ["a", "b"])
        self.assertEqual(self.call("merge.py", self.folder / "mixed.json", a, other).returncode, 0)
        self.assertEqual(json.loads((self.folder / "mixed.json").read_text())["effort"], "all quick, peers full")
        done = self.call("merge.py", self.folder / "none.json", a, elsewhere)
        self.assertEqual(done.returncode, 1)
        self.assertIn("machine", done.stderr)
        self.assertFalse((self.folder / "none.json").exists())

    def test_a_report_is_kept_under_its_date_and_machine(self):
        source = self.write("r.json", report())
        self.assertEqual(self.call("keep.py", source, self.folder).returncode, 0)
        self.assertEqual((self.folder / "2026-01-01-abacus-2-cores-quick.json").read_text(), source.read_text())


if __name__ == "__main__":
    unittest.main()
