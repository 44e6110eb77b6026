"""Settings of Sphinx. build.py writes the sources of the site, runs Doxygen and then Sphinx with these."""

import os
import pathlib
import re
import sys

from docutils import nodes
from pygments.lexers.data import JsonLexer
from sphinx import addnodes
from sphinx.domains.cpp import CPPDomain as Upstream

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent

project = "Palpate"
author = "the authors of Palpate"
version = release = re.search(r"project\(palpate\s+VERSION\s+([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]

extensions = ["myst_nb", "breathe", "sphinx_copybutton"]
root_doc = "index"

# Pages: GitHub's anchors of headings, `:param x:` fields of the reference.
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence", "fieldlist"]

# Notebooks run whenever the site is built; what fails there fails the build.
nb_execution_mode = "force"
nb_execution_show_tb = True
nb_output_stderr = "remove"  # Matplotlib's first run tells of its fonts
nb_execution_timeout = 300
nb_execution_cache_path = os.environ.get("PALPATE_DOCS_CACHE", "")
nb_execution_in_temp = True

breathe_projects = {"palpate": os.environ.get("PALPATE_DOXYGEN_XML", "")}
breathe_default_project = "palpate"
breathe_show_include = False
add_module_names = False
toc_object_entries = False
cpp_index_common_prefix = ["palpate::"]
python_maximum_signature_line_length = 88
cpp_maximum_signature_line_length = 88

html_theme = "furo"
html_title = f"Palpate {release}"
html_static_path = [str(HERE / "style.css"), str(HERE / "search_text.js")]
html_css_files = ["style.css"]
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_show_copyright = False
html_use_index = True
pygments_style = "tango"
pygments_dark_style = "monokai"
html_theme_options = {
    "top_of_page_buttons": [],
    "light_css_variables": {"color-brand-primary": "#0b5fa5", "color-brand-content": "#0b5fa5"},
    "dark_css_variables": {"color-brand-primary": "#7fbdf0", "color-brand-content": "#7fbdf0"},
}

WIDE = {"index", "docs/gallery"}  # without the contents at the right
SCENE = re.compile(r"\bexamples/scenes/[\w-]+\.json\b")
PAGE = re.compile(r"\bdocs/[\w/-]+\.md\b")


def scenes_beside_pictures(app, doctree):
    """In the gallery: the scene file beside what the page says and shows of it."""
    if app.env.docname != "docs/gallery":
        return
    for section in list(doctree.findall(nodes.section)):
        named = [SCENE.search(literal.astext()) for literal in section.findall(nodes.literal)
                 if literal.parent.parent is section]
        named = [match[0] for match in named if match]
        if not named:
            continue
        title, *rest = section.children
        left, right = nodes.container(classes=["told"]), nodes.container(classes=["scene"])
        left.extend(rest)
        code = (ROOT / named[0]).read_text()
        right += nodes.paragraph("", "", nodes.literal("", named[0]))
        right += nodes.literal_block(code, code, language="json")
        section.children = []
        section += [title, nodes.container("", left, right, classes=["beside"])]


def pages_named_in_comments(app, doctree):
    """In the reference: docs/NAME.md in a comment becomes a link to that page."""
    if not app.env.docname.startswith("reference/"):
        return
    for text in list(doctree.findall(nodes.Text)):
        if isinstance(text.parent, (nodes.reference, addnodes.pending_xref, nodes.literal_block)):
            continue
        done, end, source = [], 0, text.astext()
        for match in PAGE.finditer(source):
            name = match[0].removesuffix(".md")
            link = addnodes.pending_xref("", nodes.inline("", match[0]), refdomain="std", reftype="doc", refexplicit=True,
                                         reftarget=f"/{name}", refdoc=app.env.docname, refwarn=True)
            done += [nodes.Text(source[end:match.start()]), link]
            end = match.end()
        if done:
            text.parent.replace(text, [*done, nodes.Text(source[end:])])


def only_headings_in_contents(app, doctree):
    """In the reference: each type in the contents at the right, not each of its members."""
    for signature in doctree.findall(addnodes.desc_signature):
        signature["_toc_name"] = ""


class CppDomain(Upstream):
    """C++ without the parameters of functions in the search."""

    def get_objects(self):
        return (found for found in super().get_objects() if found[2] != "functionParam")


def pages_with_more(app, pagename, templatename, context, doctree):
    """No contents beside pages that need the width; the text of all pages for the search."""
    if pagename == "search":
        app.add_js_file("search_text.js")
    if pagename in WIDE:
        context["furo_hide_toc"] = True


def setup(app):
    app.add_domain(CppDomain, override=True)
    app.add_lexer("jsonc", JsonLexer)  # which knows comments
    app.connect("doctree-read", scenes_beside_pictures)
    app.connect("doctree-read", pages_named_in_comments)
    app.connect("doctree-read", only_headings_in_contents, priority=400)  # before Sphinx collects them
    app.connect("html-page-context", pages_with_more, priority=900)
