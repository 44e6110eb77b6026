#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/settings.hpp>

#include "grid/compact.hpp"
#include "grid/fixed_positions.hpp"
#include "grid/lattice.hpp"
#include "parallel/parallel.hpp"
#include "simd/fixed_points.hpp"

namespace palpate {

/// The compact grid of fixed positions, with the coarse coordinates of its points in the order of L, as
/// kernels read them (docs/query.md).
class PointGrid {
 public:
  explicit PointGrid(Order order = Order::linear, Sort sort = Sort::adaptive) : cells_(order, sort) {}

  /// Rebuilds the grid; returns the sort that was used. Parallel, O(points + cells).
  Sort build(const parallel::Threads& threads, const Lattice& lattice, const FixedPositions& points);
  /// Call instead of build() in a frame that needs no grid: only counts movers.
  void skip(const parallel::Threads& threads, const Lattice& lattice, const FixedPositions& points) {
    cells_.skip_points(threads, lattice, points);
  }

  [[nodiscard]] const CompactGrid& cells() const { return cells_; }
  [[nodiscard]] CompactGrid& cells() { return cells_; }
  /// The points in the order of L. \param points  of the last build(), or newer positions of the same points
  [[nodiscard]] simd::PointRows rows(const FixedPositions& points) const {
    return {points.points().data(), words_.data(), names_.data(), points.coarse_shift()};
  }
  [[nodiscard]] std::size_t bytes() const {
    return cells_.bytes() + (words_.capacity() + names_.capacity()) * sizeof(std::int32_t);
  }

 private:
  void put_in_order(const parallel::Threads& threads, const FixedPositions& points);

  CompactGrid cells_;
  std::vector<std::int32_t> words_;  ///< in the order of L
  std::vector<std::int32_t> names_;
};

}  // namespace palpate
