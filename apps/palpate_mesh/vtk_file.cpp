#include <algorithm>
#include <fmt/format.h>
#include <string>

#include <palpate/error.hpp>

#include "io/vtk_legacy_file.hpp"
#include "io/xml_scanner.hpp"
#include "surface_file.hpp"
#include "vtk_polygons.hpp"

namespace palpate::app {
namespace {

// Cell types of vtkCellType.h.
constexpr std::int64_t triangle = 5;
constexpr std::int64_t polygon = 7;
constexpr std::int64_t quad = 9;
constexpr std::int64_t tetra = 10;

/// The triangles, quads and polygons of an unstructured grid without volume cells.
io::VtkCells faces_of(const io::VtkLegacyFile& grid, const std::string& source) {
  const io::VtkCells& cells = grid.cells;
  if (cells.types.size() != cells.ends.size()) {
    throw Error(source, "", fmt::format("{} cells and {} cell types", cells.ends.size(), cells.types.size()),
                "the same number of both");
  }
  if (std::ranges::count(cells.types, tetra) > 0) {
    throw Error(source, "", "a mesh of tets, which needs no meshing",
                "a surface; 'palpate new' makes a scene of it");
  }
  io::VtkCells faces;
  std::int64_t begin = 0;
  const auto length = static_cast<std::int64_t>(cells.connectivity.size());
  for (std::size_t c = 0; c < cells.ends.size(); ++c) {
    const std::int64_t end = cells.ends[c];
    if (end < begin || end > length) {
      throw Error(source, fmt::format("cell {}", c), fmt::format("offset {}", end),
                  fmt::format("an offset from {} to {}", begin, length));
    }
    const std::int64_t type = cells.types[c];
    if (type == triangle || type == polygon || type == quad) {
      faces.connectivity.insert(faces.connectivity.end(), cells.connectivity.begin() + begin,
                                cells.connectivity.begin() + end);
      faces.ends.push_back(static_cast<std::int64_t>(faces.connectivity.size()));
    }
    begin = end;
  }
  return faces;
}

}  // namespace

PolygonFile read_vtk(const std::string& source, std::string_view bytes) {
  if (io::is_xml(bytes)) return read_vtp(source, bytes);
  io::VtkLegacyFile vtk = io::read_vtk_legacy_file(source, bytes);
  PolygonFile file;
  file.points = std::move(vtk.points);
  const auto points = static_cast<Index>(file.points.size());
  if (vtk.dataset == io::VtkLegacyFile::Dataset::unstructured_grid) {
    append_polygons(faces_of(vtk, source), 0, points, source, file);
  } else {
    append_polygons(vtk.cells, 0, points, source, file);
    append_strips(vtk.strips, 0, points, source, file);
  }
  return file;
}

}  // namespace palpate::app
