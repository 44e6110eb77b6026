"""Completion and manual pages agree with --help. Oracles: the shells themselves and the formatter of man.

Usage: test_completion.py PALPATE
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

COMMAND = pathlib.Path(sys.argv.pop(1)).resolve()


def palpate(*words):
    return subprocess.run([COMMAND, *words], capture_output=True, text=True, check=True, timeout=60).stdout


def flags_in_help(*words):
    """The flags in --help: the oracle, written by CLI11."""
    return set(re.findall(r"(?m)^  (?:-\w,)?(--[\w-]+)", palpate(*words, "--help")))


def subcommands_in_help(*words):
    text = palpate(*words, "--help")
    below = text.partition("Subcommands:\n")[2].partition("\n\n")[0]
    return set(re.findall(r"(?m)^  ([a-z-]+) ", below + "\n"))


# "palpate help --help" is the help of the whole.
SUBCOMMANDS = [[name] for name in sorted(subcommands_in_help() - {"help"})] + [["generate", "box"], ["bench", "paper"]]


class Bash(unittest.TestCase):
    def offers(self, *words, folder=None):
        """The completions that bash offers for the last of these words; '=' is a separate word, as in bash."""
        script = 'source "$1"; shift; COMP_WORDS=(palpate "$@"); COMP_CWORD=$#; _palpate; printf "%s\\n" "${COMPREPLY[@]}"'
        with tempfile.NamedTemporaryFile("w", suffix=".bash") as file:
            file.write(palpate("completion", "bash"))
            file.flush()
            done = subprocess.run(["bash", "-uc", script, "bash", file.name, *words], capture_output=True, text=True,
                                  cwd=folder, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return set(done.stdout.split())

    def test_subcommands(self):
        self.assertEqual(self.offers(""), subcommands_in_help())
        self.assertEqual(self.offers("ge"), {"generate"})
        self.assertEqual(self.offers("generate", ""), subcommands_in_help("generate"))
        self.assertEqual(self.offers("help", "generate"[:3]), {"generate"})

    def test_flags_of_every_subcommand_are_those_of_its_help(self):
        for words in SUBCOMMANDS:
            with self.subTest(words=words):
                self.assertEqual(self.offers(*words, "--"), flags_in_help(*words))

    def test_values(self):
        self.assertEqual(self.offers("run", "--structure", "c"), {"compact", "cuckoo"})
        self.assertEqual(self.offers("run", "--structure", "=", "h"), {"hash"})
        self.assertEqual(self.offers("completion", ""), {"bash", "zsh", "fish"})
        self.assertEqual(self.offers("new", "x.vtu", "--unit", ""), {"m", "cm", "mm", "um"})
        self.assertEqual(self.offers("run", "--steps", ""), {*()})

    def test_files(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ["scene.json", "liver.vtu", "notes.txt"]:
                (pathlib.Path(folder) / name).touch()
            (pathlib.Path(folder) / "results").mkdir()
            self.assertEqual(self.offers("run", "", folder=folder), {"scene.json", "results"})
            self.assertEqual(self.offers("view", "", folder=folder), {"scene.json", "liver.vtu", "results"})
            self.assertEqual(self.offers("run", "--out", "", folder=folder), {"results"})
            self.assertEqual(self.offers("new", "", folder=folder), {"liver.vtu", "results"})


class Fish(unittest.TestCase):
    def setUp(self):
        self.assertIsNotNone(shutil.which("fish"), "fish is not installed: ./dev test installs it")

    def offers(self, line):
        with tempfile.TemporaryDirectory() as home:
            (pathlib.Path(home) / "palpate.fish").write_text(palpate("completion", "fish"))
            # fish completes what it can find.
            for name in ["scene.json", "liver.vtu", "notes.txt"]:
                (pathlib.Path(home) / name).touch()
            (pathlib.Path(home) / "results").mkdir()
            environment = dict(os.environ, HOME=home, PATH=f"{COMMAND.parent}:{os.environ['PATH']}")
            done = subprocess.run(["fish", "-c", f"source {home}/palpate.fish; complete -C '{line}'"], capture_output=True,
                                  text=True, env=environment, cwd=home, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return {offer.split("\t")[0] for offer in done.stdout.splitlines()}

    def test_subcommands_flags_and_values(self):
        self.assertEqual(self.offers("palpate "), subcommands_in_help())
        for words in SUBCOMMANDS:
            with self.subTest(words=words):
                self.assertEqual(self.offers(f"palpate {' '.join(words)} --"), flags_in_help(*words))
        self.assertEqual(self.offers("palpate run --structure c"), {"compact", "cuckoo"})
        self.assertEqual(self.offers("palpate completion "), {"bash", "zsh", "fish"})
        self.assertEqual(self.offers("palpate view "), {"scene.json", "liver.vtu", "results/"})


class Zsh(unittest.TestCase):
    # A shell on a pseudo-terminal that lists its completions.
    DRIVER = r"""
zmodload zsh/zpty
comp() {
  zpty z zsh -f -i
  zpty -w z "PROMPT=; fpath=($2 \$fpath); autoload -Uz compinit; compinit -u -D; stty -echo; LISTMAX=1000; zstyle ':completion:*' list-packed no"
  zpty -w z 'bindkey "^I" list-choices; print READY'
  zpty -r z text '*READY*READY*' || true
  zpty -w -n z "$1"$'\t'
  sleep 2
  zpty -w -n z $'\x15print DONE\n'
  local all=""
  while zpty -r z text; do all+="$text"; [[ $text == *DONE* ]] && break; done
  print -r -- "$all"
}
comp "$1" "$2"
"""

    def setUp(self):
        self.assertIsNotNone(shutil.which("zsh"), "zsh is not installed: ./dev test installs it")

    def offers(self, line):
        with tempfile.TemporaryDirectory() as folder:
            for name in ["scene.json", "liver.vtu", "notes.txt"]:
                (pathlib.Path(folder) / name).touch()
            (pathlib.Path(folder) / "results").mkdir()
            (pathlib.Path(folder) / "_palpate").write_text(palpate("completion", "zsh"))
            environment = dict(os.environ, PATH=f"{COMMAND.parent}:{os.environ['PATH']}", TERM="dumb", COLUMNS="200")
            done = subprocess.run(["timeout", "30", "zsh", "-f", "-c", self.DRIVER, "zsh", line, folder],
                                  capture_output=True, text=True, env=environment, cwd=folder, timeout=60)
        return done.stdout

    def test_its_syntax_and_what_it_lists(self):
        with tempfile.NamedTemporaryFile("w", suffix=".zsh") as file:
            file.write(palpate("completion", "zsh"))
            file.flush()
            done = subprocess.run(["zsh", "-n", file.name], capture_output=True, text=True, timeout=60)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
        listed = self.offers("palpate ")
        for name in subcommands_in_help():
            self.assertRegex(listed, rf"\b{name} +--", "subcommand")
        listed = self.offers("palpate run --")
        for flag in flags_in_help("run"):
            self.assertIn(f"{flag} ", listed)
        listed = self.offers("palpate view ")
        for name, offered in [("scene.json", True), ("liver.vtu", True), ("results", True), ("notes.txt", False)]:
            self.assertEqual(name in listed, offered, name)


class Manual(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        palpate("manual", "--out", folder.name)

    def test_a_page_for_each_subcommand(self):
        pages = {page.name for page in self.folder.iterdir()}
        self.assertIn("palpate.1", pages)
        for words in SUBCOMMANDS:
            self.assertIn("-".join(["palpate", *words]) + ".1", pages)
        self.assertEqual((self.folder / "palpate-run.1").read_text(), palpate("manual", "run"))

    def test_every_flag_of_the_help_is_on_its_page_as_man_shows_it(self):
        self.assertIsNotNone(shutil.which("groff"), "groff is not installed: ./dev test installs it")
        for words in SUBCOMMANDS:
            with self.subTest(words=words):
                page = self.folder / ("-".join(["palpate", *words]) + ".1")
                shown = subprocess.run(["groff", "-man", "-ww", "-Tascii", "-P-cbou", page], capture_output=True, text=True,
                                       check=True)
                self.assertEqual(shown.stderr, "")
                for flag in flags_in_help(*words):
                    self.assertRegex(shown.stdout, rf"(?m)^ +(-\w, )?{flag}\b")
                for heading in ["NAME", "SYNOPSIS", "EXAMPLES", "EXIT STATUS", "SEE ALSO"]:
                    self.assertRegex(shown.stdout, rf"(?m)^{heading}$")

    def test_mandoc_has_nothing_to_say(self):
        self.assertIsNotNone(shutil.which("mandoc"), "mandoc is not installed: ./dev test installs it")
        done = subprocess.run(["mandoc", "-Tlint", "-Wwarning", *sorted(self.folder.iterdir())], capture_output=True,
                              text=True)
        # No date: the same build gives the same page.
        found = [line for line in done.stdout.splitlines() if "missing date" not in line]
        self.assertEqual(found, [])


if __name__ == "__main__":
    unittest.main()
