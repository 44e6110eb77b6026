#pragma once

#include <string>

#include "io/vtk_cells.hpp"
#include "surface_file.hpp"

namespace palpate::app {

/// Appends the polygons, or the triangles of strips, of VTK's arrays. `first_point` is added to their point
/// numbers. Throws Error naming the polygon if the offsets do not ascend to the length of the
/// connectivity, or a point number is outside [0, n_points).
void append_polygons(const io::VtkCells& cells, Index first_point, Index n_points, const std::string& source,
                     PolygonFile& file);
void append_strips(const io::VtkCells& strips, Index first_point, Index n_points, const std::string& source,
                   PolygonFile& file);

}  // namespace palpate::app
