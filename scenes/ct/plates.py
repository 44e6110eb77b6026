"""Plates for the floor of an orbit, and the retractor that holds the tissue above each: sheets over a height field, mm."""

import numpy as np

import sheet

SHAPES = ("bent", "preformed")
PLACES = {"planned": (-3.0, 7.0), "forward": (-3.0, 4.0), "lateral": (0.0, 7.0)}  # centres, from that of the bulb
SIZE = (16.0, 18.0)  # along x and y
THICKNESS = 0.5
ABOVE = 0.5  # lower side over the floor: the triangles of a mesh lie a little above a hollow
CELL = 1.2  # about
CLEARANCE = 1.2  # upper side of a retractor over that of the plate
SLOPE = 4.0  # width of the border of a retractor, where it descends
SUNK = 0.6  # depth of its border below the floor
SHEET = 0.6  # thickness
FRONT = -9.0  # y of its front, before the tissue
WALL = 8.0  # at most this high over the middle of the floor


class Floor:
    """Heights at places: bilinear between those known, beyond them those of the nearest known ones."""

    def __init__(self, heights, known, origin, edge):
        self.origin, self.edge = origin, edge
        self.heights = np.where(known, heights, np.nan)
        while np.isnan(self.heights).any():
            padded = np.pad(self.heights, 1, constant_values=np.nan)
            rows, columns = self.heights.shape
            near = np.stack([padded[a:a + rows, b:b + columns] for a in range(3) for b in range(3)])
            count = (~np.isnan(near)).sum(axis=0)
            means = np.nansum(near, axis=0) / np.maximum(count, 1)
            self.heights = np.where(np.isnan(self.heights) & (count > 0), means, self.heights)

    def __call__(self, x, y):
        rows, columns = self.heights.shape
        u = np.clip((x - self.origin[0]) / self.edge, 0.0, columns - 1.001)
        w = np.clip((y - self.origin[1]) / self.edge, 0.0, rows - 1.001)
        i, j = u.astype(int), w.astype(int)
        a, b, h = u - i, w - j, self.heights
        return (1 - b) * ((1 - a) * h[j, i] + a * h[j, i + 1]) + b * ((1 - a) * h[j + 1, i] + a * h[j + 1, i + 1])


def smooth_step(t):
    s = np.clip(t, 0.0, 1.0)
    return s * s * (3.0 - 2.0 * s)


def grid(lower, upper):
    """Places in rows along x, about CELL apart."""
    counts = [int(round((b - a) / CELL)) + 1 for a, b in zip(lower, upper)]
    return np.meshgrid(*(np.linspace(a, b, n) for a, b, n in zip(lower, upper, counts)))


class Plate:
    """bent: follows the floor of this patient. preformed: the quadratic surface that is nearest to the floor, raised until it is nowhere
    below it, as a plate from a set of standard shapes."""

    def __init__(self, floor, shape, centre):
        self.floor, self.centre = floor, np.array(centre)
        self.lower, self.upper = self.centre - np.divide(SIZE, 2), self.centre + np.divide(SIZE, 2)
        self.fit, self.raised = None, ABOVE
        if shape == "preformed":
            x, y = grid(self.lower, self.upper)
            heights = floor(x, y)
            self.fit = np.linalg.lstsq(self.terms(x, y), heights.ravel(), rcond=None)[0]
            self.raised += (heights - self.bottom(x, y) + ABOVE).max()

    def terms(self, x, y):
        u, w = (x - self.centre[0]).ravel(), (y - self.centre[1]).ravel()
        return np.stack([np.ones_like(u), u, w, u * u, u * w, w * w], -1)

    def bottom(self, x, y):
        return self.raised + (self.floor(x, y) if self.fit is None else (self.terms(x, y) @ self.fit).reshape(x.shape))

    def mesh(self):
        x, y = grid(self.lower, self.upper)
        return sheet.sheet(x, y, self.bottom(x, y), THICKNESS)

    def retractor(self):
        """Holds the tissue CLEARANCE above the plate and in front of it, and descends into the floor beside and behind it."""
        x, y = grid((self.lower[0] - SLOPE, FRONT), self.upper + SLOPE)
        u, w = np.clip(x, self.lower[0], self.upper[0]), np.clip(y, self.lower[1], self.upper[1])
        rise = self.bottom(u, w) + THICKNESS + CLEARANCE - self.floor(u, w)
        kept = smooth_step(1.0 - np.abs(x - u) / SLOPE) * smooth_step(1.0 - np.maximum(y - w, 0.0) / SLOPE)
        top = self.floor(x, y) - SUNK + kept * (rise + SUNK)
        top = np.minimum(top, self.floor(np.full_like(x, self.centre[0]), y) + WALL)
        return sheet.sheet(x, y, top - SHEET, SHEET)
