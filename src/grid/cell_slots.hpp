#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "grid/lattice.hpp"

namespace palpate {

/// Approximate collision detection (paper 5): a primitive has K slots for the cells that it covers. One that
/// covers more divides its slots among them by random choice; the cells left out are counted, and what only
/// they would have shown is missed. The choice is a hash of (primitive, step, slot), so it has the same bits
/// for every thread count, and changes from step to step so that no cell is left out for good.
class CellSlots {
 public:
  static constexpr int most = 27;

  /// \param slots  K in [1, 27]; 0: every cell has a slot (exact)
  /// \param step   number of the detection
  explicit CellSlots(int slots = 0, std::uint64_t step = 0) : slots_(slots), step_(step) {}

  /// K; 0 where every cell has a slot.
  [[nodiscard]] int count() const { return slots_; }
  [[nodiscard]] bool exact() const { return slots_ == 0; }
  /// Whether a footprint of so many cells has more cells than slots.
  [[nodiscard]] bool overflows(std::uint64_t cells) const {
    return slots_ != 0 && cells > static_cast<std::uint64_t>(slots_);
  }
  /// How many of `cells` are left out.
  [[nodiscard]] std::uint64_t left_out(std::uint64_t cells) const {
    return overflows(cells) ? cells - static_cast<std::uint64_t>(slots_) : 0;
  }

  /// K different numbers out of [0, cells), ascending, each subset as likely as any other (Floyd's algorithm;
  /// Bentley & Floyd, "A sample of brilliance", 1987). For footprints that overflow. O(K^2).
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
