#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include <palpate/io/mesh_reader.hpp>

namespace palpate::io {

/// The number of corners of a kind of cell with a volume; 0 for all other kinds. Higher-order kinds have the
/// corners of their linear shape, which every format lists first ("hexahedron20": 8).
std::size_t volume_corners(std::string_view kind);

/// Appends the tets of a cell with a volume and counts it in `converted`; a four-point tet is kept.
///
/// Other cells are cut into tets from their corner of the lowest index, quads by the diagonal at their corner
/// of the lowest index: cells with a common quad cut it in the same way (Dompierre, Labbé, Vallet and
/// Camarero 1999, "How to subdivide pyramids, prisms and hexahedra into tetrahedra"). Coinciding corners, as
/// in a hexahedron collapsed to a wedge, are allowed. Tets get positive volume.
///
/// \param corners  the first volume_corners(kind) points of the cell in the order of VTK (also of Gmsh, Medit
///                 and Abaqus); indices of points of `file`, not checked
void add_volume_cell(MeshFile& file, std::string_view kind, std::span<const Index> corners);

}  // namespace palpate::io
