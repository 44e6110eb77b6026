"""Simulation: the whole step, of a scene or of a model that is built in code."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from . import _arrays, _core
from ._error import Error, NotConverged
from ._progress import bar
from ._scene import Model, scene_dict, scene_of
from ._settings import settings, threads_or_default

if TYPE_CHECKING:
    import pyvista


class Grab:
    """A spring that pulls a point of a simulation; made by Simulation.grab()."""

    def __init__(self, simulation: _core.Simulation, number: int) -> None:
        self._simulation = simulation
        self._number: int | None = number

    def __repr__(self) -> str:
        return "<palpate.Grab: let go>" if self._number is None else f"<palpate.Grab: number {self._number}>"

    def __reduce__(self) -> NoReturn:
        raise TypeError("a palpate.Grab cannot be pickled or copied: it belongs to its simulation")

    def _held(self) -> int:
        if self._number is None:
            raise Error("Grab", "", "a point that was let go", "one that is held")
        return self._number

    def move(self, target: ArrayLike) -> None:
        """Another target, m, from the next step on."""
        self._simulation._move_grab(self._held(), _arrays.vector(target, "target"))

    @property
    def force(self) -> _arrays.Floats:
        """(3) force of the spring on its point over the last step, N."""
        return np.array(self._simulation._grab_force(self._held()))

    def release(self) -> None:
        """Lets go of the point."""
        self._simulation._release(self._held())
        self._number = None


class Simulation(_core.Simulation):
    """Soft bodies under gravity, with contact: positions -> contacts -> forces -> implicit Euler, step by step.

    scene: the path of a scene file, a mapping with the same keys, or a Model that was built in code.
    threads: number of threads, 0 for all cores; None takes what set_threads() says.
    settings: keys of a scene other than its bodies (docs/scene.md): time_step, gravity, contact, solver, rest, limits,
        relax. They replace those of the scene; what a model is not told has the default.

    Where the scene asks for it (`relax`), overlaps at the start are removed first; `relaxed` tells how that went.
    After each step the contacts are those of the positions that it led to. The same input gives the same bits for every
    structure and number of threads, and those that `palpate run` has.
    """

    def __init__(
        self,
        scene: str | os.PathLike[str] | Mapping[str, Any] | Model,
        *,
        threads: int | None = None,
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
        self._wants_rest = False
        super().__init__(model, read, threads_or_default(threads))

    def __repr__(self) -> str:
        try:
            metrics = self.metrics
            return (f"<palpate.Simulation: step {metrics.step}, t = {metrics.time:.6g} s, {len(self.bodies)} bodies, "
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
        """Makes steps; returns how many.

        steps: None makes those that are left of the scene's duration.
        until_rest: ends once nothing moves (`rest` in the scene).
        callback: is called with the simulation after each step, and ends the run where it returns True.
        progress: shows a bar of tqdm.

        Warns with NotConverged where steps did not converge (steps_not_converged counts them).
        Ctrl-C ends it after the present step, with KeyboardInterrupt and the simulation as that step left it. Raises
        Error where the simulation blows up; its state is then that of the last good step.
        """
        wanted = self._steps_left() if steps is None else steps
        if wanted < 0:
            raise Error("Simulation.run", "steps", str(wanted), "0 or more")
        done = 0
        before = self.steps_not_converged
        with bar(progress, wanted, "step") as shown:
            while done < wanted and not (until_rest and self.at_rest):
                self.step()
                done += 1
                shown.update()
                if callback is not None and callback(self) is True:
                    break
        if bad := self.steps_not_converged - before:
            warnings.warn(f"NOT CONVERGED in {bad} of {done} steps: do not trust positions", NotConverged, stacklevel=2)
        return done

    def _steps_left(self) -> int:
        rounding = 1e-9  # a duration of 50 steps is 50 steps, whatever the rounding of the quotient
        return max(0, math.ceil(self._duration / self.time_step * (1.0 - rounding)) - self.metrics.step)

    def set_force(self, point: int, force: ArrayLike) -> None:
        """Loads a point (of all points) with a force, N, from the next step on, in place of the one before."""
        self._set_force(point, _arrays.vector(force, "force"))

    def grab(self, point: int, target: ArrayLike, stiffness: float) -> Grab:
        """Pulls a point (of all points) by a spring, N/m, to a place, m, from the next step on.

        The spring is damped critically against the mass of the point. Returns a Grab, to move and release it.
        """
        return Grab(self, self._grab(point, _arrays.vector(target, "target"), stiffness))

    def to_pyvista(self) -> pyvista.UnstructuredGrid:
        """All bodies as they are now as a grid of pyvista, with `body`, `velocity` and the depth of contacts."""
        from ._view import grid_of

        grid = grid_of(self.positions, self.bodies, self.contacts)
        grid.point_data["velocity"] = self.velocities
        return grid
