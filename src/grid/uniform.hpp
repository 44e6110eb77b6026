#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include <palpate/settings.hpp>

#include "grid/cell_index.hpp"
#include "grid/lattice.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// The basic uniform grid of the paper, section 4.1: an array of cells, each with a dynamic array of
/// references. Built by one thread, which inserts the primitives one after the other.
///
/// Deviations: where the domain has more than most_cells_for(primitives) cells, 2^shift() of them along each
/// axis are one cell of this grid, so that memory is bounded. The dynamic arrays are blocks of one common
/// list. A full array moves to a block of twice the size, and its old block is reused. So entering an empty
/// cell allocates no memory, and cells that become empty keep none.
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
    return cells_.capacity() * sizeof(CellArray) + used_.capacity() * sizeof(std::uint64_t) +
           blocks_.capacity() * sizeof(Index);
  }

 private:
  /// The dynamic array of a cell: blocks_[begin, begin + size). Its block has room for the next power of two,
  /// and for two at least.
  struct CellArray {
    std::uint32_t begin = 0;
    std::uint32_t size = 0;
  };
  static constexpr std::uint32_t smallest_block = 2;
  static constexpr Index no_block = -1;

  void clear(const Cell& size, std::size_t primitives);  ///< empties the cells of the last build
  void insert(std::uint64_t cell, Index reference);
  /// A block of `size` (a power of two) items: a free one, or a new one at the end of the list.
  [[nodiscard]] std::uint32_t allocate_block(std::uint32_t size);
  void leave_block(std::uint32_t begin, std::uint32_t size);
  void keep_some_room(std::size_t capacity_before);

  CellIndex index_;
  int shift_ = 0;
  std::vector<CellArray> cells_;
  std::vector<std::uint64_t> used_;  ///< indices of the cells that are not empty
  std::vector<Index> blocks_;
  /// The first free block, by log2 of its size. Each free block holds the position of the next.
  std::array<Index, 32> left_blocks_{};
};

template <class Footprint>
void UniformGrid::build(const parallel::Threads& /*threads*/, const Lattice& lattice, std::size_t count,
                        Footprint&& footprint) {
  clear(lattice.size(), count);
  const std::size_t capacity = blocks_.capacity();
  for (std::size_t p = 0; p < count; ++p) {
    footprint(static_cast<Index>(p), [&](std::int32_t i, std::int32_t j, std::int32_t k) {
      insert(index_({i >> shift_, j >> shift_, k >> shift_}), static_cast<Index>(p));
    });
  }
  keep_some_room(capacity);
}

template <class Visit>
void UniformGrid::for_each(const CellRange& range, Visit&& visit) const {
  if (used_.empty()) return;
  for (std::int32_t k = range.lower[2] >> shift_; k <= range.upper[2] >> shift_; ++k) {
    for (std::int32_t j = range.lower[1] >> shift_; j <= range.upper[1] >> shift_; ++j) {
      const std::uint64_t row = index_.part(1, j) + index_.part(2, k);
      for (std::int32_t i = range.lower[0] >> shift_; i <= range.upper[0] >> shift_; ++i) {
        const CellArray& cell = cells_[row + index_.part(0, i)];
        for (std::uint32_t r = cell.begin; r < cell.begin + cell.size; ++r) visit(blocks_[r]);
      }
    }
  }
}

}  // namespace palpate
