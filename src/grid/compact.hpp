#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/settings.hpp>

#include "grid/entry.hpp"
#include "grid/lattice.hpp"
#include "parallel/parallel.hpp"
#include "sort/radix.hpp"

namespace palpate {

/// The compact grid of the paper, section 4.2 (Lagae & Dutre, "Compact, fast and robust grids for ray
/// tracing", 2008), built in parallel by index sort (Kalojanov & Slusallek, "A parallel algorithm for
/// construction of uniform grids", 2009): count the cells that each primitive covers, write an entry (cell,
/// reference) for each, sort L by cell, and take the cell starts C from it.
///
/// A structure, as the queries use it, has build(), for_each() and bytes(); see also brute.hpp.
class CompactGrid {
 public:
  /// Rebuilds the grid over `count` primitives. `footprint(p, emit)` must call emit(i, j, k) for each cell
  /// that primitive p covers, and do the same both times it is called. O(entries + cells).
  template <class Footprint>
  void build(const parallel::Threads& threads, const Lattice& lattice, std::size_t count,
             Footprint&& footprint);

  /// Calls visit(reference) for each entry in the cells of `range`; a primitive that covers several comes as
  /// often.
  template <class Visit>
  void for_each(const CellRange& range, Visit&& visit) const;

  /// L: entries sorted by cell index, then reference.
  [[nodiscard]] std::span<const Entry> entries() const { return entries_; }
  /// C: cell c has the entries [cell_begin[c], cell_begin[c + 1]).
  [[nodiscard]] std::span<const std::uint32_t> cell_begin() const { return cell_begin_; }
  [[nodiscard]] std::size_t bytes() const {
    return entries_.capacity() * sizeof(Entry) + cell_begin_.capacity() * sizeof(std::uint32_t);
  }

 private:
  static constexpr std::size_t grain_ = 2048;  ///< primitives of a chunk

  void index_entries(const parallel::Threads& threads);  ///< sorts L and derives C
  void reserve_entries();                                ///< chunk counts to chunk starts, and room for L

  Lattice lattice_;
  std::vector<Entry> entries_;
  std::vector<std::uint32_t> cell_begin_;
  std::vector<std::size_t> chunk_begin_;
  RadixSort sort_;
};

template <class Footprint>
void CompactGrid::build(const parallel::Threads& threads, const Lattice& lattice, std::size_t count,
                        Footprint&& footprint) {
  lattice_ = lattice;
  chunk_begin_.assign(parallel::chunk_count(count, grain_) + 1, 0);
  parallel::for_chunks(threads, count, grain_, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
    std::size_t covered = 0;
    for (std::size_t p = begin; p < end; ++p) {
      footprint(static_cast<Index>(p), [&](std::int32_t, std::int32_t, std::int32_t) { ++covered; });
    }
    chunk_begin_[chunk + 1] = covered;
  });
  reserve_entries();
  parallel::for_chunks(threads, count, grain_, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
    std::size_t next = chunk_begin_[chunk];
    for (std::size_t p = begin; p < end; ++p) {
      footprint(static_cast<Index>(p), [&](std::int32_t i, std::int32_t j, std::int32_t k) {
        entries_[next++] = make_entry(lattice_.linear_index(i, j, k), static_cast<Index>(p));
      });
    }
  });
  index_entries(threads);
}

template <class Visit>
void CompactGrid::for_each(const CellRange& range, Visit&& visit) const {
  if (entries_.empty()) return;
  // A row of cells along x is one interval of L.
  for (std::int32_t k = range.lower[2]; k <= range.upper[2]; ++k) {
    for (std::int32_t j = range.lower[1]; j <= range.upper[1]; ++j) {
      const std::uint32_t first = cell_begin_[lattice_.linear_index(range.lower[0], j, k)];
      const std::uint32_t last = cell_begin_[lattice_.linear_index(range.upper[0], j, k) + 1];
      for (std::uint32_t e = first; e < last; ++e) visit(reference_of(entries_[e]));
    }
  }
}

}  // namespace palpate
