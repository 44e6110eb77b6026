"""The tutorial "Push a liver with an instrument", line by line, and the code of docs/forces.md."""

import re
import subprocess
import sys

import numpy as np
import pytest

import palpate

PAGE = "docs/tutorial/push.md"


def blocks(text, language):
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def lines(text):
    return [line.strip() for line in text.splitlines() if line.strip()]


def rounded(text):
    """Words, numbers to two digits: the last ones differ between processors."""
    return [f"{float(word):.2g}" if re.fullmatch(r"-?\d+(\.\d+)?", word) else word for word in re.split(r"[\s,;:]+", text.strip())]


@pytest.fixture(scope="module")
def page(root):
    return (root / PAGE).read_text()


@pytest.fixture(scope="module")
def run(root, command, tmp_path_factory):
    """Runs the command of the page in another folder; returns its output and the folder."""
    (line,) = [line for block in blocks((root / PAGE).read_text(), "sh") for line in lines(block)]
    folder = tmp_path_factory.mktemp("push") / "push"
    words = [command if word == "palpate" else word for word in line.split()]
    printed = subprocess.run([*words, "--out", folder], cwd=root, capture_output=True, text=True, check=True).stdout
    return printed, folder


def test_the_command_prints_what_the_page_shows(page, run):
    printed, _ = run
    shown = lines(blocks(page, "text")[0])
    assert len(shown) >= 4
    for line in shown:
        assert any(rounded(line) == rounded(other) for other in printed.splitlines()), (line, printed)


def test_the_scene_is_the_one_that_is_shown(page, root):
    (shown,) = blocks(page, "json")
    assert "\n".join(lines(shown)) in "\n".join(lines((root / "examples/push/push.json").read_text()))


def test_the_table_gives_what_the_page_shows(page, run, capsys):
    import pandas

    _, folder = run
    (code,) = [block for block in blocks(page, "python") if "read_csv" in block]
    exec(code.replace("results/push", str(folder)), {"pandas": pandas})
    assert rounded(capsys.readouterr().out) == rounded(blocks(page, "text")[1])
    assert (folder / "stress.png").exists()


def test_the_example_is_shown_and_prints_what_the_page_shows(page, root, tmp_path):
    printed = subprocess.run([sys.executable, root / "examples/push.py", tmp_path], capture_output=True, text=True, check=True).stdout
    shown = lines(blocks(page, "text")[2])
    assert [rounded(line) for line in shown] == [rounded(line) for line in lines(printed)][: len(shown)]
    source = "\n".join(lines((root / "examples/push.py").read_text()))
    for block in blocks(page, "python"):
        if "read_csv" not in block:
            assert "\n".join(lines(block)) in source, block
    assert (tmp_path / "force.png").exists() and (tmp_path / "liver.vtu").exists()
    pushed, held = map(float, re.search(r"pushed with (\S+) N and held with (\S+) N", printed).groups())
    assert pushed > 0.5 and held == pytest.approx(pushed, rel=0.02)  # without gravity the support carries the push


def test_the_code_of_the_page_of_forces_runs(root, monkeypatch):
    monkeypatch.chdir(root)
    (code,) = blocks((root / "docs/forces.md").read_text(), "python")
    names = {"palpate": palpate}
    exec(code, names)
    assert names["simulation"].metrics.step == 5
    assert np.linalg.norm(names["simulation"].contact_forces[1]) > 0.0


def test_pictures_of_the_page_are_there(page, root):
    for picture in re.findall(r"!\[.*?\]\((.*?)\)", page):
        assert ((root / PAGE).parent / picture).exists()
