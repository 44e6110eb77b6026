"""detect(): contacts of one configuration."""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _core
from ._arrays import Indices
from ._error import Error
from ._names import Structure
from ._world import World

Rows = NDArray[np.intp]


def _pieces(tets: Indices, count: int) -> Indices:
    """For each point the number of the connected piece that it is in, counted by their lowest points."""
    label = np.arange(count, dtype=np.int32)
    while True:  # each round joins the points of each tet, and shortens paths to the lowest point
        lowest = label[tets].min(axis=1)
        joined = label.copy()
        np.minimum.at(joined, label[tets].ravel(), np.repeat(lowest, 4))
        joined = joined[joined]
        if np.array_equal(joined, label):
            return label
        label = joined


def _bodies_of_tets(body: ArrayLike | None, tets: Indices, count: int) -> Indices:
    if body is None:
        pieces = _pieces(tets, count)[tets[:, 0]] if len(tets) else np.zeros(0, np.int32)
        return np.unique(pieces, return_inverse=True)[1].astype(np.int32)
    numbers = _arrays.indices(body, "body", len(tets))
    if numbers.size > 0 and numbers.min() < 0:
        raise Error("body", f"tet {int(numbers.argmin())}", f"body {numbers.min()}", "numbers from 0")
    return numbers


def _owners(tets: Indices, bodies: Indices, count: int) -> Indices:
    """The body of each point, -1 where no tet uses it. Two bodies cannot have a common point."""
    owner = np.full(count, -1, np.int32)
    owner[tets.ravel()] = np.repeat(bodies, 4)
    shared = np.flatnonzero((owner[tets] != bodies[:, None]).any(axis=1))
    if shared.size > 0:
        tet = int(shared[0])
        point = int(tets[tet][owner[tets[tet]] != bodies[tet]][0])
        raise Error("body", f"tet {tet}", f"point {point} in body {bodies[tet]} and in body {owner[point]}",
                    "points that belong to one body: give each body its own points")
    return owner


def _rows_by(labels: Indices, numbers: Indices) -> list[Rows]:
    """For each number (ascending) the rows with that label, ascending."""
    order = np.argsort(labels, kind="stable")
    begin = np.searchsorted(labels[order], numbers, side="left")
    end = np.searchsorted(labels[order], numbers, side="right")
    return [order[first:last] for first, last in zip(begin, end)]


def detect(
    points: ArrayLike,
    tets: ArrayLike,
    body: ArrayLike | None = None,
    *,
    self_collision: bool = False,
    structure: Structure | None = None,
    cells_per_primitive: int | None = None,
    threads: int | None = None,
) -> _core.Contacts:
    """The contacts among bodies of tets: the points in tets of other bodies, with depth and direction.

    points: (n, 3) positions, m. tets: (m, 4) point indices.
    body: (m,) the body of each tet, numbers from 0; None takes each connected piece as a body.
    self_collision: whether bodies can be in contact with themselves.
    structure, cells_per_primitive, threads: as for World.

    Two bodies that overlap without a point of one in the other (bars that cross) have no such contacts: a UserWarning
    names them; World.edge_contacts has the edges that pass through. Another one says that cells_per_primitive left out
    cells, so that contacts may be missing.

    Returns Contacts in the numbers of `points`, `tets` and `body`. The given shape is the shape at rest; for bodies
    that deform from frame to frame use World. O((n + m) log n + contacts). Raises Error on bad input: an index
    out of range, a flat tet, a number that is not finite, a common point of two bodies.
    """
    positions, corners = _arrays.points(points, "points"), _arrays.tets(tets, "tets")
    count = len(positions)
    if len(corners) == 0:
        raise Error("tets", "", "no tets", "at least one tet")
    outside = np.flatnonzero(((corners < 0) | (corners >= count)).any(axis=1))
    if outside.size > 0:
        tet = int(outside[0])
        wrong = corners[tet][(corners[tet] < 0) | (corners[tet] >= count)][0]
        raise Error("tets", f"tet {tet}", f"point index {wrong}", f"0 to {count - 1}")
    bodies_of_tets = _bodies_of_tets(body, corners, count)
    owner = _owners(corners, bodies_of_tets, count)
    world = World(structure=structure, cells_per_primitive=cells_per_primitive, threads=threads)
    numbers = np.unique(bodies_of_tets).astype(np.int32)
    points_of, tets_of = _rows_by(owner, numbers), _rows_by(bodies_of_tets, numbers)
    local = np.empty(count, np.int32)
    for number, own_points, own_tets in zip(numbers, points_of, tets_of):
        local[own_points] = np.arange(len(own_points))
        try:
            world.add(positions[own_points], local[corners[own_tets]], name=f"body {number}",
                      self_collision=self_collision)
        except Error as error:
            raise _in_given_numbers(error, own_points, own_tets) from None
    new_points = np.concatenate(points_of).astype(np.int32)
    new_tets = np.concatenate(tets_of).astype(np.int32)
    world.update(positions[new_points])
    _warn_of_missing(world, numbers)
    return _core.renumbered(world.contacts, new_points, new_tets, numbers)


def _warn_of_missing(world: World, numbers: Indices) -> None:
    """Warns where bodies overlap although no contact says so. numbers: the given number of each body."""
    points, edges, body_of = world.contacts, world.edge_contacts, world.bodies.body_of_point
    count = len(numbers)

    def pairs(first: Indices, second: Indices) -> NDArray[np.int64]:
        return np.minimum(first, second).astype(np.int64) * count + np.maximum(first, second)

    of_edges = pairs(body_of[world.bodies.edges[edges.edge, 0]], edges.body)
    alone = of_edges[~np.isin(of_edges, pairs(body_of[points.point], points.body))]
    if alone.size > 0:
        first, second = numbers[alone[0] // count], numbers[alone[0] % count]
        more = len(np.unique(alone)) - 1
        others = f", and so do {more} other pairs of bodies" if more > 1 else ", and so does another pair" if more else ""
        who = f"bodies {first} and {second} overlap" if first != second else f"body {first} overlaps itself"
        warnings.warn(f"{who} without a point in a tet{others}: edges pass through in {alone.size} places, which "
                      "World.edge_contacts has", stacklevel=3)
    if world.stats.dropped_cells > 0:
        warnings.warn(f"contacts may be missing: cells_per_primitive left out {world.stats.dropped_cells} cells", stacklevel=3)


def _in_given_numbers(error: Error, points: Rows, tets: Rows) -> Error:
    """Converts an error about a tet or point of a body to indices of the whole arrays."""
    what, _, number = error.where.partition(" ")
    known = {"tet": tets, "point": points}.get(what)
    if known is None or not number.isdigit():
        return error
    return Error(error.source, f"{what} {known[int(number)]}", error.found, error.expected)
