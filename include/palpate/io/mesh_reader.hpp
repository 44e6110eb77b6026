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

/// Reads the tets of a mesh file. The format follows from the extension, in lower or upper case:
///
/// - `.vtu` VTK XML and `.vtk` VTK legacy unstructured grids, ASCII and binary, with all encodings and
///   compressors of VTK 9.1; XML in a file named `.vtk` is read as `.vtu`. Our own code reads the structure,
///   since VTK 9.1's readers crash, hang or allocate without bound on damaged files. VTK uncompresses, and
///   the tests compare with files of its writers.
/// - `.msh` Gmsh 1, 2 to 2.2, 4.0 and 4.1, ASCII and binary of either byte order
/// - `.node`, `.ele` TetGen: two files in one folder, given by either path
/// - `.mesh` Medit ASCII
///
/// Hexahedra, wedges and pyramids are cut into tets, so that cells with a common face cut it in the same way.
/// Of higher-order cells only the corners are used: curved edges become straight, and their middle points are
/// in no tet. Both are counted in `converted`. Cells of other kinds are left out and counted in `dropped`.
///
/// Throws Error, naming the file and the line, index or byte, for a file that is missing, unreadable,
/// truncated or damaged, for indices out of range, for coordinates that are not finite, and if no tet is
/// left. Never allocates memory for a count that the size of the file cannot hold. Repeated points in a tet
/// and zero volume are accepted here; check_mesh() refuses them. O(file size).
MeshFile read_mesh(const std::filesystem::path& path);

}  // namespace palpate::io
