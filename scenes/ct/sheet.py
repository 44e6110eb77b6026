"""Sheets of tets over a height field: plates and instruments."""

import numpy as np

ODD = [(0, 1, 3, 5), (0, 3, 2, 6), (0, 5, 4, 6), (3, 5, 6, 7), (0, 3, 5, 6)]
EVEN = [(1, 0, 2, 4), (1, 2, 3, 7), (1, 4, 5, 7), (2, 4, 6, 7), (1, 2, 4, 7)]


def sheet(x, y, lower, thickness, holes=()):
    """Points and tets of a sheet over a grid of places, as arrays (rows, columns): cells of five tets, mirrored in alternate cells.
    `holes` are the cells (row, column) that it lacks."""
    rows, columns = x.shape
    points = np.concatenate([np.stack([x, y, lower + h], -1).reshape(-1, 3) for h in (0.0, thickness)])
    tets = []
    for j in range(rows - 1):
        for i in range(columns - 1):
            if (j, i) in holes:
                continue
            c = [(j + b) * columns + i + a + d * columns * rows for d in (0, 1) for b in (0, 1) for a in (0, 1)]
            tets += [[c[k] for k in tet] for tet in (ODD if (i + j) % 2 else EVEN)]
    tets = np.array(tets)
    a, b, c, d = (points[tets[:, k]] for k in range(4))
    flipped = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) < 0
    tets[flipped] = tets[flipped][:, [1, 0, 2, 3]]
    used = np.unique(tets)
    return points[used], np.searchsorted(used, tets)
