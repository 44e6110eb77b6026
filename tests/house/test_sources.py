"""Rules for src/ and include/: nothing there prints or ends the process, folders depend one way, threads have one home."""

import os
import pathlib
import re
import unittest

ROOT = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"])
# In the order data flows; a folder may include only itself and those before it. What is not listed is not library.
LIBRARY_FOLDERS = ["parallel", "simd", "geometry", "mesh", "sort", "grid", "contact", "fem", "sim"]
PRINTS_OR_ENDS = re.compile(
    r"\b(?:std\s*::\s*)?(cout|cerr|clog)\b"
    r"|\b(print|println|printf|fprintf|vprintf|vfprintf|puts|fputs|putchar|perror|exit|_exit|_Exit|quick_exit|abort"
    r"|terminate)\s*\("
    r"|#\s*include\s*<(iostream|print|spdlog/[^>]*)>"
)


def without_comments_and_strings(text):
    """Blanks comments and literals, keeping line numbers."""
    token = re.compile(r'R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|//[^\n]*|/\*.*?\*/', re.DOTALL)
    # A quote between digits is a separator, not the start of a literal.
    text = re.sub(r"(?<=[0-9a-fA-F])'(?=[0-9a-fA-F])", "", text)
    return token.sub(lambda match: '""' + "\n" * match.group(0).count("\n"), text)


def offences(text, pattern):
    lines = without_comments_and_strings(text).splitlines()
    return [f"{number}: {line.strip()}" for number, line in enumerate(lines, 1) if pattern.search(line)]


def sources(*folders):
    files = [file for folder in folders for file in sorted((ROOT / folder).rglob("*.[hc]pp"))]
    assert files, f"no sources in {folders}"
    return files


class Sources(unittest.TestCase):
    def test_the_search_sees_what_it_must(self):
        for bad in ["std::cout << 1;", "cerr << x;", "printf(\"a\");", "std::exit(1);", "abort ();", "#include <iostream>",
                    "fmt::print(\"{}\", 1);", "/* fine */ std::terminate();"]:
            self.assertTrue(offences(bad, PRINTS_OR_ENDS), bad)
        for good in ["// std::cout << 1;", "auto s = \"exit(1)\";", "std::snprintf(b, 9, \"%d\", 1);", "border_exit(x);",
                     "/* abort()\n abort() */", "const int n = 1'000'000; // printf()", "on_exit_face(t);"]:
            self.assertFalse(offences(good, PRINTS_OR_ENDS), good)

    def test_nothing_in_the_library_prints_or_ends_the_process(self):
        for file in sources("src", "include"):
            with self.subTest(file=str(file.relative_to(ROOT))):
                self.assertEqual(offences(file.read_text(), PRINTS_OR_ENDS), [])

    def test_folders_depend_one_way(self):
        for place, folder in enumerate(LIBRARY_FOLDERS):
            for file in sorted((ROOT / "src" / folder).rglob("*.[hc]pp")):
                used = re.findall(r'^#include "([a-z_]+)/', file.read_text(), re.MULTILINE)
                with self.subTest(file=str(file.relative_to(ROOT))):
                    self.assertLessEqual(set(used), set(LIBRARY_FOLDERS[: place + 1]))

    def test_threads_live_in_parallel_only(self):
        threads = re.compile(r"#\s*pragma\s+omp|#\s*include\s*<(omp\.h|execution|tbb/[^>]*)>|std::(j?thread|async)\b(?!::)")
        # The viewer runs a simulation beside its server: no result is computed by that thread alone or another.
        homes = [ROOT / "src" / "parallel", ROOT / "src" / "view"]
        for file in sources("src", "include"):
            if file.parent not in homes:
                with self.subTest(file=str(file.relative_to(ROOT))):
                    self.assertEqual(offences(file.read_text(), threads), [])

    def test_what_changes_the_state_takes_no_inexact_function_of_the_c_library(self):
        inexact = re.compile(
            r"\bstd\s*::\s*(a?(?:sin|cos|tan)h?|atan2|exp2?|expm1|log|log2|log10|log1p|pow|cbrt|hypot|erfc?|[tl]gamma)[fl]?\s*\("
        )
        for bad in ["std::sin(x)", "std::acos (x)", "std::hypot(x, y)", "std::pow(x, 2)", "std::atan2(y, x)"]:
            self.assertTrue(offences(bad, inexact), bad)
        for good in ["std::sqrt(x)", "sine(x)", "std::fmod(x, y)", "std::log_of(x)", "std::expected(x)"]:
            self.assertFalse(offences(good, inexact), good)
        reports_only = [ROOT / "src" / "mesh" / "statistics.cpp"]  # dihedral angles
        folders = [f"src/{folder}" for folder in [*LIBRARY_FOLDERS, "scene"]]
        for file in sources(*folders, "include"):
            if file not in reports_only:
                with self.subTest(file=str(file.relative_to(ROOT))):
                    self.assertEqual(offences(file.read_text(), inexact), [])


if __name__ == "__main__":
    unittest.main()
