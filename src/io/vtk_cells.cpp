#include "io/vtk_cells.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <utility>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "io/cell_counts.hpp"
#include "io/volume_cells.hpp"

namespace palpate::io {
namespace {

struct VtkCellType {
  std::int64_t number;
  std::string_view kind;  ///< our name, the same as in other formats
  int corners;            ///< 0 where the number varies
};

constexpr std::int64_t voxel = 11;
constexpr std::int64_t last_type = 81;  // VTK_BEZIER_PYRAMID, the last that vtkCellType.h of VTK 9 names

// vtkCellType.h: the linear cells, the quadratic ones that mesh generators write, and those of any order.
constexpr std::array<VtkCellType, 37> vtk_cell_types{{{0, "empty cell", 0},
                                                      {1, "vertex", 1},
                                                      {2, "poly-vertex", 0},
                                                      {3, "line", 2},
                                                      {4, "polyline", 0},
                                                      {5, "triangle", 3},
                                                      {6, "triangle strip", 0},
                                                      {7, "polygon", 0},
                                                      {8, "pixel", 4},
                                                      {9, "quad", 4},
                                                      {10, "tetrahedron", 4},
                                                      {voxel, "hexahedron", 8},
                                                      {12, "hexahedron", 8},
                                                      {13, "wedge", 6},
                                                      {14, "pyramid", 5},
                                                      {21, "line3", 3},
                                                      {22, "triangle6", 6},
                                                      {23, "quad8", 8},
                                                      {24, "tetrahedron10", 10},
                                                      {25, "hexahedron20", 20},
                                                      {26, "wedge15", 15},
                                                      {27, "pyramid13", 13},
                                                      {29, "hexahedron27", 27},
                                                      {31, "wedge12", 12},
                                                      {32, "wedge18", 18},
                                                      {33, "hexahedron24", 24},
                                                      {37, "pyramid19", 19},
                                                      {41, "convex point set", 0},
                                                      {42, "polyhedron", 0},
                                                      {71, "Lagrange tetrahedron", 0},
                                                      {72, "Lagrange hexahedron", 0},
                                                      {73, "Lagrange wedge", 0},
                                                      {74, "Lagrange pyramid", 0},
                                                      {78, "Bezier tetrahedron", 0},
                                                      {79, "Bezier hexahedron", 0},
                                                      {80, "Bezier wedge", 0},
                                                      {81, "Bezier pyramid", 0}}};

class CellAppender {
 public:
  CellAppender(const VtkCells& cells, const std::string& source, std::int64_t first_cell)
      : cells_(cells), source_(source), first_cell_(first_cell) {}

  std::vector<Index> append(Index first_point, Index n_points, MeshFile& file) const {
    if (cells_.ends.size() != cells_.types.size()) {
      throw Error(source_, "",
                  fmt::format("{} cells and {} cell types", cells_.ends.size(), cells_.types.size()),
                  "the same number of both");
    }
    std::vector<Index> tets_of_cells;
    std::int64_t begin = 0;
    for (std::size_t cell = 0; cell < cells_.ends.size(); ++cell) {
      const std::size_t before = file.mesh.tets.size();
      const std::span<const std::int64_t> corners = corners_of(cell, begin);
      begin = cells_.ends[cell];
      check_corners(cell, corners, n_points);
      append_cell(cell, corners, first_point, file);
      tets_of_cells.push_back(static_cast<Index>(file.mesh.tets.size() - before));
    }
    const auto length = static_cast<std::int64_t>(cells_.connectivity.size());
    if (begin != length) {
      throw Error(source_, "", fmt::format("{} entries of connectivity", length),
                  fmt::format("{}, where the last cell ends", begin));
    }
    return tets_of_cells;
  }

 private:
  [[noreturn]] void fail(std::size_t cell, const std::string& found, const std::string& expected) const {
    throw Error(source_, fmt::format("cell {}", first_cell_ + static_cast<std::int64_t>(cell)), found,
                expected);
  }

  std::span<const std::int64_t> corners_of(std::size_t cell, std::int64_t begin) const {
    const std::int64_t end = cells_.ends[cell];
    const auto length = static_cast<std::int64_t>(cells_.connectivity.size());
    if (end < begin || end > length) {
      fail(cell, fmt::format("offset {}", end), fmt::format("an offset from {} to {}", begin, length));
    }
    return std::span(cells_.connectivity)
        .subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin));
  }

  void check_corners(std::size_t cell, std::span<const std::int64_t> corners, Index n_points) const {
    const std::int64_t type = cells_.types[cell];
    if (type < 0 || type > last_type) {
      fail(cell, fmt::format("cell type {}", type),
           fmt::format("one of VTK's cell types, 0 to {}", last_type));
    }
    const VtkCellType* known = find(type);
    if (known != nullptr && known->corners != 0 &&
        corners.size() != static_cast<std::size_t>(known->corners)) {
      fail(cell, fmt::format("{} corners", corners.size()),
           fmt::format("{} for a {} (cell type {})", known->corners, known->kind, type));
    }
    for (const std::int64_t corner : corners) {
      if (corner >= 0 && corner < n_points) continue;
      fail(cell, fmt::format("point number {}", corner),
           n_points == 0 ? "no corners, because the file has no points"
                         : fmt::format("one from 0 to {}", n_points - 1));
    }
  }

  static const VtkCellType* find(std::int64_t type) {
    const auto found = std::find_if(vtk_cell_types.begin(), vtk_cell_types.end(),
                                    [&](const VtkCellType& t) { return t.number == type; });
    return found == vtk_cell_types.end() ? nullptr : &*found;
  }

  void append_cell(std::size_t cell, std::span<const std::int64_t> corners, Index first_point,
                   MeshFile& file) const {
    const std::int64_t type = cells_.types[cell];
    const VtkCellType* known = find(type);
    if (known == nullptr) return count_dropped(file, fmt::format("cell of VTK type {}", type));
    const std::size_t wanted = volume_corners(known->kind);
    if (wanted == 0) return count_dropped(file, known->kind);
    if (corners.size() < wanted) {
      fail(cell, fmt::format("{} corners", corners.size()),
           fmt::format("at least {} for a {} (cell type {})", wanted, known->kind, type));
    }
    std::array<Index, 8> points{};
    for (std::size_t i = 0; i < wanted; ++i) points[i] = first_point + static_cast<Index>(corners[i]);
    if (type == voxel) {  // its corners are in lattice order
      std::swap(points[2], points[3]);
      std::swap(points[6], points[7]);
    }
    add_volume_cell(file, known->kind, std::span(points).first(wanted));
  }

  const VtkCells& cells_;
  const std::string& source_;
  std::int64_t first_cell_;
};

}  // namespace

std::vector<Index> append_vtk_cells(const VtkCells& cells, Index first_point, Index n_points,
                                    std::int64_t first_cell, const std::string& source, MeshFile& file) {
  return CellAppender(cells, source, first_cell).append(first_point, n_points, file);
}

std::string CellDataKey::expected() const {
  return fmt::format("{}: a {} for each cell", components, components == 1 ? "number" : "vector");
}

void append_cell_data(std::span<const double> values, std::span<const Index> tets_of_cells,
                      std::vector<double>& data) {
  if (tets_of_cells.empty()) return;
  const std::size_t components = values.size() / tets_of_cells.size();
  for (std::size_t cell = 0; cell < tets_of_cells.size(); ++cell) {
    const std::span<const double> row = values.subspan(components * cell, components);
    for (Index tet = 0; tet < tets_of_cells[cell]; ++tet) data.insert(data.end(), row.begin(), row.end());
  }
}

}  // namespace palpate::io
