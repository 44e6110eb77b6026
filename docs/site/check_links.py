"""Checks a built site: every link leads to a file, every anchor is there, and no page loads anything from the network.

    check_links.py FOLDER
"""

import html.parser
import pathlib
import sys
import urllib.parse

LOADED = {("script", "src"), ("img", "src"), ("link", "href"), ("source", "src"), ("iframe", "src")}
NOT_LOADED = {"canonical", "index", "search", "next", "prev"}  # what <link rel=...> only names


class Page(html.parser.HTMLParser):
    """The anchors and the links of a page."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.links, self.loads = set(), [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.anchors.update(values[name] for name in ("id", "name") if values.get(name) and (name == "id" or tag == "a"))
        for name in ("href", "src"):
            if values.get(name):
                self.links.append(values[name])
                if (tag, name) in LOADED and values.get("rel") not in NOT_LOADED:
                    self.loads.append(values[name])


def faults(folder):
    """A line for each link that leads nowhere."""
    pages = {file: Page(file.read_text(errors="replace")) for file in sorted(folder.rglob("*.html"))}
    found = []
    for file, page in pages.items():
        name = file.relative_to(folder)
        found += [f"{name}: loads '{link}' from the network" for link in page.loads if "//" in link.split("?")[0]]
        for link in dict.fromkeys(page.links):
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (file.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else file
            anchor = urllib.parse.unquote(parts.fragment)
            if target.is_dir():
                target /= "index.html"
            if not target.is_file():
                found.append(f"{name}: '{link}' leads to no file")
            elif anchor and target in pages and anchor not in pages[target].anchors:
                found.append(f"{name}: '{link}' leads to no anchor")
    return found, len(pages), sum(len(page.links) for page in pages.values())


def main():
    found, pages, links = faults(pathlib.Path(sys.argv[1]).resolve())
    print("\n".join(found + [f"{pages} pages, {links} links, {len(found)} of them broken"]))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
