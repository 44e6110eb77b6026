#pragma once

#include <string>

#include "io/vtk_cells.hpp"
#include "surface_file.hpp"

namespace palpate::app {

/// Appends the polygons, or the triangles of the strips, of arrays of VTK. Their point numbers get
/// `first_point` added. Throws Error naming the polygon for ends that do not ascend to the length of the
/// connectivity, and for point numbers outside [0, n_points).
void append_polygons(const io::VtkCells& cells, Index first_point, Index n_points, const std::string& source,
                     PolygonFile& file);
void append_strips(const io::VtkCells& strips, Index first_point, Index n_points, const std::string& source,
                   PolygonFile& file);

}  // namespace palpate::app
