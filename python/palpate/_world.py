"""Contacts at positions of the caller: World for a sequence of frames."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _core
from ._error import Error, shown
from ._names import CellSizeRule, Order, Sort, Structure
from ._scene import Model, scene_of
from ._settings import settings, threads_or_default

if TYPE_CHECKING:
    import pyvista


def _detection(**values: Any) -> _core.Scene:
    """Settings of detection: those that are not None."""
    given = {name: value for name, value in values.items() if value is not None}
    return settings("detection", {"contact": given})


def _pairs_of(array: NDArray[Any], count: int) -> list[tuple[int, int]]:
    """Pairs of bodies from a square array of truth values, or from rows of two numbers."""
    if array.size == 0:
        return []
    if array.dtype == np.bool_ and array.shape == (count, count):
        return [(int(a), int(b)) for a, b in zip(*np.nonzero(np.triu(array | array.T, 1)))]
    if array.ndim == 2 and array.shape[1] == 2 and array.dtype.kind in "iu":
        return [(int(a), int(b)) for a, b in array]
    raise Error("ignored", "", f"an array of shape {array.shape} and type {array.dtype}",
                f"pairs of body numbers, or truth values of shape ({count}, {count})")


class World(_core.World):
    """Bodies of tets whose contacts are detected frame by frame, for programs that move the bodies themselves.

    Add the bodies once, then give all points to update() in each frame. The contacts equal those of exact arithmetic and
    have the same bits for every structure, order, sort and number of threads. A world keeps data of the last frame, so
    that frames with little motion are faster.

    structure: "compact" (the default), "uniform", "hash", "cuckoo" or "brute", the spatial structure.
    order, sort, cell_size: see docs/scene.md, `contact.order` and so on.
    cells_per_primitive: 1 to 27 for the approximate mode, which may miss contacts and counts what it left out.
    edge_contacts: False leaves out edges that pass through a body with both ends outside (docs/edges.md).
    coherence: False uses no data of earlier frames; the contacts are the same.
    budget: limit of the cost of an update, {"tests": N} or {"milliseconds": T} (docs/budget.md). If it does not
    suffice, contacts are missed, and stats.completeness and late_bodies say so.
    threads: number of threads, 0 for all cores; None takes what set_threads() says.
    """

    def __init__(
        self,
        *,
        structure: Structure | None = None,
        order: Order | None = None,
        sort: Sort | None = None,
        cell_size: CellSizeRule | float | None = None,
        cells_per_primitive: int | None = None,
        edge_contacts: bool | None = None,
        coherence: bool | None = None,
        budget: Mapping[str, Any] | None = None,
        threads: int | None = None,
    ) -> None:
        found = _detection(
            structure=structure, order=order, sort=sort, cell_size=cell_size,
            cells_per_primitive=cells_per_primitive, edge_contacts=edge_contacts, coherence=coherence,
            budget=budget,
        )
        super().__init__(found, threads_or_default(threads))

    def __repr__(self) -> str:
        bodies = self.bodies
        try:
            found = f"{len(self.contacts)} contacts"
        except Error:
            found = "no update() yet"
        return f"<palpate.World: {len(bodies)} bodies, {len(bodies.body_of_point)} points, {found}>"

    @classmethod
    def from_scene(cls, scene: str | os.PathLike[str] | Mapping[str, Any], *, threads: int | None = None) -> World:
        """The bodies of a scene, a file or a mapping, at the start of a run: update() has been called."""
        read = scene_of(scene)
        model = Model(read)
        world = cls.__new__(cls)
        _core.World.__init__(world, read, threads_or_default(threads))
        bodies = model.bodies
        points, tets = bodies.points_rest, bodies.tets
        for number, obstacle in enumerate(model.obstacles):
            body = bodies[number]
            corners = tets[body.tets] - body.points.start
            world._add(body.name, points[body.points], corners, not obstacle, bool(model.self_collision[number]))
        world._update(model.start_positions())
        return world

    def add(
        self,
        points: ArrayLike,
        tets: ArrayLike,
        *,
        name: str | None = None,
        movable: bool = True,
        self_collision: bool = False,
    ) -> int:
        """Adds a body; returns its number. The first update() after it takes longer.

        points: (n, 3) rest positions, m. tets: (m, 4) indices of its own points, from 0.
        movable: contacts between two bodies that are not movable are not detected.
        self_collision: whether the body also touches itself.
        Raises Error, and adds nothing, on a bad mesh: an index out of range, a flat tet, a number that is not finite.
        """
        label = f"body {len(self.bodies)}" if name is None else name
        return self._add(
            label, _arrays.points(points, "points"), _arrays.tets(tets, "tets"), bool(movable), bool(self_collision)
        )

    def set_pair_filter(self, ignored: Callable[[int, int], bool] | ArrayLike | Iterable[tuple[int, int]]) -> None:
        """Sets the pairs of bodies that are not tested against each other, from the next update() on.

        ignored: a function of two bodies (a < b), an (n_bodies, n_bodies) array of truth values, or pairs of bodies.
        """
        count = len(self.bodies)
        if callable(ignored):
            pairs = [(a, b) for a in range(count) for b in range(a + 1, count) if ignored(a, b)]
        else:
            if not isinstance(ignored, Iterable):
                raise Error("ignored", "", shown(ignored), "a function, an array or pairs of bodies")
            values: Any = ignored if hasattr(ignored, "__array__") else list(ignored)
            pairs = _pairs_of(np.asarray(values), count)
        self._set_ignored_pairs([[a, b] for a, b in pairs])

    def update(self, positions: ArrayLike | Sequence[ArrayLike]) -> None:
        """Finds all contacts at the positions of all points, (n_points, 3) in the order of the bodies.

        positions: an array (float64 in C order is not copied), or a list with the (n, 3) array of each body. Other
        Python threads run meanwhile and must not change the array. Raises Error on another number of points and on
        numbers that are not finite; the results of the last update() then stay.
        """
        try:
            self._update(positions)  # type: ignore[arg-type]
        except TypeError:
            if isinstance(positions, (list, tuple)) and positions and np.ndim(positions[0]) == 2:
                counts = np.bincount(self.bodies.body_of_point, minlength=len(self.bodies)).tolist()
                self._update(_arrays.joined(positions, "positions", counts))
            else:
                self._update(_arrays.points(cast(ArrayLike, positions), "positions"))

    def to_pyvista(self, positions: ArrayLike) -> pyvista.UnstructuredGrid:
        """All bodies at these positions as a grid of pyvista, with `body` and the depth of contacts at the points."""
        from ._view import grid_of

        return grid_of(_arrays.points(positions, "positions"), self.bodies, self.contacts)
