"""Bodies and contacts as grids of pyvista."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from . import _arrays, _core
from ._error import Error
from ._progress import needed

if TYPE_CHECKING:
    import pandas
    import pyvista


def to_pyvista(points: ArrayLike, tets: ArrayLike) -> pyvista.UnstructuredGrid:
    """A mesh of tets as a grid of pyvista. points: (n, 3), tets: (m, 4). Needs pyvista."""
    try:
        import pyvista
    except ImportError:
        raise needed("pyvista", "to_pyvista", "view") from None
    positions, corners = _arrays.mesh(points, tets)
    return pyvista.UnstructuredGrid({pyvista.CellType.TETRA: corners}, positions)


def grid_of(points: _arrays.Floats, bodies: _core.Bodies, contacts: _core.Contacts) -> pyvista.UnstructuredGrid:
    """All bodies as one grid: `body` of tets and points, and at points in contact the deepest `depth` (else 0)."""
    if points.shape != bodies.points_rest.shape:
        raise Error("positions", "", f"{len(points)} points", f"{len(bodies.points_rest)}, as the bodies have")
    grid = to_pyvista(points, bodies.tets)
    grid.point_data["body"] = bodies.body_of_point
    grid.cell_data["body"] = bodies.body_of_point[bodies.tets[:, 0]]
    depth = np.zeros(len(points))
    np.maximum.at(depth, contacts.point, contacts.depth)
    grid.point_data["depth"] = depth
    return grid


def set_units(grid: pyvista.UnstructuredGrid, units: dict[str, str]) -> None:
    """Stores the units of arrays in field_data["units"], and as frames of the command have them: in their metadata."""
    from vtkmodules.vtkCommonCore import vtkDataArray

    for data in (grid.GetPointData(), grid.GetCellData()):
        for name, unit in units.items():
            array = data.GetArray(name)
            if array is not None and unit:
                array.GetInformation().Set(vtkDataArray.UNITS_LABEL(), unit)
    grid.field_data["units"] = [f"{name} [{unit}]" for name, unit in units.items() if unit]


def _columns(table: Any, names: tuple[str, ...]) -> dict[str, Any]:
    """Columns of a table from arrays: a vector gives NAME_x, NAME_y, NAME_z, other rows NAME_0, NAME_1 ..."""
    columns: dict[str, Any] = {}
    for name in names:
        values = np.asarray(getattr(table, name))
        if values.ndim == 1:
            columns[name] = values
            continue
        ends = "xyz" if values.shape[1] == 3 else "0123456789"
        for k in range(values.shape[1]):
            columns[f"{name}_{ends[k]}"] = values[:, k]
    return columns


def _frame(columns: dict[str, Any], what: str) -> pandas.DataFrame:
    try:
        import pandas
    except ImportError:
        raise needed("pandas", what, "study") from None
    return pandas.DataFrame(columns)


def contacts_frame(contacts: _core.Contacts) -> pandas.DataFrame:
    """A row for each contact. Needs pandas."""
    names = ("point", "body", "tet", "weights", "depth", "direction", "certainty")
    return _frame(_columns(contacts, names), "Contacts.to_dataframe")


def contact_forces_frame(contacts: _core.ContactForces) -> pandas.DataFrame:
    """A row for each contact with its force; `edge` is -1 where it is of a point. Needs pandas."""
    names = ("point", "edge", "body", "tet", "weights", "depth", "direction", "normal", "friction", "force", "status", "speculative")
    return _frame(_columns(contacts, names), "ContactForces.to_dataframe")
