#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <palpate/types.hpp>

namespace palpate::app {

/// Triangles in a regular grid of cells, to find how far the nearest is.
class NearTriangles {
 public:
  /// At least one; `cell` is the edge of a cell, about as long as theirs. O(triangles).
  NearTriangles(std::vector<std::array<Vec3, 3>> triangles, double cell);
  /// Distance from p to the nearest triangle. O(triangles near p, and cells on the way).
  [[nodiscard]] double distance(const Vec3& p) const;

 private:
  [[nodiscard]] std::array<int, 3> cell_of(const Vec3& p) const;
  [[nodiscard]] std::size_t index(const std::array<int, 3>& cell) const;

  std::vector<std::array<Vec3, 3>> triangles_;
  double cell_;
  Vec3 lower_{};
  std::array<int, 3> size_{};
  std::vector<std::size_t> begin_;  ///< (n_cells + 1), of the triangles of a cell
  std::vector<std::size_t> list_;   ///< triangles of all cells
};

}  // namespace palpate::app
