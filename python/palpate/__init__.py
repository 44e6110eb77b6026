"""Contacts among soft tetrahedral bodies: detect() for one configuration, World for a
sequence of frames, Simulation for whole steps.

Arrays are NumPy's: points (n, 3) float64 in metres, tets (m, 4) int32. Wrong input raises palpate.Error, one line that
says what was found and what was expected. docs/python.md and docs/tutorial/ show how to use it.
"""

from ._core import (
    Bodies,
    Body,
    ContactForces,
    Contacts,
    Crossings,
    DetectionCounts,
    DetectionTimes,
    EdgeContacts,
    Fibres,
    Keyframe,
    Material,
    Motion,
    PairWrench,
    Ramp,
    RelaxReport,
    StepMetrics,
    SurfaceTractions,
    TissueState,
    Viscosity,
    Wrench,
    version as __version__,
)
from ._bodies import SimulationBodies, SimulationBody
from ._detect import detect
from ._error import Error, NotConverged
from ._mesh import ball, box, read_mesh, write_mesh
from ._scene import Model, read_scene, stacking_scene, write_scene
from ._settings import get_threads, set_threads
from ._simulation import Grab, Outcome, Simulation
from ._sweep import sweep, sweep_rows
from ._view import to_pyvista
from ._world import World

__all__ = [
    "Bodies",
    "Body",
    "ContactForces",
    "Contacts",
    "Crossings",
    "DetectionCounts",
    "DetectionTimes",
    "EdgeContacts",
    "Error",
    "Fibres",
    "Grab",
    "Keyframe",
    "Material",
    "Model",
    "Motion",
    "NotConverged",
    "Outcome",
    "PairWrench",
    "Ramp",
    "RelaxReport",
    "Simulation",
    "SimulationBodies",
    "SimulationBody",
    "StepMetrics",
    "SurfaceTractions",
    "TissueState",
    "Viscosity",
    "World",
    "Wrench",
    "__version__",
    "ball",
    "box",
    "detect",
    "get_threads",
    "read_mesh",
    "read_scene",
    "set_threads",
    "stacking_scene",
    "sweep",
    "sweep_rows",
    "to_pyvista",
    "write_mesh",
    "write_scene",
]
