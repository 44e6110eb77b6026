"""The figures of README and docs are those of bench/results, and no figure is typed by hand."""

import copy
import os
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"])
# A number with a unit of time or memory, or with a factor.
MEASURED = re.compile(r"\d[\d.,]*\s?(?:ms|µs|ns|GB|MB|×|times as (?:fast|long))(?![\w])")


def typed(page):
    """The page without generated parts, code, and names of files."""
    text = re.sub(r"<!-- (\w[\w ]*): begin -->.*?<!-- \1: end -->", "", page, flags=re.DOTALL)
    return re.sub(r"```.*?```|`[^`]*`", "", text, flags=re.DOTALL)


class Figures(unittest.TestCase):
    def test_pages_say_what_the_reports_say(self):
        done = subprocess.run([sys.executable, ROOT / "bench/report/docs.py", ROOT, "--check"], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_a_quick_report_without_large_scenes_leaves_the_readme_to_the_one_before(self):
        sys.path.insert(0, str(ROOT / "bench/report"))
        import docs

        file, report = docs.reports_of(ROOT / "bench/results")[0]
        quick = copy.deepcopy(report)
        for section in quick["sections"]:
            section["table"]["rows"] = [row for row in section["table"]["rows"] if row[0] != "stacking 1000000"]
        self.assertEqual(docs.figures([(pathlib.Path("quick.json"), quick), (file, report)]), docs.figures([(file, report)]))
        with self.assertRaisesRegex(SystemExit, "a million tets"):
            docs.figures([(pathlib.Path("quick.json"), quick)])

    def test_no_measured_number_is_typed(self):
        for name in ["README.md", "docs/paper-map.md"]:
            with self.subTest(page=name):
                self.assertEqual(MEASURED.findall(typed((ROOT / name).read_text())), [])

    def test_the_search_sees_what_it_must(self):
        for bad in ["takes 3 ms", "1.5 ms,", "12× faster", "0.1 ms of", "3 times as fast"]:
            self.assertTrue(MEASURED.search(typed(bad)), bad)
        for good in ["`3 ms`", "<!-- a b: begin -->3 ms<!-- a b: end -->", "20 membranes", "3 msh files"]:
            self.assertFalse(MEASURED.search(typed(good)), good)


if __name__ == "__main__":
    unittest.main()
