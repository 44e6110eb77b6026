"""What README.md and the docs show must be what is there: the library example, and the files of the paper map."""

import os
import pathlib
import re
import struct
import textwrap
import unittest

ROOT = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"])


def blocks(text, language):
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def stripped_lines(text):
    return [line.strip() for line in text.splitlines() if line.strip()]


class Readme(unittest.TestCase):
    def test_the_library_example_is_the_program_that_is_tested(self):
        """tests/package builds and runs these programs; what is shown are consecutive lines of their sources."""
        readme = (ROOT / "README.md").read_text()
        for language, files in [("cpp", ["examples/embed/main.cpp"]),
                                ("cmake", ["examples/embed/CMakeLists.txt", "tests/package/fetch/CMakeLists.txt"])]:
            shown = blocks(readme, language)
            self.assertEqual(len(shown), len(files), f"README.md shows {len(files)} {language} blocks")
            for block, file in zip(shown, files):
                program = "\n".join(stripped_lines((ROOT / file).read_text()))
                self.assertIn("\n".join(stripped_lines(textwrap.dedent(block))), program)

    def test_lines_are_no_wider_than_a_window(self):
        """Except rows of tables, code that is shown, and what has no space to break at."""
        widest = 120
        for page in [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]:
            shown = False
            for number, line in enumerate(page.read_text().splitlines(), 1):
                fence = line.lstrip().startswith("```")
                shown = shown != fence
                if shown or fence or line.lstrip().startswith("|") or " " not in line.strip():
                    continue
                with self.subTest(page=str(page.relative_to(ROOT)), line=number):
                    self.assertLessEqual(len(line), widest)

    def test_the_paper_map_names_files_that_exist(self):
        page = (ROOT / "docs/paper-map.md").read_text()
        named = re.findall(r"`((?:src|include|tests|bench|scenes|examples|docs|apps)/[^`*]*)`", page)
        for name in named:
            with self.subTest(name=name):
                self.assertTrue((ROOT / name).exists())


class Pictures(unittest.TestCase):
    def test_pictures_of_the_gallery_have_all_their_shades(self):
        """A palette of 256 colours shows bands, and its scale of a field is not the one of the page."""
        for file in (ROOT / "docs/gallery").glob("*.png"):
            head = file.read_bytes()[:29]
            width, height, bits, kind = struct.unpack(">IIBB", head[16:26])
            with self.subTest(picture=file.name):
                self.assertEqual((bits, kind), (8, 2), "8 bits of red, green and blue (RFC 2083, 4.1.1)")
                self.assertGreaterEqual(width, 960)
                self.assertLessEqual(file.stat().st_size, 800_000)


if __name__ == "__main__":
    unittest.main()
