"""Simulation: the whole step, of a scene or of a model that is built in code."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _core
from ._bodies import SimulationBodies, number_of, pose_of
from ._error import Error, NotConverged, shown
from ._names import Field
from ._progress import bar
from ._scene import Model, scene_dict, scene_of
from ._settings import settings, threads_or_default

if TYPE_CHECKING:
    import pyvista


@dataclasses.dataclass(frozen=True, eq=False)
class Outcome:
    """A quantity that a scene declares under "outcomes": its value in this unit; for displacements, rotations and
    forces also all three components.
    """

    kind: str
    value: float
    unit: str
    vector: _arrays.Floats | None

    def __repr__(self) -> str:
        vector = None if self.vector is None else self.vector.tolist()
        return f"palpate.Outcome(kind={self.kind!r}, value={self.value!r}, unit={self.unit!r}, vector={vector!r})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Outcome):
            return NotImplemented
        same = (self.kind, self.value, self.unit) == (other.kind, other.value, other.unit)
        if self.vector is None or other.vector is None:
            return same and self.vector is other.vector
        return same and np.array_equal(self.vector, other.vector)

    def __hash__(self) -> int:
        return hash((self.kind, self.value, self.unit))


def _outcomes_of(rows: list[tuple[str, str, float, str, tuple[float, float, float] | None]]) -> dict[str, Outcome]:
    return {
        name: Outcome(kind, value, unit, None if vector is None else np.array(vector))
        for name, kind, value, unit, vector in rows
    }


class Ties(NamedTuple):
    """The springs that tie points to other bodies, one row each: Simulation.ties."""

    point: NDArray[np.int32]
    """(n) of all points."""
    tet: NDArray[np.int32]
    """(n) of all tets: the one the point is tied to."""
    force: _arrays.Floats
    """(n, 3) on the point during the last step, N; the tet feels the opposite."""


class Grab:
    """A spring that pulls a point of a simulation: Simulation.grab() makes one, Simulation.grabs lists all."""

    def __init__(self, simulation: _core.Simulation, number: int) -> None:
        self._simulation = simulation
        self._number: int | None = number

    def __repr__(self) -> str:
        return "<palpate.Grab: released>" if self._number is None else f"<palpate.Grab: number {self._number}>"

    def __reduce__(self) -> NoReturn:
        raise TypeError("a palpate.Grab cannot be pickled or copied: it belongs to its simulation")

    def _held(self) -> int:
        if self._number is None:
            raise Error("Grab", "", "a grab that was released", "an active grab")
        return self._number

    def move(self, target: ArrayLike) -> None:
        """Sets the target, m, from the next step on."""
        self._simulation._move_grab(self._held(), _arrays.vector(target, "target"))

    @property
    def number(self) -> int:
        """Its number; a later grab may get it after release()."""
        return self._held()

    @property
    def point(self) -> int:
        """The point, of all points."""
        point, _, _ = self._simulation._grab_of(self._held())
        return point

    @property
    def target(self) -> _arrays.Floats:
        """(3) the target, m."""
        _, target, _ = self._simulation._grab_of(self._held())
        return np.array(target)

    @property
    def stiffness(self) -> float:
        """Stiffness of the spring, N/m."""
        _, _, stiffness = self._simulation._grab_of(self._held())
        return stiffness

    @property
    def force(self) -> _arrays.Floats:
        """(3) force of the spring on its point over the last step, N."""
        return np.array(self._simulation._grab_force(self._held()))

    def release(self) -> None:
        """Releases the point."""
        self._simulation._release(self._held())
        self._number = None


def _is_true(result: object) -> bool:
    return isinstance(result, (bool, np.bool_)) and bool(result)


class Simulation(_core.Simulation):
    """Soft bodies under gravity, with contact: positions -> contacts -> forces -> implicit Euler, step by step.

    scene: the path of a scene file, a mapping with the same keys, or a Model that was built in code.
    threads: number of threads, 0 for all cores; None takes the number of set_threads().
    reactions: compute in each step the reactions at fixed or prescribed points (`reactions`, reaction()).
    settings: keys of a scene other than its bodies (docs/scene.md): time_step, gravity, contact, solver, rest, limits,
        relax. They replace those of the scene; for a model all others have their defaults.

    Where the scene asks for it (`relax`), overlaps at the start are removed first; `relaxed` is the report on that.
    After each step the contacts are those at the new positions. The same input gives the same bits for every structure
    and number of threads, and the bits of `palpate run`.
    """

    def __init__(
        self,
        scene: str | os.PathLike[str] | Mapping[str, Any] | Model,
        *,
        threads: int | None = None,
        reactions: bool = False,
        **settings_: Any,
    ) -> None:
        if isinstance(scene, Model):
            model, read = scene, settings("Simulation", settings_)
        else:
            read = scene_of(scene)
            if settings_:
                read = scene_of({**scene_dict(read), **settings_})
            model = Model(read)
        self._duration = read.duration
        self._stage_steps = read.stage_steps
        self._stage_names = [stage["name"] for stage in scene_dict(read).get("stages", ())]
        others = ("bodies", "name", "output", "stages", "outcomes")
        self._keys = settings("Simulation", {key: value for key, value in scene_dict(read).items() if key not in others})
        super().__init__(model, read, threads_or_default(threads))
        if reactions:
            self.record_reactions(True)

    def __repr__(self) -> str:
        try:
            metrics = self.metrics
            return (f"<palpate.Simulation: step {metrics.step}, t = {metrics.time:.6g} s, {len(self._bodies)} bodies, "
                    f"{metrics.detection.contacts} contacts>")
        except Error:  # another thread is in a step of it
            return "<palpate.Simulation: busy in another thread>"

    def run(
        self,
        steps: int | None = None,
        *,
        until_rest: bool = False,
        callback: Callable[[Simulation], Any] | None = None,
        progress: bool = False,
    ) -> int:
        """Makes steps; returns their number.

        steps: None makes the remaining steps of the scene's duration, or of its stages (docs/stages.md).
        until_rest: ends once nothing moves (`rest` in the scene). Warns if the duration ends before that.
        callback: is called with the simulation after each step, and ends the run if it returns True (bool, or NumPy's).
        progress: shows a bar of tqdm.

        Warns with NotConverged where steps did not converge (steps_not_converged counts them), and with a
        RuntimeWarning where something may have gone through a body (steps_too_far).
        Ctrl-C ends it after the current step, with KeyboardInterrupt; the simulation is at the end of that step. Raises
        Error if the simulation blows up; its state is then that of the last good step.
        """
        if callback is not None and not callable(callback):
            raise Error("Simulation.run", "callback", type(callback).__name__, "a function, or None")
        staged = steps is None and not self.stages_done
        wanted = self._steps_left() if steps is None else _arrays.integer(steps, "steps")
        if wanted < 0:
            raise Error("Simulation.run", "steps", str(wanted), "0 or more")
        done = 0
        before = self.steps_not_converged
        too_far = self.steps_too_far
        with bar(progress, wanted, "step") as shown:
            while done < wanted and not (until_rest and self.at_rest) and not (staged and self.stages_done):
                self.step()
                done += 1
                shown.update()
                if callback is not None and _is_true(callback(self)):
                    break
        if until_rest and steps is None and not self._stage_steps and done == wanted and not self.at_rest:
            warnings.warn(
                f"not at rest after {done} steps, the rest of the duration of {self._duration:g} s: "
                "run(steps, until_rest=True) sets another limit",
                RuntimeWarning,
                stacklevel=2,
            )
        if passed := self.steps_too_far - too_far:
            warnings.warn(
                f"in {passed} of {done} steps something may have gone through a body: take {self._cures_of_passes()}",
                RuntimeWarning,
                stacklevel=2,
            )
        if bad := self.steps_not_converged - before:
            warnings.warn(f"NOT CONVERGED in {bad} of {done} steps: do not trust positions", NotConverged, stacklevel=2)
        return done

    def _steps_left(self) -> int:
        if self._stage_steps > 0:
            return max(0, self._stage_steps - self.metrics.step)
        rounding = 1e-9  # a duration of 50 steps gives 50 steps, also if the quotient is rounded
        return max(0, math.ceil(self._duration / self.time_step * (1.0 - rounding)) - self.metrics.step)

    def change(self, **settings_: Any) -> None:
        """Changes settings from the next step on: keys of a scene, as for Simulation(); positions, velocities and the
        state of contacts stay. Of a mapping (`contact={"friction": 0.2}`) only the keys given change. Raises Error,
        and changes nothing, on a bad one, on another time_step, on `relax`, which applies before the first step, and on
        keys that steps do not read (bodies, stages, outcomes, output, units, duration).
        """
        if "relax" in settings_:
            raise Error("Simulation.change", "relax", "a change of 'relax' after the start", "a new Simulation with it")
        for key in ("bodies", "stages", "outcomes", "output", "units", "duration"):
            if key in settings_:
                raise Error("Simulation.change", key, "a key that cannot change after the start", "settings of a step, such as contact or solver")
        # The settings of now: a stage or restore() may have changed them.
        merged = json.loads(self._settings_text(self._keys))
        for key in ("bodies", "name", "output"):
            merged.pop(key, None)
        for key, value in settings_.items():
            old = merged.get(key)
            merged[key] = {**old, **value} if isinstance(old, dict) and isinstance(value, Mapping) else value
        self._change(settings("Simulation.change", merged))

    def outcomes(self) -> dict[str, Outcome]:
        """The outcomes of the scene as they are now, by name, in its order (docs/stages.md)."""
        return _outcomes_of(self._outcomes())

    @property
    def stage_outcomes(self) -> dict[str, dict[str, Outcome]]:
        """The outcomes at the end of each stage that is over: {stage: {outcome: Outcome}}."""
        return {name: _outcomes_of(rows) for name, rows in zip(self._stage_names, self._stage_outcomes())}

    def remove(self, body: int | str) -> None:
        """Removes a body: it has no contacts and no weight, and does not move; its ties are removed. Raises Error if it
        is absent.
        """
        self._remove(self.body_number(body))

    def insert(self, body: int | str) -> None:
        """Inserts a body that was absent or removed, at its positions or the pose of its motion. Raises Error if it is
        present.
        """
        self._insert(self.body_number(body))

    def tie(self, points: ArrayLike, to: int | str, *, stiffness: float | None = None) -> None:
        """Ties points (indices or a mask, of all points) by springs to the nearest tets of another body, at their
        current positions. stiffness: of each, N/m; None: that of a contact between the two.
        """
        self._tie(self._points(points), self.body_number(to), stiffness)

    def untie(self, body: int | str, other: int | str) -> int:
        """Cuts all ties between two bodies; returns their number."""
        return self._untie(self.body_number(body), self.body_number(other))

    @property
    def bodies(self) -> SimulationBodies:
        """All bodies in one index space; each of them, bodies["probe"], has its own results and can be driven."""
        return SimulationBodies(self)

    def body_number(self, body: int | str) -> int:
        """The number of a body, from its name or number. Raises Error if there is no such body."""
        return number_of(body, self._bodies, "Simulation")

    def set_motion(self, body: int | str, motion: _core.Motion) -> None:
        """Replaces the motion of a body. At the end of the next step, its points are at the new pose, from wherever
        they were. Raises Error, and changes nothing, on a body without a motion.
        """
        self._set_motion(self._motion_of(self.body_number(body)), motion)

    def move_to(
        self, body: int | str, pose: ArrayLike | _core.Keyframe, quaternion: ArrayLike | None = None
    ) -> None:
        """Moves a body with a motion to a pose during the next step, at constant speed, and holds it there.

        pose: (3) shift from the body's place without its motion, m; or a rigid map as a (4, 4) matrix from there to the
        wanted place; or a Keyframe, whose time is ignored. quaternion: beside a shift, (w, x, y, z) of the rotation
        about the centre of its motion. Raises Error, and changes nothing, on a body without a motion and on an invalid
        pose.
        """
        self._place(self._motion_of(self.body_number(body)), pose, quaternion)

    def set_prescribed(self, number: int, motion: _core.Motion) -> None:
        """Replaces the motion of prescribed points, like set_motion(). number: what Model.prescribe() returned, or of a
        scene one of bodies[...].prescribed. Raises Error, and changes nothing, on another number.
        """
        self._check_prescribed(number)
        self._set_motion(number, motion)

    def move_prescribed(
        self, number: int, pose: ArrayLike | _core.Keyframe, quaternion: ArrayLike | None = None
    ) -> None:
        """Moves prescribed points to a pose, like move_to(). number: as for set_prescribed()."""
        self._check_prescribed(number)
        self._place(number, pose, quaternion)

    def _place(self, number: int, pose: ArrayLike | _core.Keyframe, quaternion: ArrayLike | None) -> None:
        self._move_to(number, *pose_of(pose, quaternion, self._motion(number).center))

    def set_force(self, point: int, force: ArrayLike) -> None:
        """Sets the force on a point (index among all points), N, from the next step on; replaces the one set before, and
        zero removes it. It adds to the loads of the model. Raises Error on a point of a rigid body.
        """
        self._set_forces(np.array([_arrays.integer(point, "point")], np.int32), np.array([_arrays.vector(force, "force")]))

    def set_forces(self, points: ArrayLike, forces: ArrayLike) -> None:
        """Sets forces on points (indices or a mask, of all points), (n, 3) or (3) for each of them, N, from the next
        step on; replaces those set before, and zero removes one. They add to the loads of the model. For a point that is
        given twice the last force holds; they are not added. Raises Error, and changes nothing, on a bad one and on a
        point of a rigid body.
        """
        chosen = self._points(points)
        self._set_forces(chosen, _arrays.vectors(forces, "forces", len(chosen)))

    def set_pressure(self, triangles: ArrayLike, pressure: ArrayLike) -> None:
        """Sets a pressure on surface triangles (indices or a mask, of bodies.triangles), one number for all or (n), Pa,
        against their outward normals, from the next step on; replaces the one set before, and 0 removes it. It follows
        the surface, and adds to the loads of the model. For a triangle that is given twice the last value holds. Raises
        Error, and changes nothing, on a bad one.
        """
        chosen = _arrays.selection(triangles, "triangles", len(self._bodies.triangles))
        values = _arrays.numbers(pressure, "pressure", len(chosen))
        if values.ndim == 0:
            self._set_pressure(chosen, float(values))
        else:
            self._set_pressures(chosen, values)

    def set_positions(self, positions: ArrayLike, points: ArrayLike | None = None) -> None:
        """Sets positions of points (indices or a mask; None: all but prescribed ones and those of rigid bodies), (n, 3),
        m, and detects the contacts there. Raises Error, and changes nothing, on a prescribed point, one of a rigid body,
        which would deform (move_to() moves one with a motion), and a number that is not finite.
        """
        chosen = self._free() if points is None else self._points(points)
        values = _arrays.points(positions, "positions")
        if points is None:
            values = _arrays.rows(values, "positions", chosen, self._every_point())
        self._set_positions(chosen, _arrays.vectors(values, "positions", len(chosen)))

    def set_velocities(self, velocities: ArrayLike, points: ArrayLike | None = None) -> None:
        """Sets velocities of points (indices or a mask, of all points; None: all that are neither fixed nor prescribed),
        (n, 3) or (3) for all, m/s. Without `points`, n may be the number of all points. Raises Error, and changes
        nothing, on a point that is fixed or prescribed, a velocity along an axis that is fixed, and a number that is not
        finite.
        """
        chosen = self._movable() if points is None else self._points(points)
        if points is None:
            velocities = _arrays.rows(velocities, "velocities", chosen, self._every_point())
        self._set_velocities(chosen, _arrays.vectors(velocities, "velocities", len(chosen)))

    def contact_wrench(self, body: int | str, about: ArrayLike | None = None) -> _core.Wrench:
        """Force and torque on a body (number or name) by contacts during the last step, N and N m, about a point, or its
        centre of mass.
        """
        number = self.body_number(body)
        return self._contact_wrench(number, self._about(number, about))

    def pair_wrenches(self, about: ArrayLike | None = None) -> list[_core.PairWrench]:
        """The wrench between each two bodies in contact during the last step, sorted by (body_a, body_b): `on_b` is that
        of a on b, N and N m, about a point, or the centre of mass of b; that on a is its opposite.
        """
        return self._pair_wrenches(None if about is None else _arrays.vector(about, "about"))

    def reaction(self, body: int | str, about: ArrayLike | None = None) -> _core.Wrench:
        """Reaction at the fixed or prescribed points of a body during the last step: force and torque about a point,
        or its centre of mass. Needs reactions=True.
        """
        number = self.body_number(body)
        return self._reaction_of_body(number, self._about(number, about))

    def motor(self, body: int | str, about: ArrayLike | None = None) -> _core.Wrench:
        """Force and torque of the motor of a body's motion in the last step, for it and the tissue attached to it,
        about a point or its centre of mass. They include its weight and inertia. Needs
        reactions=True.
        """
        number = self.body_number(body)
        return self._reaction_of_motion(self._motion_of(number), self._about(number, about))

    def reaction_of_prescribed(self, number: int, about: ArrayLike = (0.0, 0.0, 0.0)) -> _core.Wrench:
        """Force and torque, about a point, that moved the points of Model.prescribe() in the last step; number: what it
        returned. Needs reactions=True.
        """
        return self._reaction_of_motion(number, _arrays.vector(about, "about"))

    def field(self, name: Field, *, of: Literal["points", "tets"] = "points") -> _arrays.Floats:
        """A field of all bodies at the current positions, by its name in scenes and frames (`output.fields`). (n) or
        (n, components), n points or tets. Symmetric tensors have xx, yy, zz, xy, yz, xz; SI units, or those of a scene.

        Of points and tets, of tissue:
        deformation_gradient (n, 9), strain (n, 6), stress (n, 6) Pa, von_mises (n) Pa, pressure (n) Pa,
        principal_stress (n, 3) Pa, principal_directions (n, 9), energy_density (n) J/m^3, plastic_strain (n, 6),
        volume_ratio (n). Those of points are means over the tets around, not across borders of materials.
        Of points: contact_force (n, 3) N, contact_traction (n, 3) Pa, contact_pressure (n) Pa, reaction (n, 3) N.
        tissue(), tissue_at_points(), tractions() and reactions give the same in other shapes. Raises Error on another name.
        """
        if of not in ("points", "tets"):
            raise Error("Simulation.field", "of", repr(of), "'points' or 'tets'")
        return self._field(name, of == "tets")

    def center_of_mass(self, body: int | str) -> _arrays.Floats:
        """(3) current centre of mass of a body, m."""
        return np.array(self._center_of_mass(self.body_number(body)))

    def _about(self, body: int, about: ArrayLike | None) -> tuple[float, float, float]:
        return _arrays.vector(self._center_of_mass(body) if about is None else about, "about")

    def _points(self, points: ArrayLike) -> _arrays.Indices:
        return _arrays.selection(points, "points", len(self._bodies.points_rest))

    def _every_point(self) -> slice:
        return slice(0, len(self._bodies.points_rest))

    def _free(self) -> _arrays.Indices:
        bodies = self._bodies
        rigid = np.array([self._is_rigid(number) for number in range(len(bodies))], dtype=bool)
        return np.flatnonzero(~np.asarray(self._prescribed(), dtype=bool) & ~rigid[bodies.body_of_point]).astype(np.int32)

    def _movable(self) -> _arrays.Indices:
        """Points that are neither fixed nor prescribed."""
        return np.flatnonzero(np.asarray(self._moves_freely(), dtype=bool)).astype(np.int32)

    @property
    def grabs(self) -> list[Grab]:
        """All active grabs by number, also those of the scene or the model."""
        return [Grab(self, number) for number in self._grabs()]

    @property
    def ties(self) -> Ties:
        """The ties of the scene, the model, tie() and stages, with their forces during the last step."""
        point, tet = self._ties()
        return Ties(np.array(point, np.int32), np.array(tet, np.int32), self.tie_forces)

    def tie_wrench(self, body: int | str, about: ArrayLike | None = None) -> _core.Wrench:
        """Force and torque on a body (number or name) by all of its ties during the last step, N and N m, about a point,
        or its centre of mass.
        """
        number = self.body_number(body)
        return self._tie_wrench(number, self._about(number, about))

    def grab_wrench(self, body: int | str, about: ArrayLike | None = None) -> _core.Wrench:
        """Force and torque on a body by all grabs of its points: like tie_wrench()."""
        number = self.body_number(body)
        return self._grab_wrench(number, self._about(number, about))

    def grab(self, point: int, target: ArrayLike, stiffness: float) -> Grab:
        """Pulls a point (of all points) by a spring, N/m, to a position, m, from the next step on.

        The spring is damped critically against the mass of the point. Returns a Grab, to move and release it. Raises
        Error on a point of a rigid body, or of one that is removed.
        """
        return Grab(self, self._grab(point, _arrays.vector(target, "target"), stiffness))

    def to_pyvista(self, fields: Sequence[Field] = ()) -> pyvista.UnstructuredGrid:
        """All bodies at the current positions as a grid of pyvista, with `body`, `velocity` and the depth of contacts.

        fields: names of fields to add (`output.fields` in docs/scene.md): those of tissue as data of cells and points,
        those of contacts and reactions as data of points. Symmetric tensors have six components: xx, yy, zz, xy, yz, xz.
        The units are in field_data["units"], as "von_mises [Pa]", and in each array's metadata (UNITS_LABEL), as frames
        of `palpate run` have them.
        """
        from ._view import grid_of, set_units

        if isinstance(fields, str):
            raise Error("Simulation.to_pyvista", "fields", repr(fields), f"a list of names, such as [{fields!r}]")
        if not isinstance(fields, Iterable):
            raise Error("Simulation.to_pyvista", "fields", shown(fields), "a list of names")
        grid = grid_of(self.positions, self._bodies, self.contacts)
        grid.point_data["velocity"] = self.velocities
        length, speed = self._units()
        units = {"points": length, "depth": length, "velocity": speed}
        for name, on_points, unit, values in self._fields(list(fields)):
            (grid.point_data if on_points else grid.cell_data)[name] = values
            units[name] = unit
        set_units(grid, units)
        return grid
