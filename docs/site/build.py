"""Builds the site of the documentation to build/docs. './dev docs' calls it.

    build.py PACKAGE_FOLDER

PACKAGE_FOLDER is where the built Python package `palpate` is: notebooks run with it, and the Python reference tells
what it has. 1 where anything is amiss: a warning of Sphinx or Doxygen, a notebook that fails, a broken link.
"""

import os
import pathlib
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
    pages.add("index.md", pages.with_links((HERE / "index.md").read_text(), pages_place(HERE), pages_place(ROOT)))
    for page in sorted(pages.pages):
        pages.add_page(page)
    cpp_reference.add_reference(pages, ROOT, xml)
    python_reference.add_reference(pages, package)
    pages.clean()


def pages_place(folder):
    return pathlib.PurePosixPath(folder.relative_to(ROOT))


def main():
    start = time.monotonic()
    package = pathlib.Path(sys.argv[1]).resolve()
    site, work = ROOT / "build/docs", ROOT / "build/docs-work"
    undocumented, warnings = cpp_reference.run_doxygen(ROOT, work)
    (work / "undocumented.txt").write_text("\n".join([*undocumented, ""]))
    if warnings:
        sys.exit("\n".join(warnings))
    if len(undocumented) > cpp_reference.MOST_UNDOCUMENTED:
        sys.exit("\n".join([*undocumented, f"docs: {len(undocumented)} public names have no comment; "
                            f"there may be {cpp_reference.MOST_UNDOCUMENTED}"]))
    write_sources(work / "source", work / "xml", package)
    environment = dict(os.environ, PALPATE_DOXYGEN_XML=str(work / "xml"), PALPATE_DOCS_CACHE=str(work / "notebooks"), PYTHONDONTWRITEBYTECODE="1",
                       PYTHONPATH=os.pathsep.join([str(package), os.environ.get("PYTHONPATH", "")]).rstrip(os.pathsep))
    if subprocess.run([sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-j", "auto", "-b", "html", "-c", HERE, "-d", work / "doctrees",
                       work / "source", site], env=environment).returncode != 0:
        sys.exit("docs: the site has faults (see above); its sources are in build/docs-work/source")
    faults, pages, links = check_links.faults(site)
    if faults:
        sys.exit("\n".join([*faults, f"docs: {len(faults)} broken links"]))
    size = sum(file.stat().st_size for file in site.rglob("*") if file.is_file()) / 1e6
    print(f"docs: {pages} pages, {links} links checked, {size:.0f} MB, {time.monotonic() - start:.0f} s; "
          f"public names without a comment: {len(undocumented)} (build/docs-work/undocumented.txt)")


if __name__ == "__main__":
    main()
