"""What README.md and the docs show must be what is there: the library example, and every file they point to."""

import os
import pathlib
import re
import textwrap
import unittest

ROOT = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"])


def blocks(text, language):
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def stripped_lines(text):
    return [line.strip() for line in text.splitlines() if line.strip()]


class Readme(unittest.TestCase):
    def test_the_library_example_is_the_program_that_is_tested(self):
        """tests/package builds and runs examples/embed; the example is a run of consecutive lines of its sources."""
        readme = (ROOT / "README.md").read_text()
        for language, file in [("cpp", "main.cpp"), ("cmake", "CMakeLists.txt")]:
            program = "\n".join(stripped_lines((ROOT / "examples/embed" / file).read_text()))
            shown = blocks(readme, language)
            self.assertEqual(len(shown), 1, f"README.md shows one {language} block")
            self.assertIn("\n".join(stripped_lines(textwrap.dedent(shown[0]))), program)

    def test_links_lead_to_files(self):
        for page in [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")]:
            for target in re.findall(r"\]\(([^)#\s]+)\)", page.read_text()):
                if "://" not in target:
                    with self.subTest(page=page.name, target=target):
                        self.assertTrue((page.parent / target).exists())

    def test_the_paper_map_names_files_that_exist(self):
        page = (ROOT / "docs/paper-map.md").read_text()
        named = re.findall(r"`((?:src|include|tests|bench|scenes|examples|docs|apps)/[^`*]*)`", page)
        for name in named:
            with self.subTest(name=name):
                self.assertTrue((ROOT / name).exists())


if __name__ == "__main__":
    unittest.main()
