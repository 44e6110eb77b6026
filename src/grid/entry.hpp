#pragma once

#include <cstdint>

#include <palpate/types.hpp>

namespace palpate {

/// One row of L (paper 4.2): the key of a cell and the primitive that covers it, in one word. The order of
/// the words is that of (key, reference), so there is one sorted L and every sort finds it. The key is the
/// cell index, or its leading bits where it has more than 32.
using Entry = std::uint64_t;

constexpr Entry make_entry(std::uint32_t key, Index reference) {
  return (Entry{key} << 32) | static_cast<std::uint32_t>(reference);
}
constexpr std::uint32_t cell_key_of(Entry entry) {
  return static_cast<std::uint32_t>(entry >> 32);
}
constexpr Index reference_of(Entry entry) {
  return static_cast<Index>(static_cast<std::uint32_t>(entry));
}

/// Where the key begins in an entry.
inline constexpr int entry_key_bit = 32;

}  // namespace palpate
