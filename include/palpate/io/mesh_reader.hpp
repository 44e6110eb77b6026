#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <palpate/mesh.hpp>

namespace palpate::io {

/// What read_mesh() took from a file.
struct MeshFile {
  TetMesh
      mesh;  ///< all points of the file in its order, and its four-point tets; not yet through check_mesh()
  std::string format;  ///< in words, as "Gmsh 4.1 binary"
  /// Kinds of cells that are not four-point tets ("triangle", "line", "tetrahedron10" …) and how many of each
  /// there were, in the order in which the file first shows them.
  std::vector<std::pair<std::string, Index>> dropped;
};

/// The extensions that read_mesh() knows, lower case and with the dot.
std::span<const std::string_view> mesh_extensions();

/// Reads the tets of a mesh file; the format follows from the extension (upper case is as good as lower).
///
/// - `.vtu` VTK XML and `.vtk` VTK legacy unstructured grids, ASCII and binary, all encodings and compressors
///   of VTK 9.1. The structure is read by our own code: VTK 9.1's readers crash, hang or allocate without
///   bound on damaged files; VTK is used for its compressors, and its writers are the oracle of the tests
/// - `.msh` Gmsh 1, 2 to 2.2 and 4.1, ASCII and binary of either byte order
/// - `.node`, `.ele` TetGen: the two files lie side by side, either path will do
/// - `.mesh` Medit ASCII
///
/// Cells of other kinds are left out and counted in `dropped`. High-order tets are such another kind: their
/// extra points would change the shape of the body, so they are never taken as four-point tets.
///
/// Throws Error, naming the file and the line, index or byte, for a file that is missing, unreadable, cut off
/// or damaged, for indices out of range, for coordinates that are not finite, and
/// where no tet is left. Never allocates by a count that the file's size cannot hold. What only the geometry
/// shows (repeated points in a tet, zero volume) is check_mesh()'s to refuse. O(file size).
MeshFile read_mesh(const std::filesystem::path& path);

}  // namespace palpate::io
