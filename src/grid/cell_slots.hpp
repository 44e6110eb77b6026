#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "grid/lattice.hpp"

namespace palpate {

/// Approximate collision detection (paper 5): a primitive has K slots for the cells that it covers. If it
/// covers more, K of them are chosen at random. Cells left out are counted; contacts that only they would
/// have shown are missed. The choice is a hash of (primitive, step, slot). So it is the same for every thread
/// count, and changes from step to step, so that no cell is left out for ever.
class CellSlots {
 public:
  static constexpr int most = 27;

  /// \param slots  K in [1, 27]; 0: every cell has a slot (exact)
  /// \param step   number of the detection
  explicit CellSlots(int slots = 0, std::uint64_t step = 0) : slots_(slots), step_(step) {}

  /// K; 0 where every cell has a slot.
  [[nodiscard]] int count() const { return slots_; }
  [[nodiscard]] bool exact() const { return slots_ == 0; }
  /// Whether a footprint of `cells` cells has more cells than slots.
  [[nodiscard]] bool overflows(std::uint64_t cells) const {
    return slots_ != 0 && cells > static_cast<std::uint64_t>(slots_);
  }
  /// The number of cells that are left out.
  [[nodiscard]] std::uint64_t left_out(std::uint64_t cells) const {
    return overflows(cells) ? cells - static_cast<std::uint64_t>(slots_) : 0;
  }

  /// K different numbers of [0, cells), ascending; all subsets are equally likely (Floyd's algorithm; Bentley
  /// & Floyd, "A sample of brilliance", 1987). For footprints that overflow. O(K^2).
  [[nodiscard]] std::span<const std::uint64_t> choose(std::uint64_t primitive, std::uint64_t cells,
                                                      std::array<std::uint64_t, most>& chosen) const;

  /// Calls visit(range) for the cells of `range` that have a slot: all at once, or K single cells.
  template <class Visit>
  void for_each_range(std::uint64_t primitive, const CellRange& range, Visit&& visit) const {
    const std::uint64_t cells = range.count();
    if (!overflows(cells)) return visit(range);
    std::array<std::uint64_t, most> storage{};
    for (const std::uint64_t n : choose(primitive, cells, storage)) {
      const Cell cell{range.lower[0] + static_cast<std::int32_t>(n % range.along(0)),
                      range.lower[1] + static_cast<std::int32_t>(n / range.along(0) % range.along(1)),
                      range.lower[2] + static_cast<std::int32_t>(n / (range.along(0) * range.along(1)))};
      visit(CellRange{cell, cell});
    }
  }

 private:
  int slots_;
  std::uint64_t step_;
};

}  // namespace palpate
