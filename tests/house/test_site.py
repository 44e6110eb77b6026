"""The site of the documentation, as far as it can be checked without building it: pages, links, headers, its own tools."""

import fnmatch
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"])
sys.path.insert(0, str(ROOT / "docs/site"))

import check_links  # noqa: E402
import cpp_reference  # noqa: E402
import pages  # noqa: E402


def all_pages():
    found = [*ROOT.glob("*.md"), *ROOT.glob("slicer/**/*.md"), *ROOT.glob("docs/**/*.md")]
    return pages.pages_of([pathlib.PurePosixPath(file.relative_to(ROOT)) for file in sorted(found)])


def front_page():
    return (ROOT / "docs/site/index.md").read_text()


def entries(text):
    """What the lists of the front page name, in order: /docs/scene, or Title </docs/scene>."""
    lists = re.findall(r"^```\{toctree\}\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    lines = [line for each in lists for line in each.splitlines() if line and not line.startswith(":")]
    return [re.sub(r"^.*<(.*)>$", r"\1", line) for line in lines]


def anchors(text):
    """The anchors of a page's headings, as GitHub makes them."""
    found, counts = set(), {}
    without_code = re.sub(r"(?ms)^( *)(```+|~~~+).*?^\1\2.*?$", "", text)
    for heading in re.findall(r"(?m)^#{1,6}\s+(.*?)\s*#*$", without_code):
        heading = re.sub(r"!?\[([^]]*)\]\([^)]*\)", r"\1", heading)
        slug = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        number = counts.get(slug, 0)
        counts[slug] = number + 1
        found.add(f"{slug}-{number}" if number else slug)
    return found


class Site(unittest.TestCase):
    def test_the_front_page_names_every_page_once(self):
        named = entries(front_page())
        self.assertGreater(len(named), 20)
        for page in all_pages():
            name = f"/{page.with_suffix('')}"
            with self.subTest(page=str(page)):
                self.assertEqual(len([each for each in named if fnmatch.fnmatchcase(name, each)]), 1)

    def test_the_front_page_names_nothing_else(self):
        known = {f"/{page.with_suffix('')}" for page in all_pages()}
        for name in entries(front_page()):
            with self.subTest(name=name):
                if name.startswith("/files/"):
                    self.assertTrue((ROOT / name.removeprefix("/files/")).is_file())
                else:
                    self.assertTrue(name in known or "*" in name or name.startswith("/reference/"))

    def test_links_lead_to_files_and_headings(self):
        for page in all_pages():
            text = (ROOT / page).read_text()
            for target, anchor in pages.links_of(text):
                if "://" in target or target.startswith("mailto:"):
                    continue
                file = (ROOT / page).parent / target if target else ROOT / page
                with self.subTest(page=str(page), target=target, anchor=anchor):
                    self.assertTrue(file.exists())
                    if anchor and file.suffix == ".md":
                        self.assertIn(anchor, anchors(file.read_text()))

    def test_the_anchors_are_those_of_github(self):
        text = "# A first: one\n## Points, *edges* & `tets`\n```\n# no heading\n```\n## [Link](x.md) 2\n## Two  \n## Two\n"
        self.assertEqual(anchors(text), {"a-first-one", "points-edges--tets", "link-2", "two", "two-1"})

    def test_comments_name_pages_that_are_there(self):
        sources = [*cpp_reference.public_headers(ROOT), *(ROOT / "python/palpate").glob("*.py")]
        self.assertGreater(len(sources), 20)
        for file in sources:
            for name in re.findall(r"\bdocs/[\w/-]+\.md\b", file.read_text()):
                with self.subTest(file=file.name, name=name):
                    self.assertTrue((ROOT / name).is_file())

    def test_the_notebook_runs_with_the_numpy_of_the_tests(self):
        def numpy(file):
            return re.search(r"(?m)^numpy==.*$", (ROOT / file).read_text())[0]
        self.assertEqual(numpy("docs/site/requirements.txt"), numpy("python/requirements.txt"))


class CppReference(unittest.TestCase):
    @unittest.skipUnless(shutil.which("doxygen"), "there is no doxygen: ./dev test installs it")
    def test_it_has_every_type_of_every_public_header(self):
        with tempfile.TemporaryDirectory(prefix="palpate docs ") as folder:
            output = pathlib.Path(folder)
            undocumented, warnings = cpp_reference.run_doxygen(ROOT, output)
            self.assertEqual(warnings, [])
            self.assertEqual(undocumented, [], "every public name needs a comment")
            written = {}

            class Made:
                """Takes pages as pages.Pages does."""

                def add(self, name, text):
                    written[pathlib.PurePosixPath(name).name] = text

            cpp_reference.add_reference(Made(), ROOT, output / "xml")
        for header in cpp_reference.public_headers(ROOT):
            types = re.findall(r"(?m)^(?:struct|class|enum class|enum) (\w+)[^;]*\{", header.read_text())
            aliases = re.findall(r"(?m)^using (\w+) =", header.read_text())
            for name in types + aliases:
                with self.subTest(header=header.name, name=name):
                    self.assertRegex(written[f"{header.name}.md"], rf"(?m)^```{{doxygen\w+}} palpate::{name}$")
                    self.assertIn(f"`{name} <palpate::{name}>`", written["index.md"])


class Tools(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="palpate docs ")
        self.addCleanup(folder.cleanup)
        self.home = pathlib.Path(folder.name)

    def write(self, name, text):
        file = self.home / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def test_links_to_files_become_links_to_pages_that_show_them(self):
        self.write("repository/README.md", "[a](docs/a.md#two) [s](scenes/s.json) ![p](docs/p.png) [f](scenes) [h](http://x.org)\n"
                                           "```cpp\n[s](scenes/s.json)\n```\n`[s](scenes/s.json)` [gone](gone.md)\n")
        self.write("repository/docs/a.md", "# A\n## Two\n[back](../README.md) [s](../scenes/s.json#L3)\n")
        self.write("repository/docs/p.png", "")
        self.write("repository/scenes/s.json", "{}\n")
        root = self.home / "repository"
        subprocess.run(["git", "init", "-q", root], check=True)
        made = pages.Pages(root, self.home / "out")
        for page in sorted(made.pages):
            made.add_page(page)
        self.assertEqual((self.home / "out/README.md").read_text(),
                         "[a](docs/a.md#two) [s](files/scenes/s.json.md) ![p](docs/p.png) [f](files/scenes.md) [h](http://x.org)\n"
                         "```cpp\n[s](scenes/s.json)\n```\n`[s](scenes/s.json)` [gone](gone.md)\n")
        self.assertEqual((self.home / "out/docs/a.md").read_text(),
                         "# A\n## Two\n[back](../README.md) [s](../files/scenes/s.json.md)\n")
        self.assertIn("literalinclude} s.json", (self.home / "out/files/scenes/s.json.md").read_text())
        self.assertIn("[s.json](scenes/s.json.md)", (self.home / "out/files/scenes.md").read_text())
        self.assertTrue((self.home / "out/docs/p.png").is_file())

    def test_broken_links_are_found(self):
        self.write("a.html", '<p id="one"><a href="b.html#two">b</a> <a href="#one">here</a> <a href="https://x.org/#y">x</a></p>')
        self.write("b.html", '<h1 id="two"></h1><img src="p.png"><a href="a.html#none">1</a><a href="c.html">2</a><a href="#zwei">3</a>'
                             '<script src="https://cdn.org/a.js"></script>')
        found, count, links = check_links.faults(self.home)
        self.assertEqual(found, ["b.html: loads 'https://cdn.org/a.js' from the network",
                                 "b.html: 'p.png' leads to no file", "b.html: 'a.html#none' leads to no anchor",
                                 "b.html: 'c.html' leads to no file", "b.html: '#zwei' leads to no anchor"])
        self.assertEqual((count, links), (2, 8))


if __name__ == "__main__":
    unittest.main()
