#include "grid/cell_slots.hpp"

#include <algorithm>

namespace palpate {
namespace {

/// SplitMix64's finaliser (Steele, Lea & Flood 2014).
constexpr std::uint64_t mixed(std::uint64_t z) {
  z += 0x9E3779B97F4A7C15U;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31U);
}

}  // namespace

std::span<const std::uint64_t> CellSlots::choose(std::uint64_t primitive, std::uint64_t cells,
                                                 std::array<std::uint64_t, most>& chosen) const {
  const std::uint64_t key = mixed(mixed(primitive) ^ step_);
  const auto slots = static_cast<std::uint64_t>(slots_);
  std::size_t count = 0;
  for (std::uint64_t last = cells - slots; last < cells; ++last) {
    const auto end = chosen.begin() + static_cast<std::ptrdiff_t>(count);
    const std::uint64_t pick = mixed(key + count) % (last + 1);
    chosen[count++] = std::find(chosen.begin(), end, pick) == end ? pick : last;
  }
  const auto result = std::span(chosen).first(count);
  std::sort(result.begin(), result.end());
  return result;
}

}  // namespace palpate
