"""Common parts of the tests: paths of the sources and the command, and small meshes."""

import os
import pathlib

import numpy as np
import pytest

import palpate


@pytest.fixture(scope="session")
def root():
    """The source folder."""
    return pathlib.Path(os.environ["PALPATE_SOURCE_DIR"])


@pytest.fixture(scope="session")
def command():
    """The palpate command of the same build."""
    return os.environ["PALPATE_COMMAND"]


@pytest.fixture
def boxes():
    """Two boxes of 4^3 cells of size 1; the upper one is 0.1 deep in the lower one. Points, tets, body of each tet."""
    points, tets = palpate.box((4, 4, 4), (1.0, 1.0, 1.0))
    both = np.concatenate([points, points + [0.03, 0.02, 0.9]])
    return both, np.concatenate([tets, tets + len(points)]), np.repeat([0, 1], len(tets))
