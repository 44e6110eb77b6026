#include "near_triangles.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

#include "contact/nearest_surface.hpp"
#include "geometry/box.hpp"
#include "lattice.hpp"

namespace palpate::app {
namespace {

Box box_of(const std::array<Vec3, 3>& triangle) {
  Box box;
  for (const Vec3& corner : triangle) box.extend(corner);
  return box;
}

}  // namespace

NearTriangles::NearTriangles(std::vector<std::array<Vec3, 3>> triangles, double cell)
    : triangles_(std::move(triangles)), cell_(cell) {
  Box box;
  for (const auto& triangle : triangles_) {
    for (const Vec3& corner : triangle) box.extend(corner);
  }
  lower_ = box.lower;
  size_ = cell_of(box.upper);
  for (int& along : size_) ++along;
  begin_.assign(index({0, 0, size_[2]}) + 1, 0);
  const auto for_cells = [&](std::size_t t, auto&& f) {
    const Box own = box_of(triangles_[t]);
    const std::array<int, 3> low = cell_of(own.lower);
    const std::array<int, 3> high = cell_of(own.upper);
    for_points({high[0] - low[0] + 1, high[1] - low[1] + 1, high[2] - low[2] + 1}, [&](int i, int j, int k) {
      f(index({low[0] + i, low[1] + j, low[2] + k}));
    });
  };
  for (std::size_t t = 0; t < triangles_.size(); ++t) for_cells(t, [&](std::size_t c) { ++begin_[c + 1]; });
  for (std::size_t c = 1; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
  list_.resize(begin_.back());
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    for_cells(t, [&](std::size_t c) { list_[next[c]++] = t; });
}

std::array<int, 3> NearTriangles::cell_of(const Vec3& p) const {
  const auto along = [&](double x, double low) { return static_cast<int>(std::floor((x - low) / cell_)); };
  return {along(p.x, lower_.x), along(p.y, lower_.y), along(p.z, lower_.z)};
}

std::size_t NearTriangles::index(const std::array<int, 3>& cell) const {
  const auto row = static_cast<std::size_t>(cell[2]) * static_cast<std::size_t>(size_[1]) +
                   static_cast<std::size_t>(cell[1]);
  return row * static_cast<std::size_t>(size_[0]) + static_cast<std::size_t>(cell[0]);
}

double NearTriangles::distance(const Vec3& p) const {
  const std::array<int, 3> middle = cell_of(p);
  double best = std::numeric_limits<double>::infinity();
  int last = 0;
  for (std::size_t a = 0; a < 3; ++a)
    last = std::max({last, std::abs(middle[a]), std::abs(size_[a] - middle[a])});
  for (int ring = 0; ring <= last && (ring - 1) * cell_ < best; ++ring) {
    std::array<int, 3> low{};
    std::array<int, 3> count{};
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::max(middle[a] - ring, 0);
      count[a] = std::max(std::min(middle[a] + ring, size_[a] - 1) - low[a] + 1, 0);
    }
    for_points(count, [&](int i, int j, int k) {
      const std::array<int, 3> cell{low[0] + i, low[1] + j, low[2] + k};
      int away = 0;
      for (std::size_t a = 0; a < 3; ++a) away = std::max(away, std::abs(cell[a] - middle[a]));
      if (away != ring) return;
      const std::size_t c = index(cell);
      for (std::size_t n = begin_[c]; n < begin_[c + 1]; ++n)
        best = std::min(best, length(nearest_on_triangle(p, triangles_[list_[n]]) - p));
    });
  }
  return best;
}

}  // namespace palpate::app
