"""The examples run, and the tutorial and README show their code and output."""

import os
import pathlib
import re
import subprocess
import sys
import tomllib

import pytest

import palpate

EXAMPLES = ["detect", "world", "simulate", "study"]


OPTIONAL = ["cloudpickle", "dask", "distributed", "matplotlib", "meshio", "pandas", "pyvista", "tqdm"]


@pytest.fixture(scope="session")
def base_install(tmp_path_factory):
    """A folder in which importing the packages of extras fails."""
    absent = tmp_path_factory.mktemp("absent")
    for name in OPTIONAL:
        (absent / f"{name}.py").write_text(f"raise ImportError('no {name}')\n")
    return {**os.environ, "PYTHONPATH": f"{absent}:{os.environ['PYTHONPATH']}"}


@pytest.fixture(scope="session")
def outputs(root, base_install, tmp_path_factory):
    """The output of each example with the base install."""
    folder = tmp_path_factory.mktemp("study")

    def run(name, *arguments):
        return subprocess.run([sys.executable, root / f"examples/{name}.py", *arguments], capture_output=True, text=True,
                              check=True, env=base_install).stdout

    return {name: run(name, *([folder] if name == "study" else [])) for name in EXAMPLES}


def test_all_examples_are_run(root):
    assert sorted(file.stem for file in (root / "examples").glob("*.py")) == sorted([*EXAMPLES, "push", "orbit_study"])  # test_push.py, test_orbit.py


def test_an_example_that_needs_an_extra_says_so_in_one_line(root, base_install):
    done = subprocess.run([sys.executable, root / "examples/push.py"], capture_output=True, text=True, env=base_install)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == "push.py: no matplotlib; what it needs: pip install 'palpate[plot,view]'\n"
    extras = tomllib.loads((root / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    assert "matplotlib" in extras["plot"] and "pyvista" in extras["view"]
    assert {"matplotlib", "pyvista"} <= set(extras["all"])


def test_detect_finds_the_lens_of_two_balls(outputs):
    """Two balls of 5 cm whose centres are 82.5 mm apart overlap by 17.5 mm."""
    count, deepest = re.match(r"(\d+) contacts, the deepest (\S+) mm", outputs["detect"]).groups()
    assert int(count) > 50 and float(deepest) == pytest.approx(17.5, rel=0.1)


def test_world_comes_to_rest_on_three_balls(outputs):
    heights = [float(h) for h in re.findall(r"height +(\S+) mm", outputs["world"])]
    assert heights[-1] == pytest.approx(heights[-2], abs=1.0) and heights[-1] > 20
    assert "at rest on 3 balls" in outputs["world"]


def test_simulate_presses_and_pulls(outputs):
    contacts, pressed, pulled = re.search(r"(\d+) contacts, pressed by (\S+) N, pulled by (\S+) N", outputs["simulate"]).groups()
    assert int(contacts) > 20 and float(pressed) > 1 and float(pulled) > 0.1


def test_study_follows_the_plan(outputs):
    rows = [line.split() for line in outputs["study"].splitlines()[1:]]
    assert [row[3] for row in rows] == ["done"] * 6
    tips = [float(row[4]) for row in rows]
    assert all(stiff > soft for soft, stiff in zip(tips[::2], tips[1::2]))  # stiffer tissue sinks less
    assert all(float(row[5]) > 0.5 for row in rows)  # the rod carries some of the bar


def code_blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```", page, re.DOTALL | re.MULTILINE)


def lines(text):
    return [line.strip() for line in text.splitlines() if line.strip()]


@pytest.mark.parametrize("page", ["README.md", "docs/tutorial/README.md"])
def test_pages_show_the_examples_as_they_are(root, page):
    """Each Python block is a run of consecutive lines of an example."""
    sources = ["\n".join(lines(file.read_text())) for file in (root / "examples").glob("*.py")]
    blocks = code_blocks((root / page).read_text(), "python")
    assert blocks
    for block in blocks:
        assert any("\n".join(lines(block)) in source for source in sources), block


def test_the_tutorial_shows_what_the_examples_print(root, outputs):
    """Except the last digits, which differ between processors."""
    def rounded(text):
        return [f"{float(word):.2g}" if re.fullmatch(r"-?\d+\.\d+", word) else word for word in text.split()]

    blocks = code_blocks((root / "docs/tutorial/README.md").read_text(), "text")
    assert len(blocks) == len(EXAMPLES)
    for name, block in zip(EXAMPLES, blocks):
        assert rounded(block) == rounded(outputs[name]), name


def test_pictures_of_the_tutorial_are_there(root):
    page = root / "docs/tutorial/README.md"
    named = re.findall(r"!\[[^\]]*\]\(([^)]+)\)", page.read_text())
    assert len(named) >= 3 and all((page.parent / name).exists() for name in named)


def test_python_blocks_of_the_page_run(root):
    """docs/python.md: all its blocks in order, as one program."""
    page = (root / "docs/python.md").read_text()
    blocks = code_blocks(page, "python")
    assert blocks
    exec(compile("\n".join(blocks), "docs/python.md", "exec"), {"__name__": "page"})
