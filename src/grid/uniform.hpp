#pragma once

#include <cstdint>
#include <vector>

#include <palpate/settings.hpp>

#include "grid/cell_index.hpp"
#include "grid/lattice.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// The basic uniform grid of the paper, section 4.1: an array of cells, each with a dynamic array of
/// references. Built by one thread, which inserts the primitives one after the other. Cells keep the memory
/// of their arrays from build to build.
///
/// Deviations, both to bound memory: where the domain has more than most_cells_for(primitives) cells,
/// 2^shift() of them along each axis are one cell of this grid; and arrays that have kept much more memory
/// than the references need (primitives that wandered through many cells) are given back.
class UniformGrid {
 public:
  explicit UniformGrid(Order order = Order::linear) : index_(order) {}

  /// As CompactGrid::build. O(entries).
  template <class Footprint>
  void build(const parallel::Threads& threads, const Lattice& lattice, std::size_t count,
             Footprint&& footprint);

  /// Calls visit(reference) for each reference in the cells of `range`, in order of cells, then references.
  /// O(cells + visits).
  template <class Visit>
  void for_each(const CellRange& range, Visit&& visit) const;

  [[nodiscard]] int shift() const { return shift_; }
  [[nodiscard]] std::size_t bytes() const {
    return cells_.capacity() * sizeof(decltype(cells_)::value_type) +
           used_.capacity() * sizeof(decltype(used_)::value_type) + capacity_ * sizeof(Index);
  }

 private:
  void clear(const Cell& size, std::size_t primitives);  ///< empties the cells of the last build
  void insert(std::uint64_t cell, Index reference);

  CellIndex index_;
  int shift_ = 0;
  std::vector<std::vector<Index>> cells_;
  std::vector<std::uint64_t> used_;  ///< indices of the cells that are not empty
  std::size_t references_ = 0;
  std::size_t capacity_ = 0;  ///< sum of the capacities of the cells
};

template <class Footprint>
void UniformGrid::build(const parallel::Threads& /*threads*/, const Lattice& lattice, std::size_t count,
                        Footprint&& footprint) {
  clear(lattice.size(), count);
  for (std::size_t p = 0; p < count; ++p) {
    footprint(static_cast<Index>(p), [&](std::int32_t i, std::int32_t j, std::int32_t k) {
      insert(index_({i >> shift_, j >> shift_, k >> shift_}), static_cast<Index>(p));
    });
  }
}

template <class Visit>
void UniformGrid::for_each(const CellRange& range, Visit&& visit) const {
  if (references_ == 0) return;
  for (std::int32_t k = range.lower[2] >> shift_; k <= range.upper[2] >> shift_; ++k) {
    for (std::int32_t j = range.lower[1] >> shift_; j <= range.upper[1] >> shift_; ++j) {
      const std::uint64_t row = index_.part(1, j) + index_.part(2, k);
      for (std::int32_t i = range.lower[0] >> shift_; i <= range.upper[0] >> shift_; ++i) {
        for (const Index reference : cells_[row + index_.part(0, i)]) visit(reference);
      }
    }
  }
}

}  // namespace palpate
