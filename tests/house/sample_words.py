"""Twenty comments, ten messages and ten pages by chance, at a commit and now (docs/notes/words.md).

    python3 tests/house/sample_words.py COMMIT [SEED]

For each comment and message of the commit, the nearest one in the tree as it is: by its text and the line of code after it.
"""

import difflib
import pathlib
import random
import re
import subprocess
import sys

COMMENT = re.compile(r"(?m)(?:^[ \t]*//[^\n]*\n)+")
STRING = re.compile(r'"((?:\\.|[^"\\\n])*)"')


def git(*arguments):
    return subprocess.run(["git", *arguments], capture_output=True, text=True, check=True).stdout


def comments(name, text):
    for match in COMMENT.finditer(text):
        plain = " ".join(line.strip().lstrip("/<").strip() for line in match[0].strip().splitlines())
        if len(plain.split()) >= 5:
            yield name, plain, text[match.end():].split("\n", 1)[0].strip()


def messages(name, text):
    for match in STRING.finditer(re.sub(r"//[^\n]*", "", text)):
        if len(match[1].split()) >= 4 and re.search(r"[a-z]{3}", match[1]):
            yield name, match[1], ""


def collect(kind, files, read):
    return [entry for name in files for entry in kind(name, read(name))]


def likeness(one, other):
    same = 0.3 if pathlib.PurePosixPath(one[0]).parent == pathlib.PurePosixPath(other[0]).parent else 0.0
    words = difflib.SequenceMatcher(None, one[1].split(), other[1].split(), autojunk=False).ratio()
    code = difflib.SequenceMatcher(None, one[2], other[2], autojunk=False).ratio() if one[2] else 0.0
    return same + words + code


def main():
    commit, seed = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 27
    chance = random.Random(seed)
    folders = ["src", "include", "apps"]
    before = [name for name in git("ls-tree", "-r", "--name-only", commit, *folders).splitlines() if name.endswith(("pp",))]
    after = [name for name in git("ls-files", *folders).splitlines() if name.endswith(("pp",))]
    for kind, count in [(comments, 20), (messages, 10)]:
        then = collect(kind, before, lambda name: git("show", f"{commit}:{name}"))
        now = collect(kind, after, lambda name: pathlib.Path(name).read_text())
        for entry in chance.sample(then, count):
            best = max(now, key=lambda other: likeness(entry, other))
            print(f"\n## {kind.__name__} {entry[0]}\n- {entry[1]}\n+ {best[0]}: {best[1]}  ({likeness(entry, best):.2f})")
    pages = [name for name in git("ls-tree", "-r", "--name-only", commit, "docs", "README.md").splitlines()
             if name.endswith(".md") and "notes" not in name]
    print("\n## pages\n" + "\n".join(sorted(chance.sample(pages, 10))))


main()
