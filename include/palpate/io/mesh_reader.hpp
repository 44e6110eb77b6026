#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <palpate/mesh.hpp>

namespace palpate::io {

/// Cells of one kind that read_mesh() converted to four-point tets.
struct ConvertedCells {
  std::string kind;  ///< "hexahedron", "wedge", "tetrahedron10" …
  Index cells = 0;   ///< number of such cells in the file
  Index tets = 0;    ///< number of tets made of them
};

/// The result of read_mesh().
struct MeshFile {
  TetMesh mesh;        ///< all points of the file in its order, and its tets; before check_mesh()
  std::string format;  ///< in words, as "Gmsh 4.1 binary"
  /// Kinds of cells that were left out ("triangle", "line", "polyhedron" …) with their numbers, in the order
  /// of their first occurrence in the file.
  std::vector<std::pair<std::string, Index>> dropped;
  /// Cells that were converted: hexahedra, wedges and pyramids, which are cut into tets, and higher-order
  /// cells, which are used as linear ones; in the order of their first occurrence in the file.
  std::vector<ConvertedCells> converted;
};

/// The extensions that read_mesh() knows, in lower case and with the dot.
std::span<const std::string_view> mesh_extensions();

/// Reads the tets of a mesh file; the format follows from the extension (upper case is as good as lower).
///
/// - `.vtu` VTK XML and `.vtk` VTK legacy unstructured grids, ASCII and binary, all encodings and compressors
///   of VTK 9.1. The structure is read by our own code: VTK 9.1's readers crash, hang or allocate without
///   bound on damaged files; VTK is used for its compressors, and its writers are the oracle of the tests
///   by one name or the other: XML in a file named `.vtk` is read as `.vtu`
/// - `.msh` Gmsh 1, 2 to 2.2, 4.0 and 4.1, ASCII and binary of either byte order
/// - `.node`, `.ele` TetGen: the two files lie side by side, either path will do
/// - `.mesh` Medit ASCII
///
/// Hexahedra, wedges and pyramids are cut into tets so that cells with a common face cut it alike; of cells
/// of high order the corners are taken, so that curved edges become straight and their middle points are in
/// no tet. Both are counted in `converted`. Cells of other kinds are left out and counted in `dropped`.
///
/// Throws Error, naming the file and the line, index or byte, for a file that is missing, unreadable, cut off
/// or damaged, for indices out of range, for coordinates that are not finite, and
/// where no tet is left. Never allocates by a count that the file's size cannot hold. What only the geometry
/// shows (repeated points in a tet, zero volume) is check_mesh()'s to refuse. O(file size).
MeshFile read_mesh(const std::filesystem::path& path);

}  // namespace palpate::io
