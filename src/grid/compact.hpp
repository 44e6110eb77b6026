#pragma once

#include <cassert>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <palpate/settings.hpp>

#include "grid/cell_index.hpp"
#include "grid/entry.hpp"
#include "grid/fixed_positions.hpp"
#include "grid/footprints.hpp"
#include "grid/lattice.hpp"
#include "parallel/parallel.hpp"
#include "room.hpp"
#include "sort/comparison.hpp"
#include "sort/point_sort.hpp"
#include "sort/radix.hpp"
#include "sort/word.hpp"

namespace palpate {

/// The compact grid of the paper, section 4.2 (Lagae & Dutre, "Compact, fast and robust grids for ray
/// tracing", 2008), built in parallel by index sort (Kalojanov & Slusallek, "A parallel algorithm for
/// construction of uniform grids", 2009): count the cells that each primitive covers, write an entry (cell,
/// reference) for each, sort L by cell, and take the cell starts C from it.
///
/// Deviation: C is bounded. In a domain of more than most_cells_for(primitives) cells, one start of C is
/// common to 2^start_shift() consecutive keys. A query finds its keys among them by bisection in L, which
/// stays sorted. A key is the cell index while that fits the 32 bits of an entry; in still larger domains
/// 2^key_shift() cells have the same key. A query then also visits primitives of neighbouring cells. Contacts
/// stay exact, since all candidates are tested.
///
/// Queries need build(), for_each() and bytes() of a structure; see also brute.hpp.
class CompactGrid {
 public:
  explicit CompactGrid(Order order = Order::linear, Sort sort = Sort::adaptive)
      : index_(order), sort_(sort), point_sort_(sort) {}

  /// Rebuilds the grid over `count` primitives. `footprint(p, emit)` must call emit(i, j, k) for each cell
  /// that primitive p covers, and the same cells in both calls. O(entries + primitives).
  template <class Footprint>
  void build(const parallel::Threads& threads, const Lattice& lattice, std::size_t count,
             Footprint&& footprint);

  /// Approximate mode (paper 5): as build(), but L is a static array with `slots` entries for each primitive,
  /// of which `footprint` fills at most `slots`. Unused entries get a key above that of all cells, and are
  /// sorted to the end. No counting pass is needed. O(count x slots).
  template <class Footprint>
  void build_slots(const parallel::Threads& threads, const Lattice& lattice, std::size_t count,
                   std::size_t slots, Footprint&& footprint);

  /// Rebuilds the grid over `count` points: `cell_of(p)` gives the cell of point p, or none for a point that
  /// is left out. A point has at most one entry, so the order of the last frame can be repaired
  /// (Sort::repair) instead of a full sort. Returns the sort that was used. O(points + cells) at most for
  /// counting and repair.
  template <class CellOf>
  Sort build_points(const parallel::Threads& threads, const Lattice& lattice, std::size_t count,
                    CellOf&& cell_of);

  /// build_points() for fixed positions, at the cells that they have in the lattice.
  Sort build_points(const parallel::Threads& threads, const Lattice& lattice, const FixedPositions& points);
  /// Call instead of a build in a frame that needs no grid: only counts movers. L and C stay, and the next
  /// build does a full sort.
  void skip_points(const parallel::Threads& threads, const Lattice& lattice, const FixedPositions& points);
  /// Movers of the last frame (built or skipped): points whose key changed since the frame before. All points
  /// in the first frame.
  [[nodiscard]] std::size_t movers() const { return movers_; }
  /// The switch of Sort::adaptive.
  [[nodiscard]] SortSwitch& adaptive_switch() { return point_sort_.adaptive_switch(); }
  [[nodiscard]] const SortSwitch& adaptive_switch() const { return point_sort_.adaptive_switch(); }
  /// Whether each key is one cell.
  [[nodiscard]] bool distinguishes_cells() const { return key_shift_ == 0; }

  /// Calls visit(reference) for each entry in the cells of `range`; a primitive that covers several of them
  /// is visited several times. O(rows of cells + visits) in linear order, O(cells + visits) in Z-order, and
  /// never more than O(entries).
  template <class Visit>
  void for_each(const CellRange& range, Visit&& visit) const;

  /// Calls visit(begin, end) for intervals of L, none twice, that hold all entries in the cells of `range`,
  /// and possibly other entries, where the range has more cells than there are entries. Same cost as
  /// for_each().
  template <class Visit>
  void for_each_interval(const CellRange& range, Visit&& visit) const;

  /// Whether for_each_interval() gives no other entries.
  [[nodiscard]] bool finds_only(const CellRange& range) const {
    return distinguishes_cells() && !reads_entries(range);
  }

  /// Prefetches the memory that for_each_interval() reads first.
  void prefetch_rows(const CellRange& range) const {
#if defined(__GNUC__)
    if (index_.order() != Order::linear || range.along(1) * range.along(2) > most_prefetched) return;
    for (std::int32_t k = range.lower[2]; k <= range.upper[2]; ++k) {
      for (std::int32_t j = range.lower[1]; j <= range.upper[1]; ++j)
        __builtin_prefetch(&cell_begin_[key_of(index_({range.lower[0], j, k})) >> start_shift_]);
    }
#endif
  }

  /// L: entries sorted by key, then reference; the unused ones of build_slots() last.
  [[nodiscard]] std::span<const Entry> entries() const {
    return entries_;
  }
  /// C: keys [b, b + 1) << start_shift() have the entries [cell_begin[b], cell_begin[b + 1]).
  [[nodiscard]] std::span<const std::uint32_t> cell_begin() const {
    return cell_begin_;
  }
  [[nodiscard]] int key_shift() const {
    return key_shift_;
  }
  [[nodiscard]] int start_shift() const {
    return start_shift_;
  }
  [[nodiscard]] std::size_t bytes() const {
    return entries_.capacity() * sizeof(Entry) + cell_begin_.capacity() * sizeof(std::uint32_t);
  }

 private:
  /// Entries [begin, end) of L.
  struct Interval {
    std::uint32_t begin;
    std::uint32_t end;
  };

  void choose_shifts(std::size_t primitives);
  void write_keys(const parallel::Threads& threads, const Lattice& lattice, const FixedPositions& points);
  Sort sort_points(const parallel::Threads& threads);  ///< by keys_
  void sort_entries(const parallel::Threads& threads, std::uint32_t largest_key);
  void index_entries(const parallel::Threads& threads);  ///< derives C
  [[nodiscard]] std::uint32_t key_of(std::uint64_t index) const {
    return static_cast<std::uint32_t>(index >> key_shift_);
  }
  [[nodiscard]] Interval within(Interval block, std::uint32_t first, std::uint32_t last) const;
  /// The interval of the entries with first <= key <= last.
  [[nodiscard]] Interval entries_of(std::uint32_t first, std::uint32_t last) const {
    const Interval block{cell_begin_[first >> start_shift_],
                         cell_begin_[std::size_t{last >> start_shift_} + 1]};
    return start_shift_ == 0 ? block : within(block, first, last);
  }
  template <class Visit>
  void visit_keys(std::uint32_t first, std::uint32_t last, Visit&& visit) const {
    const Interval interval = entries_of(first, last);
    visit(interval.begin, interval.end);
  }
  template <class Visit>
  void visit_rows(const CellRange& range, Visit&& visit) const;
  template <class Visit>
  void visit_linear(const CellRange& range, Visit&& visit) const;
  template <class Visit>
  void visit_z(const CellRange& blocks, Visit&& visit) const;
  /// The range in blocks of cells that share a key (Z-order).
  [[nodiscard]] CellRange blocks_of(CellRange range) const;
  /// Whether a range has more cells (or rows of them) than there are entries.
  [[nodiscard]] bool reads_entries(const CellRange& range) const;

  static constexpr std::uint64_t most_prefetched = 64;

  CellIndex index_;
  int key_shift_ = 0;
  int start_shift_ = 0;
  std::array<int, 3> block_bits_{};  ///< Z-order: log2 of the cells of one key along each axis
  std::vector<Entry> entries_;
  std::vector<std::uint32_t> cell_begin_;
  std::vector<std::size_t> chunk_begin_;
  std::vector<std::uint32_t> keys_;         ///< of points
  std::vector<std::uint32_t> keys_before_;  ///< of the last frame, if it was skipped
  std::vector<double> mover_scratch_;
  bool skipped_ = false;
  std::size_t movers_ = 0;
  Sort sort_;
  PointSort point_sort_;
  RadixSort radix_sort_;
  ComparisonSort comparison_sort_;
};

template <class Footprint>
void CompactGrid::build(const parallel::Threads& threads, const Lattice& lattice, std::size_t count,
                        Footprint&& footprint) {
  index_.resize(lattice.size());
  choose_shifts(count);
  write_footprints(
      threads, count, chunk_begin_, footprint,
      [&](std::size_t n) {
        require_countable(n);
        resize_with_room(entries_, n);
      },
      [&](std::size_t e, Index p, const Cell& cell) { entries_[e] = make_entry(key_of(index_(cell)), p); });
  sort_entries(threads, key_of(index_.last()));
  index_entries(threads);
}

template <class Footprint>
void CompactGrid::build_slots(const parallel::Threads& threads, const Lattice& lattice, std::size_t count,
                              std::size_t slots, Footprint&& footprint) {
  index_.resize(lattice.size());
  choose_shifts(count);
  require_countable(count * slots);
  resize_with_room(entries_, count * slots);
  const std::uint32_t unused = key_of(index_.last()) + 1;
  parallel::for_each(threads, count, 2048, [&](std::size_t p) {
    const auto reference = static_cast<Index>(p);
    std::size_t e = p * slots;
    footprint(reference, [&](std::int32_t i, std::int32_t j, std::int32_t k) {
      assert(e < (p + 1) * slots);
      entries_[e++] = make_entry(key_of(index_({i, j, k})), reference);
    });
    while (e < (p + 1) * slots) entries_[e++] = make_entry(unused, reference);
  });
  sort_entries(threads, unused);
  index_entries(threads);
}

template <class CellOf>
Sort CompactGrid::build_points(const parallel::Threads& threads, const Lattice& lattice, std::size_t count,
                               CellOf&& cell_of) {
  index_.resize(lattice.size());
  choose_shifts(count);
  keys_.resize(count);
  parallel::for_each(threads, count, 2048, [&](std::size_t p) {
    const std::optional<Cell> cell = cell_of(static_cast<Index>(p));
    keys_[p] = cell ? key_of(index_(*cell)) : no_key;
  });
  return sort_points(threads);
}

template <class Visit>
void CompactGrid::for_each(const CellRange& range, Visit&& visit) const {
  // Where reading the entries is cheaper than looking up cells, compare the cell of each entry.
  const bool asks = key_shift_ == 0 && reads_entries(range);
  for_each_interval(range, [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t e = begin; e < end; ++e) {
      if (asks && !range.contains(index_.cell_of(cell_key_of(entries_[e])))) continue;
      visit(reference_of(entries_[e]));
    }
  });
}

template <class Visit>
void CompactGrid::for_each_interval(const CellRange& range, Visit&& visit) const {
  if (entries_.empty()) return;
  if (reads_entries(range))
    return visit_keys(key_of(index_(range.lower)), key_of(index_(range.upper)), visit);
  if (index_.order() == Order::linear) {
    return key_shift_ + start_shift_ == 0 ? visit_rows(range, visit) : visit_linear(range, visit);
  }
  visit_z(blocks_of(range), visit);
}

inline CellRange CompactGrid::blocks_of(CellRange range) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    range.lower[axis] >>= block_bits_[axis];
    range.upper[axis] >>= block_bits_[axis];
  }
  return range;
}

inline bool CompactGrid::reads_entries(const CellRange& range) const {
  if (index_.order() == Order::linear) return range.along(1) * range.along(2) > entries_.size();
  return blocks_of(range).count() > entries_.size();
}

/// If each cell has its own start, a row is given by two starts.
template <class Visit>
void CompactGrid::visit_rows(const CellRange& range, Visit&& visit) const {
  const auto length = static_cast<std::size_t>(range.along(0));
  for (std::int32_t k = range.lower[2]; k <= range.upper[2]; ++k) {
    const std::uint32_t* start = &cell_begin_[index_({range.lower[0], range.lower[1], k})];
    for (std::int32_t j = range.lower[1]; j <= range.upper[1]; ++j) {
      visit(start[0], start[length]);
      start += index_.part(1, 1);
    }
  }
}

/// A row of cells along x is one interval of L. Rows ascend, so a key common to two rows is left out of the
/// second.
template <class Visit>
void CompactGrid::visit_linear(const CellRange& range, Visit&& visit) const {
  std::uint64_t next = 0;
  for (std::int32_t k = range.lower[2]; k <= range.upper[2]; ++k) {
    for (std::int32_t j = range.lower[1]; j <= range.upper[1]; ++j) {
      const std::uint64_t row = index_.part(1, j) + index_.part(2, k);
      const std::uint64_t first =
          std::max<std::uint64_t>(next, key_of(row + static_cast<std::uint64_t>(range.lower[0])));
      const std::uint64_t last = key_of(row + static_cast<std::uint64_t>(range.upper[0]));
      if (first > last) continue;
      visit_keys(static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last), visit);
      next = last + 1;
    }
  }
}

/// The cells of a key form a block, so the keys of a range belong to a range of blocks. Neighbours along x
/// that are consecutive on the curve are one interval of L.
template <class Visit>
void CompactGrid::visit_z(const CellRange& blocks, Visit&& visit) const {
  const auto part = [&](std::size_t axis, std::int32_t block) {
    return index_.part(axis, block << block_bits_[axis]);
  };
  for (std::int32_t k = blocks.lower[2]; k <= blocks.upper[2]; ++k) {
    for (std::int32_t j = blocks.lower[1]; j <= blocks.upper[1]; ++j) {
      const std::uint64_t row = part(1, j) + part(2, k);
      std::uint32_t first = key_of(row + part(0, blocks.lower[0]));
      std::uint32_t last = first;
      for (std::int32_t i = blocks.lower[0] + 1; i <= blocks.upper[0]; ++i) {
        const std::uint32_t key = key_of(row + part(0, i));
        if (key != last + 1) {
          visit_keys(first, last, visit);
          first = key;
        }
        last = key;
      }
      visit_keys(first, last, visit);
    }
  }
}

}  // namespace palpate
