"""Plates that fit into the hole of a broken orbital floor: elliptic discs of tets. Lengths in mm."""

import numpy as np

THICKNESS = 0.5
RINGS, SECTORS = 6, 30


class Heights:
    """Heights at places: bilinear between those over the middles of columns, of which row and column 0 is at `origin`."""

    def __init__(self, heights, known, origin, edge):
        self.heights, self.origin, self.edge = np.where(known, heights, np.nan), origin, edge

    def __call__(self, places):
        u, w = ((places - self.origin) / self.edge).T
        i, j = np.floor(u).astype(int), np.floor(w).astype(int)
        a, b, h = u - i, w - j, self.heights
        found = (1 - b) * ((1 - a) * h[j, i] + a * h[j, i + 1]) + b * ((1 - a) * h[j + 1, i] + a * h[j + 1, i + 1])
        assert np.isfinite(found).all(), "a plate is larger than the floor"
        return found


def ellipse(centre, radii):
    """Points and triangles of an ellipse: rings of points, each turned by half a sector against the one before."""
    points = [(0.0, 0.0)]
    for ring in range(1, RINGS + 1):
        turn = 2.0 * np.pi * (np.arange(SECTORS) + 0.5 * ring) / SECTORS
        points += list(ring / RINGS * np.stack([np.cos(turn), np.sin(turn)], -1))

    def at(ring, sector):
        return 1 + (ring - 1) * SECTORS + sector % SECTORS

    triangles = [(0, at(1, s), at(1, s + 1)) for s in range(SECTORS)]
    for r in range(1, RINGS):
        for s in range(SECTORS):
            triangles += [(at(r, s), at(r + 1, s - 1), at(r + 1, s)), (at(r, s), at(r + 1, s), at(r, s + 1))]
    return np.array(centre) + np.array(points) * radii, np.sort(np.array(triangles), axis=1)


def plate(floor, shape, centre, radii):
    """Points and tets of a plate whose upper side is the floor ("bent"), or the plane that is nearest to it there ("flat")."""
    places, triangles = ellipse(centre, radii)
    top = floor(places)
    if shape == "flat":
        terms = np.column_stack([np.ones(len(places)), places])
        top = terms @ np.linalg.lstsq(terms, top, rcond=None)[0]
    n = len(places)
    points = np.concatenate([np.column_stack([places, top - THICKNESS]), np.column_stack([places, top])])
    # Corners of each triangle are in increasing order: so neighbours divide the quads between them in the same way.
    a, b, c = triangles.T
    tets = np.concatenate([np.stack(t, -1) for t in ((a, b, c, c + n), (a, b, b + n, c + n), (a, a + n, b + n, c + n))])
    p, q, r, s = (points[tets[:, k]] for k in range(4))
    flipped = np.einsum("ij,ij->i", np.cross(q - p, r - p), s - p) < 0
    tets[flipped] = tets[flipped][:, [1, 0, 2, 3]]
    return points, tets
