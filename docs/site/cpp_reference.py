"""The C++ reference: Doxygen reads the public headers, and each header gets a page on which Breathe shows what it has."""

import pathlib
import re
import subprocess
import xml.etree.ElementTree as ElementTree

PLACE = pathlib.PurePosixPath("reference/cpp")

DOXYFILE = """
PROJECT_NAME = Palpate
INPUT = {headers}
FILE_PATTERNS = *.hpp
STRIP_FROM_PATH = {include}
STRIP_FROM_INC_PATH = {include}
OUTPUT_DIRECTORY = {output}
GENERATE_HTML = NO
GENERATE_LATEX = NO
GENERATE_XML = YES
XML_PROGRAMLISTING = NO
HIDE_FRIEND_COMPOUNDS = YES
SORT_MEMBER_DOCS = NO
QUIET = YES
WARN_NO_PARAMDOC = NO
WARN_FORMAT = "$file:$line: $text"
"""


def public_headers(root):
    """The headers that are installed."""
    return sorted((root / "include/palpate").glob("*.hpp"))


def run_doxygen(root, output):
    """Reads the headers to output/xml; returns a line for each thing without a comment, and other warnings."""
    output.mkdir(parents=True, exist_ok=True)
    (output / "Doxyfile").write_text(DOXYFILE.format(headers=root / "include/palpate", include=root / "include", output=output))
    done = subprocess.run(["doxygen", output / "Doxyfile"], capture_output=True, text=True, check=True)
    lines = [line.removeprefix(f"{root}/") for line in done.stderr.splitlines() if line.strip()]
    undocumented = [line for line in lines if "is not documented" in line and "following parameter" not in line]
    others = [line for line in lines if line not in undocumented]
    # Doxygen asks for all parameters of a function where one is explained; we explain those that a name does not.
    others = [line for line in others if "following parameter" not in line and not line.startswith("  parameter ")]
    return undocumented, others


def short(element):
    """The first sentence of a comment, as text."""
    for kind in ("brief", "detailed"):
        paragraph = element.find(f"{kind}description/para")
        if paragraph is not None:
            return re.split(r"\.\s+(?=[A-Z])", " ".join("".join(paragraph.itertext()).split()))[0].rstrip(".")
    return ""


class Header:
    """What a header declares, in its order: (line, name, directive, first sentence)."""

    def __init__(self, file, xml):
        self.name = file.name
        self.types, self.functions, self.names = [], [], []
        for entry in ElementTree.parse(xml / "index.xml").getroot():
            if entry.get("kind") in ("struct", "class", "namespace"):
                compound = ElementTree.parse(xml / f"{entry.get('refid')}.xml").getroot().find("compounddef")
                if entry.get("kind") == "namespace":
                    self.add_members(compound, file)
                elif self.is_here(compound, file) and compound.get("prot") == "public":
                    self.types.append((int(compound.find("location").get("line")), compound.findtext("compoundname"),
                                       f"doxygen{entry.get('kind')}", short(compound)))
        self.types.sort()

    @staticmethod
    def is_here(element, file):
        return pathlib.PurePosixPath(element.find("location").get("file")).name == file.name

    def add_members(self, namespace, file):
        for member in namespace.iter("memberdef"):
            if not self.is_here(member, file):
                continue
            kind, name = member.get("kind"), f"{namespace.findtext('compoundname')}::{member.findtext('name')}"
            row = (int(member.find("location").get("line")), name, f"doxygen{kind}", short(member))
            if kind == "enum":
                self.types.append(row)
            elif kind == "function":
                arguments = ", ".join("".join(parameter.find("type").itertext()) for parameter in member.iter("param"))
                self.functions.append((row[0], f"{name}({arguments})", row[2], row[3]))
            else:
                self.names.append(row)

    def page(self):
        lines = [f"# {self.name}", "", "```cpp", f"#include <palpate/{self.name}>", "```", ""]
        for _, name, directive, _ in self.types:
            lines += [f"## {name.removeprefix('palpate::')}", "", f"```{{{directive}}} {name}", "```", ""]
            if directive != "doxygenenum":
                lines[-3:-2] = [lines[-3], ":members:", ":undoc-members:"]
        for title, rows in [("Functions", self.functions), ("Names and constants", self.names)]:
            if rows:
                lines += [f"## {title}", ""]
                for _, name, directive, _ in sorted(rows):
                    lines += [f"```{{{directive}}} {name}", "```", ""]
        return "\n".join(lines)


def add_reference(pages, root, xml):
    """A page for each header, and one that lists them."""
    headers = [Header(file, xml) for file in public_headers(root)]
    named = [header for header in headers if header.types or header.functions or header.names]
    lines = ["# C++", "", "Every public header with what it declares. `palpate/palpate.hpp` includes them all; all names",
             "are in the namespace `palpate`.", ""]
    for header in named:
        pages.add(PLACE / f"{header.name}.md", header.page())
        lines += [f"## [{header.name}]({header.name}.md)", "", "| name | what it is |", "|---|---|"]
        for _, name, directive, brief in header.types + sorted(header.functions + header.names):
            role = {"doxygenfunction": "func", "doxygenenum": "enum", "doxygentypedef": "type", "doxygenvariable": "var"}.get(
                directive, "class")
            plain = name.split("(")[0]
            shown = plain.removeprefix("palpate::") + ("()" if role == "func" else "")
            text = brief.replace("|", "\\|").replace("_", "\\_").replace("*", "\\*").replace("<", "\\<")
            lines.append(f"| {{cpp:{role}}}`{shown} <{plain}>` | {text} |")
        lines.append("")
    lines += ["```{toctree}", ":hidden:", "", *[f"{header.name}" for header in named], "```", ""]
    pages.add(PLACE / "index.md", "\n".join(lines))
