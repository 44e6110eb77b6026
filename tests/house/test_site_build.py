"""Builds the site of the documentation, as './dev docs' does, and looks at what is in it."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

ROOT = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"])
PYTHON = ROOT / "build/docs-python/bin/python"
SITE = ROOT / "build/docs"


class SiteBuild(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        done = subprocess.run([PYTHON, ROOT / "docs/site/build.py", os.environ["PALPATE_PACKAGE"]], capture_output=True, text=True)
        cls.status, cls.told = done.returncode, done.stdout + done.stderr

    def test_it_has_no_faults(self):
        self.assertEqual(self.status, 0, self.told)
        self.assertRegex(self.told, r"docs: \d{2,} pages, \d{4,} links checked")

    def test_the_notebook_ran(self):
        page = (SITE / "docs/tutorial/notebook.html").read_text()
        self.assertIn("92 contacts, the deepest 18.89 mm", page)
        self.assertIn("at rest on 3 balls", page)
        self.assertGreaterEqual(len(re.findall(r'<img [^>]*src="[^"]*_images/', page)), 3)

    def test_the_gallery_has_every_scene_beside_its_picture(self):
        page = (SITE / "docs/gallery.html").read_text()
        scenes = sorted((ROOT / "examples/scenes").glob("*.json"))
        self.assertEqual(page.count('class="scene docutils container"'), len(scenes))
        for scene in scenes:
            with self.subTest(scene=scene.name):
                self.assertIn(f"{scene.stem}.png", page)

    def test_the_references_have_what_is_public(self):
        python = (SITE / "reference/python.html").read_text()
        stated = re.search(r"__all__ = \[(.*?)\]", (ROOT / "python/palpate/__init__.py").read_text(), re.DOTALL)[1]
        for name in re.findall(r'"(\w+)"', stated):
            if not name.startswith("__"):
                with self.subTest(name=name):
                    self.assertIn(f'id="palpate.{name}"', python)
        for name in ["palpate.World.update", "palpate.World.contacts", "palpate.Contacts.depth", "palpate.Simulation.run"]:
            self.assertIn(f'id="{name}"', python)
        self.assertIn("detect()", (SITE / "reference/cpp/detection.hpp.html").read_text().replace("</span>", "").replace(
            '<span class="pre">', ""))

    def test_it_can_be_searched_and_read_without_a_network(self):
        self.assertIn("Search.setIndex(", (SITE / "searchindex.js").read_text())
        texts = (SITE / "_static/search_text.js").read_text()
        for page in ["docs/scene.html", "reference/python.html", "README.html"]:
            self.assertIn(f'"{page}": "', texts)


if __name__ == "__main__":
    for needed, there in [("build/docs-python", PYTHON.exists()), ("doxygen", shutil.which("doxygen"))]:
        if not there:
            print(f"skipped: there is no {needed}; './dev docs' installs it")
            sys.exit(77)
    unittest.main()
