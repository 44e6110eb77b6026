"""Scenes, and models that are built in code."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _core
from ._bodies import number_of
from ._error import Error, shown
from ._settings import scene_text


def read_scene(scene: str | os.PathLike[str]) -> dict[str, Any]:
    """A scene file as a mapping with all settings; docs/scene.md lists the keys.

    Paths of mesh files are made absolute, so that the mapping can be changed, saved elsewhere, and given to Simulation,
    World.from_scene() and sweep(). Raises Error if it is no scene.
    """
    return scene_dict(scene_of(scene))


def write_scene(scene: Mapping[str, Any], file: str | os.PathLike[str]) -> None:
    """Writes a scene as JSON, after the same checks as reading one. Raises Error, and writes nothing, on a bad one."""
    path = _arrays.path(file, "file")
    text = scene_of(scene).text
    beside = f"{path}.{os.getpid()}.part"
    with open(beside, "w", encoding="utf-8") as stream:
        stream.write(text)
    os.replace(beside, path)


def stacking_scene(count: int = 20, cells: tuple[int, int, int] = (10, 10, 1), seed: int = 1) -> dict[str, Any]:
    """The paper's stacking scene as a mapping: membranes that fall onto each other; the lowest one is an obstacle.

    count: membranes. cells: of each along x, y and z, five tets a cell. seed: of their small shifts and rotations.
    """
    return scene_dict(_core.stacking_scene(count, cells, seed))


def scene_dict(scene: _core.Scene) -> dict[str, Any]:
    """A scene as a mapping with absolute paths; no name is added."""
    values: dict[str, Any] = json.loads(scene.text)
    for body in values["bodies"]:
        if "mesh" in body:
            body["mesh"] = os.path.abspath(os.path.join(scene.folder, body["mesh"]))
    return values


def scene_of(scene: str | os.PathLike[str] | Mapping[str, Any]) -> _core.Scene:
    """The checked scene of a file or a mapping."""
    if isinstance(scene, (str, os.PathLike)):
        return _core.Scene.read(os.fspath(scene))
    if isinstance(scene, Mapping):
        return _core.Scene.parse(scene_text(scene, "scene"), "scene")
    raise Error("scene", "", shown(scene), "the path of a scene file, or a mapping")


class Model(_core.Model):
    """A model built in code: bodies, materials, constraints, motions and loads.

    Model() is empty; Model.from_scene() has the bodies of a scene, and more can be added.
    """

    def __repr__(self) -> str:
        bodies = self.bodies
        return f"<palpate.Model: {len(bodies)} bodies, {len(bodies.body_of_point)} points, {len(bodies.tets)} tets>"

    @classmethod
    def from_scene(cls, scene: str | os.PathLike[str] | Mapping[str, Any]) -> Model:
        """The bodies of a scene, a file or a mapping, without its settings."""
        return cls(scene_of(scene))

    def add_body(
        self,
        points: ArrayLike,
        tets: ArrayLike,
        *,
        name: str | None = None,
        material: _core.Material | None = None,
        fixed: ArrayLike = (),
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        angular_velocity: ArrayLike = (0.0, 0.0, 0.0),
        gravity: ArrayLike | None = None,
        obstacle: bool = False,
        motion: _core.Motion | None = None,
        self_collision: bool = False,
    ) -> int:
        """Adds a body; returns its number.

        points: (n, 3) positions at the start, at rest, m. tets: (m, 4) indices of its own points, from 0.
        material: needed unless the body is rigid.
        fixed: points that do not move, as indices or as a mask (n); or a mask (n, 3) of the axes of the world along which
            each point does not move: rollers, planes of symmetry.
        velocity: of its free points at the start, (3) or (n, 3), m/s. angular_velocity: in addition, about the
            centre of its volume (its centre of mass, unless regions have other densities), rad/s. gravity: replaces that
            of the simulation, m/s^2. Both velocities only of a body that deforms.
        obstacle: rigid, moves only by its motion. motion: prescribed motion; makes it rigid.
        self_collision: whether the body can be in contact with itself.
        Raises Error, and adds nothing, on a bad mesh or value.
        """
        label = f"body {len(self.bodies)}" if name is None else name
        positions = _arrays.points(points, "points")
        axes = self._fixed_axes(fixed, len(positions))
        corners = _arrays.tets(tets, "tets")
        velocities = self._velocities(positions, corners, velocity, angular_velocity)
        own_gravity = None if gravity is None else _arrays.finite_vector(gravity, "gravity")
        rigid = obstacle or motion is not None
        if rigid and velocities.any():
            raise Error("Model.add_body", "velocity", "a velocity of a rigid body", "a body that deforms: a motion moves a rigid one")
        if rigid and self_collision:
            raise Error("Model.add_body", "self_collision", "True for a rigid body", "False: a rigid body has one shape")
        body = self._add_body(
            label, positions, corners, material, (0.0, 0.0, 0.0), axes, obstacle, self_collision, motion
        )
        if velocities.any():
            self._set_velocities(body, velocities)
        if own_gravity is not None:
            self._set_gravity(body, own_gravity)
        return body

    @staticmethod
    def _fixed_axes(fixed: ArrayLike, count: int) -> NDArray[np.uint8]:
        """For each point the sum of 1 (x), 2 (y) and 4 (z)."""
        flags = np.asarray(fixed)
        if flags.dtype == np.bool_ and flags.ndim == 2:
            if flags.shape != (count, 3):
                raise Error("fixed", "", f"a mask of shape {flags.shape}", f"shape ({count},) or ({count}, 3), or indices")
            bits: NDArray[np.uint8] = (flags @ np.array([1, 2, 4])).astype(np.uint8)
            return bits
        axes = np.zeros(count, np.uint8)
        axes[_arrays.selection(fixed, "fixed", count)] = 7
        return axes

    @staticmethod
    def _velocities(
        positions: _arrays.Floats, tets: _arrays.Indices, velocity: ArrayLike, angular_velocity: ArrayLike
    ) -> _arrays.Floats:
        """Velocity of each point: one for all or one for each, plus a rotation about the centre of volume."""
        each = _arrays.reals(_arrays.array_of(velocity, "velocity"), "velocity")
        if each.shape == (3,):
            each = np.broadcast_to(each, positions.shape)
        if each.shape != positions.shape:
            raise Error("velocity", "", f"an array of shape {each.shape}", f"shape (3,) or {positions.shape}")
        spin = np.array(_arrays.vector(angular_velocity, "angular_velocity"))
        if spin.any() and len(tets) > 0 and tets.min() >= 0 and tets.max() < len(positions):  # else the mesh is refused
            corners = positions[tets]
            volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
            each = each + np.cross(spin, positions - volumes @ corners.mean(axis=1) / max(volumes.sum(), 1e-300))
        if not np.isfinite(each).all():
            raise Error("velocity", "", "a number that is not finite", "finite numbers")
        return np.ascontiguousarray(each)

    def add_region(self, body: int | str, tets: ArrayLike, material: _core.Material) -> None:
        """Gives tets of a body (indices in the body, or a mask) another material; the last one holds."""
        number = self._soft(body, "Model.add_region")
        self._add_region(number, self._selection(number, tets, "tets"), material)

    def set_fibres(self, body: int | str, directions: ArrayLike) -> None:
        """Directions of fibres in each tet of a body, (n_tets, 3) of any length, at rest.

        They replace Fibres.direction of the body's materials; a row of zeros keeps that of the material.
        """
        number = self._soft(body, "Model.set_fibres")
        self._set_fibres(number, _arrays.points(directions, "directions"))

    def set_fibres_between(self, body: int | str, start: ArrayLike, end: ArrayLike) -> None:
        """Lets the fibres of a body run from some of its points to others (indices in the body, or masks), also along
        bends: like those of a muscle between its attachments.

        Directions are the gradient of the harmonic function that is 0 at the points of start and 1 at those of end.
        """
        number = self._soft(body, "Model.set_fibres_between")
        self._set_fibres_between(number, self._selection(number, start, "points"), self._selection(number, end, "points"))

    def attach(self, body: int | str, points: ArrayLike, to: int | str, *, stiffness: float | None = None) -> None:
        """Attaches points of a body (indices in the body, or a mask) to another body: glued to one with a motion
        (tissue on a bone), or tied by springs to a deformable one, each to the nearest tet at the start.

        stiffness: of each spring, N/m; None: that of a contact between the two. Points with springs of at least this
        stiffness do not touch the other body.
        """
        number = self._soft(body, "Model.attach")
        self._attach(number, self._selection(number, points, "points"), number_of(to, self.bodies, "Model"), stiffness)

    def prescribe(self, body: int | str, points: ArrayLike, motion: _core.Motion) -> int:
        """Moves points of a deformable body (indices in the body, or a mask) by a motion of their own; returns its
        number, for Simulation.move_prescribed() and similar functions.
        """
        number = self._soft(body, "Model.prescribe")
        return self._prescribe(number, self._selection(number, points, "points"), motion)

    def load(self, body: int | str, points: ArrayLike, force: ArrayLike, *, ramp: _core.Ramp | None = None) -> None:
        """A force, N, shared equally by points of a body (indices or a mask, in its own numbers), times the ramp's factor;
        loads add up.
        """
        number = self._soft(body, "Model.load")
        self._load(number, self._selection(number, points, "points"), _arrays.finite_vector(force, "force"), ramp)

    def load_surface(
        self,
        body: int | str,
        points: ArrayLike,
        *,
        pressure: float = 0.0,
        traction: ArrayLike = (0.0, 0.0, 0.0),
        ramp: _core.Ramp | None = None,
    ) -> None:
        """Loads the surface triangles of a body all of whose corners are among these points (indices or a mask, in its own
        numbers).

        pressure: Pa, against the outward normal; follows the surface. traction: Pa, per area at rest; keeps its direction.
        ramp: times its factor. Exactly one of pressure and traction is given.
        """
        number = self._soft(body, "Model.load_surface")
        chosen = self._selection(number, points, "points")
        force = _arrays.finite_vector(traction, "traction")
        if (pressure != 0.0) == any(force):
            raise Error("Model.load_surface", "", "both pressure and traction" if pressure != 0.0 else "neither pressure nor traction",
                        "exactly one of the two")
        self._load_surface(number, chosen, pressure, force, ramp)

    def grab(self, body: int | str, point: int, target: ArrayLike, stiffness: float) -> None:
        """A critically damped spring, N/m, from a point of a body (index in the body) to a position in space, m. It
        becomes one of Simulation.grabs.
        """
        number = self._soft(body, "Model.grab")
        self._grab(number, point, _arrays.finite_vector(target, "target"), stiffness)

    def _soft(self, body: int | str, what: str) -> int:
        """The number of a body that deforms."""
        number = number_of(body, self.bodies, "Model")
        if self._is_rigid(number):
            raise Error(what, "body", f"the rigid body '{self.bodies[number].name}'", "a body that deforms")
        return number

    def _selection(self, number: int, chosen: ArrayLike, what: str) -> _arrays.Indices:
        body = self.bodies[number]
        rows = body.points if what == "points" else body.tets
        return _arrays.selection(chosen, what, rows.stop - rows.start)
