"""Makes the docstrings of the bindings out of the /// comments of C++ headers: one source for both languages.

    docs_from_headers.py OUTPUT HEADER...

OUTPUT is a header with one constant for each declaration that has a comment: `doc::Simulation_step` is that of
`Simulation::step`, `doc::box` that of a free function. Of overloads the first counts. A binding that names a
declaration without a comment does not compile.
"""

import pathlib
import re
import sys

TOKEN = re.compile(
    r"""(?P<behind>///<[^\n]*)|(?P<before>///[^\n]*)|(?P<comment>//[^\n]*|/\*.*?\*/)|(?P<directive>(?m:^\s*\#[^\n]*))
    |(?P<string>"(?:\\.|[^"\\\n])*")|(?P<mark>[{};,:])|(?P<blank>\n[ \t]*(?=\n))|(?P<text>[^{};,:/"\#\n]+|.|\n)""",
    re.DOTALL | re.VERBOSE,
)
SCOPE = re.compile(r"\b(?:class|struct|enum(?:\s+class)?|namespace)\s+(?P<name>\w+)")


def declared_name(statement):
    """The name that a declaration declares: the last one before its parameters, its value or its end; else ""."""
    if "operator" in statement:
        return ""
    shorter = re.sub(r"\[\[\w+\]\]", "", statement)
    while (without := re.sub(r"<[^<>]*>", "", shorter)) != shorter:
        shorter = without
    names = re.findall(r"~?\w+", re.split(r"[=(\[]", shorter, maxsplit=1)[0])
    return names[-1] if names else ""


class Header:
    """Reads the tokens of a header and records the comment of each declaration."""

    def __init__(self):
        self.found = {}  # qualified name -> lines of comment
        self.scopes = []  # (kind, name); a kind of "" is a body or value that is skipped
        self.statement = ""
        self.before = []
        self.last = None

    def skipping(self):
        return bool(self.scopes) and self.scopes[-1][0] == ""

    def kind(self):
        return self.scopes[-1][0] if self.scopes else "namespace"

    def declare(self, name):
        path = [scope for kind, scope in self.scopes if kind != "namespace"] + [name]
        self.last = self.found.setdefault("_".join(path), list(self.before)) if name else None
        self.before = []

    def finish(self):
        if self.statement.strip():
            self.declare(declared_name(self.statement))
        self.statement = ""

    def open(self):
        scope = SCOPE.search(self.statement)
        if self.skipping() or not scope or "(" in self.statement:
            self.scopes.append(("", self.statement))
            return
        kind = scope[0].split()[0]
        if kind != "namespace":
            self.declare(scope["name"])
        self.before = []
        self.statement = ""
        self.scopes.append((kind, scope["name"]))

    def close(self):
        kind, statement = self.scopes.pop()
        if kind == "enum":
            self.scopes.append((kind, statement))
            self.finish()
            self.scopes.pop()
        if kind != "":
            self.statement = ""
        elif not self.skipping() and "(" in statement and "=" not in statement:
            self.finish()  # a function with its body; a value in braces continues to its semicolon

    def take(self, token):
        what, text = token.lastgroup, token[0]
        if what == "mark" and text == "{":
            self.open()
        elif what == "mark" and text == "}":
            self.close()
        elif self.skipping() or what in ("comment", "directive", "string"):
            return
        elif what == "blank":
            if not self.statement.strip():
                self.before = []
        elif what == "before":
            self.before.append(text[3:].removeprefix(" "))
        elif what == "behind":
            if self.statement.strip():  # the last of an enumeration has no comma
                self.finish()
            if self.last is not None:
                self.last.append(text[4:].strip())
        elif text == ";" or (text == "," and self.kind() == "enum"):
            self.finish()
        elif text == ":" and self.statement.strip() in ("public", "private", "protected"):
            self.statement = ""
        else:
            self.statement += text


def docstring(lines):
    """Comment lines as a docstring: parameters as `name: text`."""
    paragraphs = []
    for line in lines:
        words = re.split(r"\\param\s+", line)
        paragraphs.append(words[0])
        paragraphs.extend(f"\n{word.split(maxsplit=1)[0]}: {word.split(maxsplit=1)[-1]}" for word in words[1:])
    text = "\n".join(paragraphs).strip("\n")
    return re.sub(r"[ ]+$", "", text, flags=re.MULTILINE)


def docs_of(text):
    """{qualified name: docstring} of a header."""
    header = Header()
    for token in TOKEN.finditer(text):
        header.take(token)
    return {name: docstring(lines) for name, lines in header.found.items() if lines}


def main(output, *headers):
    docs = {}
    for header in headers:
        for name, text in docs_of(pathlib.Path(header).read_text()).items():
            docs.setdefault(name, text)
    constants = [f'inline constexpr const char* {name} = R"doc({text})doc";' for name, text in sorted(docs.items())]
    text = "#pragma once\n\nnamespace palpate::python::doc {\n" + "\n".join(constants) + "\n}\n"
    pathlib.Path(output).write_text(text)


if __name__ == "__main__":
    main(*sys.argv[1:])
