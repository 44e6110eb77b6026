"""The bodies of a simulation, with their forces and motions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from . import _arrays, _core
from ._error import Error

if TYPE_CHECKING:
    from ._simulation import Simulation


class SimulationBody:
    """A body of a simulation: simulation.bodies["probe"]. Points and triangles are indices in the body, from 0."""

    def __init__(self, simulation: Simulation, number: int) -> None:
        self._simulation = simulation
        self._number = number
        self._body = simulation._bodies[number]

    def __repr__(self) -> str:
        points, tets = self.points, self.tets
        return f"<palpate.SimulationBody '{self.name}': {points.stop - points.start} points, {tets.stop - tets.start} tets>"

    def __reduce__(self) -> NoReturn:
        raise TypeError("a palpate.SimulationBody cannot be pickled or copied: it belongs to its simulation")

    @property
    def name(self) -> str:
        """Its name."""
        return self._body.name

    @property
    def number(self) -> int:
        """Its number, from 0."""
        return self._number

    @property
    def points(self) -> slice:
        """Its points among those of all bodies."""
        return self._body.points

    @property
    def edges(self) -> slice:
        """Its edges among those of all bodies."""
        return self._body.edges

    @property
    def triangles(self) -> slice:
        """Its surface triangles among those of all bodies."""
        return self._body.triangles

    @property
    def tets(self) -> slice:
        """Its tets among those of all bodies."""
        return self._body.tets

    @property
    def positions(self) -> _arrays.Floats:
        """(n, 3) positions of its points, m."""
        return self._simulation.positions[self.points]

    @property
    def velocities(self) -> _arrays.Floats:
        """(n, 3) velocities of its points, m/s."""
        return self._simulation.velocities[self.points]

    @property
    def mass(self) -> float:
        """Its mass, kg."""
        return float(self._simulation.masses[self._number])

    @property
    def center_of_mass(self) -> _arrays.Floats:
        """(3) current centre of mass, m."""
        return self._simulation.center_of_mass(self._number)

    def move_to(self, pose: ArrayLike | _core.Keyframe, quaternion: ArrayLike | None = None) -> None:
        """Puts a body with a motion at a pose by the end of the next step: Simulation.move_to()."""
        self._simulation.move_to(self._number, pose, quaternion)

    @property
    def is_present(self) -> bool:
        """Whether it is present: neither absent at the start nor removed."""
        return self._simulation._is_present(self._number)

    @property
    def is_rigid(self) -> bool:
        """Whether it is rigid: an obstacle or a body with a motion, until it is released."""
        return self._simulation._is_rigid(self._number)

    def release(self, points: ArrayLike | None = None) -> None:
        """Frees its points (indices or a mask; None: all of them) from all constraints and motions; they keep their
        velocity. A rigid body can only be released as a whole: it deforms from then on.
        """
        if points is None:
            self._simulation._release_body(self._number)
        else:
            self._simulation._release_points(self._of_all(points))

    def fix(self, points: ArrayLike | None = None) -> None:
        """Fixes its points (indices or a mask; None: all of them) at their current positions until release(). Not of a
        rigid body: move() with a motion of one keyframe lets it stand still.
        """
        self._simulation._fix(self._of_all(points))

    def move(self, motion: _core.Motion, points: ArrayLike | None = None) -> int:
        """Lets its points (indices or a mask; None: all of them) follow a motion from their current positions; its times
        are simulation times. Returns its number, for Simulation.move_prescribed() and similar functions.
        """
        return self._simulation._move(self._of_all(points), motion)

    def remove(self) -> None:
        """Removes it: Simulation.remove()."""
        self._simulation.remove(self._number)

    def insert(self) -> None:
        """Inserts it: Simulation.insert()."""
        self._simulation.insert(self._number)

    def set_motion(self, motion: _core.Motion) -> None:
        """Replaces the motion of the body: Simulation.set_motion()."""
        self._simulation.set_motion(self._number, motion)

    def set_positions(self, positions: ArrayLike, points: ArrayLike | None = None) -> None:
        """Sets positions of its points (indices or a mask; None: all of them), (n, 3), m: Simulation.set_positions()."""
        self._simulation.set_positions(positions, self._of_all(points))

    def set_velocities(self, velocities: ArrayLike, points: ArrayLike | None = None) -> None:
        """Sets velocities of its points (indices or a mask; None: all that are neither fixed nor prescribed), (n, 3) or
        (3) for all, m/s: Simulation.set_velocities().
        """
        if points is not None:
            return self._simulation.set_velocities(velocities, self._of_all(points))
        movable = self._simulation._movable()
        chosen = movable[(movable >= self.points.start) & (movable < self.points.stop)]
        return self._simulation.set_velocities(_arrays.rows(velocities, "velocities", chosen, self.points), chosen)

    @property
    def prescribed(self) -> list[int]:
        """Numbers of the motions of its prescribed points, in the order of the scene or of Model.prescribe(): for
        Simulation.set_prescribed() and similar functions.
        """
        return self._simulation._prescribed_of(self._number)

    def set_forces(self, forces: ArrayLike, points: ArrayLike | None = None) -> None:
        """Loads its points (indices or a mask; None: all of them) with forces, (n, 3) or (3) for each, N:
        Simulation.set_forces().
        """
        self._simulation.set_forces(self._of_all(points), forces)

    def set_pressure(self, pressure: ArrayLike, triangles: ArrayLike | None = None) -> None:
        """Loads its surface triangles (indices or a mask; None: all of them) with a pressure, one number or (n), Pa:
        Simulation.set_pressure().
        """
        rows = self.triangles
        chosen = np.arange(rows.start, rows.stop, dtype=np.int32)
        if triangles is not None:
            chosen = chosen[_arrays.selection(triangles, "triangles", len(chosen))]
        self._simulation.set_pressure(chosen, pressure)

    def contact_wrench(self, about: ArrayLike | None = None) -> _core.Wrench:
        """Force and torque on it by contacts during the last step: Simulation.contact_wrench()."""
        return self._simulation.contact_wrench(self._number, about)

    def reaction(self, about: ArrayLike | None = None) -> _core.Wrench:
        """Reaction at its fixed or prescribed points during the last step: Simulation.reaction()."""
        return self._simulation.reaction(self._number, about)

    def tie_wrench(self, about: ArrayLike | None = None) -> _core.Wrench:
        """Force and torque on it by its ties during the last step: Simulation.tie_wrench()."""
        return self._simulation.tie_wrench(self._number, about)

    def grab_wrench(self, about: ArrayLike | None = None) -> _core.Wrench:
        """Force and torque on it by grabs of its points during the last step: Simulation.grab_wrench()."""
        return self._simulation.grab_wrench(self._number, about)

    def motor(self, about: ArrayLike | None = None) -> _core.Wrench:
        """Force and torque of its motion's motor in the last step: Simulation.motor()."""
        return self._simulation.motor(self._number, about)

    def _of_all(self, points: ArrayLike | None) -> _arrays.Indices:
        rows = self.points
        every = np.arange(rows.start, rows.stop, dtype=np.int32)
        return every if points is None else every[_arrays.selection(points, "points", len(every))]


class SimulationBodies:
    """The bodies of a simulation in one index space: the same arrays as Bodies, and each body can be driven."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation

    def __repr__(self) -> str:
        return f"<palpate.SimulationBodies: {len(self)}>"

    def __reduce__(self) -> NoReturn:
        raise TypeError("a palpate.SimulationBodies cannot be pickled or copied: keep their arrays (points_rest, tets and so on)")

    def __len__(self) -> int:
        """Number of bodies."""
        return len(self._simulation._bodies)

    def __getitem__(self, body: int | str) -> SimulationBody:
        """A body by its number, or by its name."""
        if isinstance(body, str):
            names = [self._simulation._bodies[number].name for number in range(len(self))]
            if body not in names:
                raise KeyError(body)
            return SimulationBody(self._simulation, names.index(body))
        number = _arrays.integer(body, "body")
        if not 0 <= number < len(self):
            raise IndexError("no body with this number")
        return SimulationBody(self._simulation, number)

    def __iter__(self) -> Iterator[SimulationBody]:
        return (self[number] for number in range(len(self)))

    @property
    def points_rest(self) -> _arrays.Floats:
        """(n, 3) positions of all points at rest, m."""
        return self._simulation._bodies.points_rest

    @property
    def tets(self) -> _arrays.Indices:
        """(m, 4) corners of all tets."""
        return self._simulation._bodies.tets

    @property
    def edges(self) -> _arrays.Indices:
        """(e, 2) ends of all edges."""
        return self._simulation._bodies.edges

    @property
    def triangles(self) -> _arrays.Indices:
        """(t, 3) corners of all surface triangles, outward."""
        return self._simulation._bodies.triangles

    @property
    def body_of_point(self) -> _arrays.Indices:
        """(n) body of each point."""
        return self._simulation._bodies.body_of_point


def number_of(body: int | str, bodies: _core.Bodies, what: str) -> int:
    """The number of a body, from its name or number. Raises Error naming `what` if there is no such body."""
    if len(bodies) == 0:
        raise Error(what, "body", repr(body), "a body that was added: there is none yet")
    if isinstance(body, str):
        names = [bodies[number].name for number in range(len(bodies))]
        if body not in names:
            raise Error(what, "body", repr(body), f"one of {names}")
        return names.index(body)
    number = _arrays.integer(body, "body")
    if not 0 <= number < len(bodies):
        raise Error(what, "body", str(number), f"0 to {len(bodies) - 1}")
    return number


Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


def pose_of(
    pose: ArrayLike | _core.Keyframe, quaternion: ArrayLike | None, center: Sequence[float]
) -> tuple[Vector, Quaternion]:
    """The shift and the quaternion (w, x, y, z), about a centre, of a pose in one of the forms of Simulation.move_to().
    """
    if isinstance(pose, _core.Keyframe):
        x, y, z = pose.translate
        w, i, j, k = pose.quaternion
        return _alone((x, y, z), (w, i, j, k), quaternion, "a Keyframe")
    array = _arrays.array_of(pose, "pose")
    if array.shape == (4, 4):
        shift, rotation = _of_matrix(_arrays.reals(array, "pose"), np.asarray(center, dtype=np.float64))
        return _alone(shift, rotation, quaternion, "a matrix")
    if array.shape != (3,):
        raise Error("move_to", "pose", f"an array of shape {array.shape}", "a translation (3), a matrix (4, 4) or a Keyframe")
    given = _arrays.array_of((1.0, 0.0, 0.0, 0.0) if quaternion is None else quaternion, "quaternion")
    if given.shape != (4,):
        raise Error("move_to", "quaternion", f"an array of shape {given.shape}", "four numbers")
    w, i, j, k = _arrays.reals(given, "quaternion").tolist()
    return _arrays.vector(array, "pose"), (w, i, j, k)


def _alone(shift: Vector, rotation: Quaternion, quaternion: ArrayLike | None, what: str) -> tuple[Vector, Quaternion]:
    if quaternion is not None:
        raise Error("move_to", "quaternion", f"a quaternion together with {what}", "only one of the two")
    return shift, rotation


def _of_matrix(matrix: _arrays.Floats, center: _arrays.Floats) -> tuple[Vector, Quaternion]:
    rotation = matrix[:3, :3]
    rounding = 1e-6
    rigid = bool(np.isfinite(matrix).all()) and bool((matrix[3] == (0.0, 0.0, 0.0, 1.0)).all())
    if not rigid or np.abs(rotation @ rotation.T - np.eye(3)).max() > rounding or np.linalg.det(rotation) < 0.0:
        raise Error("move_to", "pose", "a matrix that is not a rigid motion", "a rotation and a translation, with the last row 0, 0, 0, 1")
    return _arrays.vector(matrix[:3, 3] + rotation @ center - center, "pose"), rotation_quaternion(rotation)


def rotation_quaternion(matrix: _arrays.Floats) -> Quaternion:
    """(w, x, y, z) of a rotation matrix (Shepperd, "Quaternion from rotation matrix", 1978)."""
    m: Any = matrix
    squares = (1 + m[0, 0] + m[1, 1] + m[2, 2], 1 + m[0, 0] - m[1, 1] - m[2, 2],
               1 - m[0, 0] + m[1, 1] - m[2, 2], 1 - m[0, 0] - m[1, 1] + m[2, 2])
    largest = int(np.argmax(squares))
    rows = ((squares[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]),
            (m[2, 1] - m[1, 2], squares[1], m[1, 0] + m[0, 1], m[0, 2] + m[2, 0]),
            (m[0, 2] - m[2, 0], m[1, 0] + m[0, 1], squares[2], m[2, 1] + m[1, 2]),
            (m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[2, 1] + m[1, 2], squares[3]))
    w, x, y, z = (float(value) / (2.0 * float(np.sqrt(squares[largest]))) for value in rows[largest])
    return w, x, y, z
