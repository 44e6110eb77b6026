"""Meshes from files and generators."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _arrays, _core
from ._arrays import Floats, Indices
from ._error import Error
from ._progress import needed


def read_mesh(file: str | os.PathLike[str]) -> tuple[Floats, Indices]:
    """The tets of a mesh file: points (n, 3) in the units of the file, and tets (m, 4).

    Our own readers take .vtu, .vtk, .msh, .node/.ele and .mesh, with every check, and turn tets of negative volume.
    Other formats, and .vtu files compressed by LZ4 or LZMA, are read by meshio where it is installed. Raises Error
    naming the file.
    """
    path = os.fspath(file)
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
        raise Error(path, "", "nothing that can be read", "a mesh file")
    try:
        mesh = meshio.read(path)
    except (Exception, SystemExit) as error:  # meshio ends the process on some errors
        raise Error(path, "", f"what meshio refuses ({str(error) or type(error).__name__})", "a mesh file") from None
    blocks = [block.data for block in mesh.cells if block.type == "tetra"]
    if not blocks:
        raise Error(path, "", "no tets", "a mesh of four-point tets")
    return _arrays.points(mesh.points, path), _arrays.tets(np.concatenate(blocks), path)


def write_mesh(
    file: str | os.PathLike[str],
    points: ArrayLike,
    tets: ArrayLike,
    *,
    point_data: Mapping[str, Any] | None = None,
    cell_data: Mapping[str, Any] | None = None,
) -> None:
    """Writes a mesh by meshio, the format by the extension. points: (n, 3), tets: (m, 4).

    point_data: arrays of a row for each point. cell_data: arrays of a row for each tet.
    """
    path = os.fspath(file)
    try:
        import meshio
    except ImportError:
        raise needed("meshio", path, "mesh") from None
    mesh = meshio.Mesh(
        _arrays.points(points, "points"), [("tetra", _arrays.tets(tets, "tets"))], point_data=dict(point_data or {}),
        cell_data={name: [np.asarray(values)] for name, values in (cell_data or {}).items()},
    )
    try:
        # meshio takes the first format that it knows by an extension, which for .msh is not Gmsh's.
        meshio.write(path, mesh, file_format="gmsh" if path.lower().endswith(".msh") else None)
    except (Exception, SystemExit) as error:
        raise Error(path, "", f"what meshio refuses ({str(error) or type(error).__name__})",
                    "a mesh format that it writes") from None


def box(cells: tuple[int, int, int], size: ArrayLike) -> tuple[Floats, Indices]:
    """A box of tets, centred at the origin. cells: along x, y and z, five tets a cell. size: (3) extent, m."""
    return _core.box(cells, _arrays.vector(size, "size"))


def ball(radius: float, resolution: int) -> tuple[Floats, Indices]:
    """A ball of tets, centred at the origin. radius: m. resolution: layers, 20 resolution^3 tets."""
    return _core.ball(radius, resolution)
