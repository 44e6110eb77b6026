#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <palpate/types.hpp>

#include "io/vtk_cells.hpp"

namespace palpate::io {

/// The arrays of a VTK legacy file, before cells are checked.
struct VtkLegacyFile {
  enum class Dataset { unstructured_grid, poly_data };
  Dataset dataset = Dataset::unstructured_grid;
  bool binary = false;
  std::vector<Vec3> points;    ///< finite
  VtkCells cells;              ///< of an unstructured grid, or the polygons of PolyData, which have no types
  VtkCells strips;             ///< triangle strips of PolyData, without types
  std::size_t data_begin = 0;  ///< byte of the first POINT_DATA or CELL_DATA, or the end
};

/// Reads an unstructured grid or PolyData, ASCII or binary, of file versions up to 5.1 (VTK file formats,
/// "Simple legacy formats"). Data after the cells (point and cell data) are not read, vertices and lines of
/// PolyData are skipped. An ASCII file must end with a line end: the format has no end mark. Throws Error
/// naming the line or byte.
VtkLegacyFile read_vtk_legacy_file(const std::string& source, std::string_view bytes);

/// The cell data of that name (VECTORS, NORMALS, SCALARS or an array of a FIELD): n_cells x components finite
/// numbers, of the file that `file` was read from. Throws Error if there is none, and as above.
std::vector<double> read_vtk_legacy_data(const std::string& source, std::string_view bytes,
                                         const VtkLegacyFile& file, const CellDataKey& key);

}  // namespace palpate::io
