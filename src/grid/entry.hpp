#pragma once

#include <cstdint>

#include <palpate/types.hpp>

namespace palpate {

/// One row of L (paper 4.2): a cell index and the primitive that covers this cell, in one word. The order of
/// the words is that of (cell index, reference), so there is one sorted L and every sort finds it.
using Entry = std::uint64_t;

constexpr Entry make_entry(std::uint32_t cell_index, Index reference) {
  return (Entry{cell_index} << 32) | static_cast<std::uint32_t>(reference);
}
constexpr std::uint32_t cell_index_of(Entry entry) {
  return static_cast<std::uint32_t>(entry >> 32);
}
constexpr Index reference_of(Entry entry) {
  return static_cast<Index>(static_cast<std::uint32_t>(entry));
}

/// Where the cell index begins in an entry.
inline constexpr int entry_key_bit = 32;

}  // namespace palpate
