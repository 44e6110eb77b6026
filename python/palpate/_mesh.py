"""Meshes from files and generators."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _arrays, _core
from ._arrays import Floats, Indices
from ._error import Error, shown
from ._progress import needed


def read_mesh(file: str | os.PathLike[str]) -> tuple[Floats, Indices]:
    """The tets of a mesh file: points (n, 3) in the units of the file, and tets (m, 4).

    Our own readers read .vtu, .vtk, .msh, .node/.ele and .mesh with all checks, and reorder tets of negative volume.
    Other formats (.inp, .xdmf, .bdf ...), and .vtu files compressed by LZ4 or LZMA, are read by meshio where it is
    installed. Hexahedra, wedges and pyramids are cut into tets, higher-order cells are used as linear ones. Raises Error
    naming the file.
    """
    path = _arrays.path(file, "file")
    extension = os.path.splitext(path)[1].lower()
    if extension in _core.mesh_extensions():
        try:
            return _core.read_mesh(path)
        except Error as error:
            if "compressor" not in error.found:
                raise
    return _read_with_meshio(path)


def _read_with_meshio(path: str) -> tuple[Floats, Indices]:
    try:
        import meshio
    except ImportError:
        raise needed("meshio", path, "mesh") from None
    if not os.path.isfile(path):
        raise Error(path, "", "a file that cannot be read", "a mesh file")
    try:
        mesh = meshio.read(path)
    except (Exception, SystemExit) as error:  # meshio ends the process on some errors
        raise Error(path, "", f"a file that meshio cannot read ({str(error) or type(error).__name__})", "a mesh file") from None
    points = _arrays.points(mesh.points, path)
    blocks = [_tets_of(block.type, points, block.data, path) for block in mesh.cells]
    tets = np.concatenate([block for block in blocks if block is not None] or [np.empty((0, 4), np.int32)])
    if len(tets) == 0:
        raise Error(path, "", "no tets and no cells that can be cut into tets", "a mesh with such cells")
    return points, _arrays.tets(tets, path)


# Kinds of meshio with a volume, by how their names begin ("hexahedron20"), and ours.
_VOLUMES = {"tetra": "tetrahedron", "hexahedron": "hexahedron", "wedge": "wedge", "pyramid": "pyramid"}


def _tets_of(kind: str, points: Floats, cells: Any, path: str) -> Indices | None:
    """The tets of a block of meshio, whose cells have their corners first as ours do; None for other kinds."""
    begin = kind.rstrip("0123456789")
    if begin not in _VOLUMES:
        return None
    corners = np.ascontiguousarray(cells, dtype=np.int32)
    if corners.size and (corners.min() < 0 or corners.max() >= len(points)):
        raise Error(path, kind, f"point {corners.max()}", f"one of {len(points)} points")
    return _core.tets_of_cells(_VOLUMES[begin] + kind[len(begin):], points, corners)


def write_mesh(
    file: str | os.PathLike[str],
    points: ArrayLike,
    tets: ArrayLike,
    *,
    point_data: Mapping[str, Any] | None = None,
    cell_data: Mapping[str, Any] | None = None,
) -> None:
    """Writes a mesh by meshio, the format by the extension. points: (n, 3), tets: (m, 4).

    point_data: arrays of a row for each point. cell_data: arrays of a row for each tet. Tets may be flat or inverted, as
    in results. Raises Error, and writes no file, if there are no tets, or on an index out of range, a coordinate that is
    not finite, or an array of another length.
    """
    path = _arrays.path(file, "file")
    try:
        import meshio
    except ImportError:
        raise needed("meshio", path, "mesh") from None
    positions, corners = _arrays.mesh(points, tets)
    if len(corners) == 0:
        raise Error("tets", "", "no tets", "at least one tet")
    wrong = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if wrong.size > 0:
        raise Error("points", f"point {wrong[0]}", f"coordinates {positions[wrong[0]].tolist()}", "finite numbers")
    of_points = _fields(point_data, "point_data", len(positions))
    of_tets = _fields(cell_data, "cell_data", len(corners))
    mesh = meshio.Mesh(positions, [("tetra", corners)], point_data=of_points,
                       cell_data={name: [values] for name, values in of_tets.items()})
    try:
        # meshio takes the first format that it knows by an extension, which for .msh is not Gmsh's.
        meshio.write(path, mesh, file_format="gmsh" if path.lower().endswith(".msh") else None)
    except (Exception, SystemExit) as error:
        raise Error(path, "", f"a mesh that meshio cannot write ({str(error) or type(error).__name__})",
                    "a mesh format that meshio can write") from None


def _fields(data: Mapping[str, Any] | None, name: str, rows: int) -> dict[str, Any]:
    """The arrays of a mapping, each with a number of rows."""
    if not isinstance(data, (Mapping, type(None))):
        raise Error("write_mesh", name, shown(data), "a mapping of arrays")
    fields = {key: np.asarray(values) for key, values in (data or {}).items()}
    for key, values in fields.items():
        if values.ndim == 0 or len(values) != rows:
            raise Error("write_mesh", f"{name}[{key!r}]", f"an array of shape {values.shape}", f"{rows} rows")
    return fields


def box(cells: tuple[int, int, int], size: ArrayLike) -> tuple[Floats, Indices]:
    """A box of tets, centred at the origin. cells: number along x, y and z, five tets per cell. size: (3) extent, m."""
    return _core.box(cells, _arrays.vector(size, "size"))


def ball(radius: float, resolution: int) -> tuple[Floats, Indices]:
    """A ball of tets, centred at the origin. radius: m. resolution: layers, 20 resolution^3 tets."""
    return _core.ball(radius, resolution)
