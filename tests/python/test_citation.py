"""CITATION.cff is valid, has this version, and names the paper."""

import re

import yaml


def test_it_is_of_this_version_and_names_the_paper(root):
    citation = yaml.safe_load((root / "CITATION.cff").read_text())
    assert {"cff-version", "message", "title", "authors"} <= set(citation)  # what the format requires
    assert str(citation["version"]) == re.search(r"palpate VERSION ([0-9.]+)", (root / "CMakeLists.txt").read_text())[1]
    paper, = citation["references"]
    assert {"type", "title", "authors", "year", "url"} <= set(paper)
    assert all(set(author) >= {"given-names", "family-names"} for author in paper["authors"])
    assert paper["type"] == "conference-paper"
    assert "GRAPP 2011" in paper["conference"]["name"] and paper["year"] == 2011
    assert not {"pages", "start", "end", "doi"} & set(paper)  # nobody has seen a page that says them
    # The title as on the other pages.
    for page in ["README.md", "docs/paper-map.md"]:
        assert paper["title"].lower() in " ".join((root / page).read_text().split()).lower(), page
