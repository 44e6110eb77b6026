"""Makes cook.vtu, the mesh of scenes/cook.json: Cook's membrane, 16 x 16 x 1 cells of five tets.

    PYTHONPATH=build/release/python build/venv/bin/python scenes/meshes/cook/make.py
"""

import pathlib

import meshio
import numpy as np

import palpate

CELLS = 16

points, tets = palpate.box((CELLS, CELLS, 1), (1.0, 1.0, 1.0))
x, y, z = (points + 0.5).T
membrane = np.column_stack([48.0 * x, 44.0 * x + y * (44.0 - 28.0 * x), 48.0 / CELLS * z])  # mm
meshio.write(pathlib.Path(__file__).with_name("cook.vtu"), meshio.Mesh(membrane, [("tetra", tets.astype(np.int32))]))
