"""Private words that have a term of the field must not come back: in names, comments, messages and pages (words.py)."""

import fnmatch
import io
import os
import pathlib
import re
import subprocess
import sys
import tokenize
import unittest

ROOT = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"])
sys.path.insert(0, str(pathlib.Path(__file__).parent))

import words  # noqa: E402

CODE = {".cpp", ".hpp", ".ts", ".js", ".mjs"}
FOLDERS = ("src/", "apps/", "include/", "python/", "viewer/", "tests/", "bench/", "examples/", "docs/", "scenes/")
# Raw strings, strings, characters and comments of C++ and TypeScript.
LITERAL = re.compile(r'R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|`(?:\\.|[^`\\])*`|//[^\n]*|/\*.*?\*/', re.DOTALL)
PART = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
PHRASES = {word: re.compile(rf"\b(?:{word})\b", re.IGNORECASE) for word in words.TEXT}


def split_cpp(text):
    """The code without literals, and comments and literals without code; line numbers stay."""
    plain = re.sub(r"(?<=[0-9a-fA-F])'(?=[0-9a-fA-F])", " ", text)  # separators of digits
    code, prose, at = [], [], 0
    for match in LITERAL.finditer(plain):
        piece = plain[match.start():match.end()]
        lines = "\n" * piece.count("\n")
        code += [plain[at:match.start()], lines]
        prose += ["\n" * plain[at:match.start()].count("\n"), piece]
        at = match.end()
    return "".join([*code, plain[at:]]), "".join(prose)


def split_python(text):
    code, prose = [], []
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        target = {tokenize.NAME: code, tokenize.STRING: prose, tokenize.COMMENT: prose}.get(token.type)
        if target is not None:
            target += ["\n" * max(0, token.start[0] - 1 - "".join(target).count("\n")), token.string, " "]
    return "".join(code), "".join(prose)


def names_in(code, is_test):
    """(line, word, name) of each name with a part that is a word of the list."""
    for number, line in enumerate(code.splitlines(), 1):
        for name in re.findall(r"[A-Za-z_]\w*", line):
            if is_test and re.match(r"[A-Z]|test_", name):  # names of tests are sentences
                continue
            for part in {part.lower() for part in PART.findall(name)} & set(words.NAMES):
                yield number, part, name


def phrases_in(prose):
    """(word, what was found, the text before it); a phrase may go over the end of a line of a comment."""
    joined = re.sub(r"\n[ \t]*(?://+<?|\*)?[ \t]*", " ", prose)
    for word, pattern in PHRASES.items():
        for match in pattern.finditer(joined):
            yield word, match[0], joined[max(0, match.start() - 40):match.start()].strip()


def offences(name, text):
    """Lines that say what is wrong in a file."""
    suffix = pathlib.PurePosixPath(name).suffix
    if suffix == ".md":
        code, prose = "", text
    else:
        code, prose = split_python(text) if suffix == ".py" else split_cpp(text)
    for number, word, found in names_in(code, name.startswith("tests/")):
        if not allowed(name, found):
            yield f"{name}:{number}: '{found}', expected {words.NAMES[word]}"
    for word, found, before in phrases_in(prose):
        if not allowed(name, found):
            yield f"{name}: '{before} {found}', expected {words.TEXT[word]}"


def allowed(name, found):
    return any(fnmatch.fnmatchcase(name, files) and fnmatch.fnmatchcase(found.lower(), pattern.lower())
               for files, pattern, _ in words.ALLOWED)


def checked_files():
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    for name in listed:
        suffix = pathlib.PurePosixPath(name).suffix
        if (suffix in CODE | {".py"} and name.startswith(FOLDERS)) or suffix == ".md":
            if not any(fnmatch.fnmatchcase(name, pattern) for pattern in words.HISTORY) and (ROOT / name).exists():
                yield name


class Words(unittest.TestCase):
    def test_the_search_sees_what_it_must(self):
        for name, text in [("a.cpp", "double share = 1;"), ("a.cpp", "void try_share();"), ("a.hpp", "struct SideShare {};"),
                           ("a.cpp", "// a jaw on rails"), ("a.cpp", "/// Each finds its way\n/// out."), ("a.cpp", 'x("in vain")'),
                           ("a.py", "def my_way(): pass"), ("a.py", '"""The turned\n    frame."""'), ("a.md", "The side share.")]:
            self.assertEqual(len(list(offences(name, text))), 1, text)
        for name, text in [("a.cpp", "std::shared_ptr<int> p;"), ("a.cpp", "const char* c = \"share\"; // share"),
                           ("a.cpp", "always(1'000'000);"), ("a.py", "shared = 'way'"), ("a.md", "A railway, of latex.")]:
            self.assertEqual(list(offences(name, text)), [], text)

    def test_no_private_word_is_back(self):
        found = [line for name in checked_files() for line in offences(name, (ROOT / name).read_text())]
        self.assertEqual(found, [], "\n" + "\n".join(found))

    def test_every_exception_is_still_needed(self):
        names = list(checked_files())
        without = words.ALLOWED
        words.ALLOWED = []
        self.addCleanup(setattr, words, "ALLOWED", without)
        for files, pattern, reason in without:
            self.assertTrue(reason)
            with self.subTest(files=files, pattern=pattern):
                texts = {name: (ROOT / name).read_text() for name in names if fnmatch.fnmatchcase(name, files)}
                hits = [line for name, text in texts.items() for line in offences(name, text)]
                self.assertTrue(hits, "nothing there is refused without it")


if __name__ == "__main__":
    unittest.main()
