#pragma once

#include <cstdint>
#include <vector>

#include "grid/lattice.hpp"
#include "parallel/parallel.hpp"
#include "room.hpp"

namespace palpate {

/// Spatial hashing (Teschner et al., "Optimized spatial hashing for collision detection of deformable
/// objects", 2003; paper 4.3, eq. 3), chained, built by one thread as in the paper.
///
/// Each link holds the coordinates of its cell, so that cells with the same hash are distinguished.
/// Deviations: cells are counted from the corner of the domain, not from the origin; the lists are index
/// chains in one array that is reused, so a steady build allocates nothing; the table has a prime number of
/// slots, at least twice and at most 16 times as many as primitives.
class HashGrid {
 public:
  /// As CompactGrid::build. O(entries + slots).
  template <class Footprint>
  void build(const parallel::Threads& threads, const Lattice& lattice, std::size_t count,
             Footprint&& footprint);

  /// Calls visit(reference) for each entry in the cells of `range`, in a cell the last inserted first.
  /// Expected O(cells + visits), and never more than O(entries) steps where there are more cells.
  template <class Visit>
  void for_each(const CellRange& range, Visit&& visit) const;

  /// Slots of the table: m of eq. 3.
  [[nodiscard]] std::size_t slots() const { return head_.size(); }
  [[nodiscard]] std::size_t bytes() const {
    return head_.capacity() * sizeof(head_[0]) + links_.capacity() * sizeof(Link);
  }

 private:
  /// An entry of a list: one primitive in one cell.
  struct Link {
    std::uint64_t cell;  ///< its coordinates, 21 bits each
    Index reference;
    Index next;  ///< of the same slot; -1 ends the list
  };

  static std::uint64_t packed(std::int32_t i, std::int32_t j, std::int32_t k) {
    return static_cast<std::uint64_t>(i) | static_cast<std::uint64_t>(j) << 21 |
           static_cast<std::uint64_t>(k) << 42;
  }
  static Cell unpacked(std::uint64_t cell) {
    constexpr std::uint64_t mask = (1U << 21) - 1;
    return {static_cast<std::int32_t>(cell & mask), static_cast<std::int32_t>((cell >> 21) & mask),
            static_cast<std::int32_t>(cell >> 42)};
  }
  /// Eq. 3, in arithmetic modulo 2^32.
  [[nodiscard]] std::size_t slot_of(std::int32_t i, std::int32_t j, std::int32_t k) const {
    const std::uint32_t hash = static_cast<std::uint32_t>(i) * 73856093U ^
                               static_cast<std::uint32_t>(j) * 19349663U ^
                               static_cast<std::uint32_t>(k) * 83492791U;
    return hash % static_cast<std::uint32_t>(head_.size());
  }
  void clear(std::size_t primitives);
  void insert(std::int32_t i, std::int32_t j, std::int32_t k, Index reference);

  std::vector<Index> head_;  ///< (slots) first link of each list, -1 where it is empty
  std::vector<Link> links_;
};

template <class Footprint>
void HashGrid::build(const parallel::Threads& /*threads*/, const Lattice& /*lattice*/, std::size_t count,
                     Footprint&& footprint) {
  clear(count);
  const std::size_t capacity = links_.capacity();
  for (std::size_t p = 0; p < count; ++p) {
    footprint(static_cast<Index>(p), [&](std::int32_t i, std::int32_t j, std::int32_t k) {
      insert(i, j, k, static_cast<Index>(p));
    });
  }
  keep_room(links_, capacity, links_.size() / 8);
}

template <class Visit>
void HashGrid::for_each(const CellRange& range, Visit&& visit) const {
  if (range.count() > links_.size()) {
    for (const Link& link : links_) {
      if (range.contains(unpacked(link.cell))) visit(link.reference);
    }
    return;
  }
  for (std::int32_t k = range.lower[2]; k <= range.upper[2]; ++k) {
    for (std::int32_t j = range.lower[1]; j <= range.upper[1]; ++j) {
      for (std::int32_t i = range.lower[0]; i <= range.upper[0]; ++i) {
        const std::uint64_t cell = packed(i, j, k);
        for (Index l = head_[slot_of(i, j, k)]; l >= 0; l = at(links_, l).next) {
          if (at(links_, l).cell == cell) visit(at(links_, l).reference);
        }
      }
    }
  }
}

}  // namespace palpate
