#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include <palpate/io/mesh_reader.hpp>

namespace palpate::io {

/// How many corners a kind of cell with a volume has, 0 for all other kinds. Kinds of high order have those
/// of their linear shape, which every format lists first ("hexahedron20": 8).
std::size_t volume_corners(std::string_view kind);

/// Appends the tets of a cell with a volume and counts it in `converted`; a four-point tet is taken as it is.
///
/// Other cells are cut into tets from their corner of the lowest index, quads by the diagonal at their corner
/// of the lowest index: cells that share a quad cut it alike (Dompierre, Labbé, Vallet and Camarero 1999,
/// "How to subdivide pyramids, prisms and hexahedra into tetrahedra"). Corners that coincide, as in a
/// hexahedron collapsed to a wedge, are no harm. Tets get positive volume.
///
/// \param corners  the first volume_corners(kind) points of the cell in the order of VTK, which Gmsh, Medit
///                 and Abaqus share; indices of points of `file`, not checked
void add_volume_cell(MeshFile& file, std::string_view kind, std::span<const Index> corners);

}  // namespace palpate::io
