#include "vtk_polygons.hpp"

#include <cstddef>
#include <fmt/format.h>
#include <span>
#include <utility>
#include <vector>

#include <palpate/error.hpp>

namespace palpate::app {
namespace {

/// Calls f(points) for each cell, with point numbers of the file.
template <class Function>
void for_cells(const io::VtkCells& cells, const char* kind, Index first_point, Index n_points,
               const std::string& source, Function&& f) {
  const auto length = static_cast<std::int64_t>(cells.connectivity.size());
  std::int64_t next = 0;
  for (std::size_t c = 0; c < cells.ends.size(); ++c) {
    const std::int64_t end = cells.ends[c];
    if (end < next || end > length) {
      throw Error(source, fmt::format("offsets, number {}", c), fmt::format("{}", end),
                  end < next ? fmt::format("{} or more, since offsets ascend", next)
                             : fmt::format("at most {}, the number of corners in the file", length));
    }
    std::vector<Index> points;
    for (; next < end; ++next) {
      const std::int64_t point = cells.connectivity[static_cast<std::size_t>(next)];
      if (point < 0 || point >= n_points) {
        throw Error(source, fmt::format("{} {}", kind, c), fmt::format("point {}", point),
                    fmt::format("the index of one of {} points", n_points));
      }
      points.push_back(first_point + static_cast<Index>(point));
    }
    f(std::move(points));
  }
  if (next != length) {
    throw Error(source, "", fmt::format("{} corners behind the last {}", length - next, kind), "none");
  }
}

}  // namespace

void append_polygons(const io::VtkCells& cells, Index first_point, Index n_points, const std::string& source,
                     PolygonFile& file) {
  for_cells(cells, "polygon", first_point, n_points, source,
            [&](std::vector<Index> points) { file.polygons.push_back(std::move(points)); });
}

void append_strips(const io::VtkCells& strips, Index first_point, Index n_points, const std::string& source,
                   PolygonFile& file) {
  for_cells(strips, "strip", first_point, n_points, source, [&](const std::vector<Index>& p) {
    for (std::size_t i = 0; i + 2 < p.size(); ++i) {
      const bool turned = i % 2 == 1;  // every other triangle is flipped, so that all face the same side
      file.polygons.push_back({p[i], p[turned ? i + 2 : i + 1], p[turned ? i + 1 : i + 2]});
    }
  });
}

}  // namespace palpate::app
