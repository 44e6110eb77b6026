"""Builds the site of the documentation to build/docs. './dev docs' calls it.

    build.py PACKAGE_FOLDER

PACKAGE_FOLDER is where the built Python package `palpate` is: notebooks run with it, and the Python reference tells
what it has. 1 where anything is amiss: a warning of Sphinx or Doxygen, a notebook that fails, a broken link.
"""

import html
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

import check_links
import cpp_reference
import python_reference
from pages import Pages

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent


def write_sources(folder, xml, package):
    """All that Sphinx reads."""
    pages = Pages(ROOT, folder)
    front = [line for line in (HERE / "index.md").read_text().splitlines() if "*" not in line or pages.matching(line)]
    pages.add("index.md", pages.with_links("\n".join(front), HERE.relative_to(ROOT), pathlib.PurePosixPath(".")))
    for page in sorted(pages.pages):
        pages.add_page(page)
    cpp_reference.add_reference(pages, ROOT, xml)
    python_reference.add_reference(pages, package)


def run_sphinx(work, site, package):
    """Whether it went without a warning."""
    kernel = work / "ipython/profile_default/ipython_kernel_config.py"  # and not what this user has
    kernel.parent.mkdir(parents=True, exist_ok=True)
    kernel.write_text('get_config().IPKernelApp.log_level = "ERROR"\n')
    environment = dict(os.environ, PALPATE_DOXYGEN_XML=str(work / "xml"), PALPATE_DOCS_CACHE=str(work / "notebooks"),
                       IPYTHONDIR=str(work / "ipython"), PYTHONDONTWRITEBYTECODE="1", PYTHONPATH=str(package))
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-j", "auto", "-b", "html", "-c", HERE,
               "-d", work / "doctrees", work / "source", site]
    return subprocess.run(command, env=environment).returncode == 0


def text_of(page):
    """The text of a page of the site, without tags and without its head."""
    article = re.search(r"<article.*?</article>", page.read_text(), re.DOTALL)
    return " ".join(html.unescape(re.sub(r"<[^>]*>", "", article[0] if article else "")).replace("\u00b6", " ").split())


def write_search_text(site):
    """Puts the text of all pages that are searched into the script of the search page."""
    texts = {str(page.relative_to(site)): text_of(page) for folder in ["*.html", "docs/**/*.html", "reference/**/*.html"]
             for page in sorted(site.glob(folder))}
    script = site / "_static/search_text.js"
    source = script.read_text()
    assert "const pages = {};" in source
    script.write_text(source.replace("const pages = {};", f"const pages = {json.dumps(texts, ensure_ascii=False)};"))


def main():
    start = time.monotonic()
    package = pathlib.Path(sys.argv[1]).resolve()
    site, work = ROOT / "build/docs", ROOT / "build/docs-work"
    for old in [site, work]:  # from scratch: Sphinx warns only of the pages that it reads
        shutil.rmtree(old, ignore_errors=True)
    undocumented, warnings = cpp_reference.run_doxygen(ROOT, work)
    if warnings:
        sys.exit("\n".join(warnings))
    if undocumented:
        sys.exit("\n".join([*undocumented, f"docs: {len(undocumented)} public names have no comment"]))
    write_sources(work / "source", work / "xml", package)
    if not run_sphinx(work, site, package):
        sys.exit("docs: the site has faults (see above); its sources are in build/docs-work/source")
    write_search_text(site)
    faults, pages, links = check_links.faults(site)
    if faults:
        sys.exit("\n".join([*faults, f"docs: {len(faults)} broken links"]))
    size = sum(file.stat().st_size for file in site.rglob("*") if file.is_file()) / 1e6
    print(f"docs: {pages} pages, {links} links checked, {size:.0f} MB, {time.monotonic() - start:.0f} s")


if __name__ == "__main__":
    main()
