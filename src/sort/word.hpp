#pragma once

#include <cstdint>

namespace palpate {

/// The words that are sorted: key in the high 32 bits, reference (below 2^31) in the low ones. Words are
/// ordered by (key, reference), so the sorted list is unique and every sort gives it.
constexpr std::uint64_t make_word(std::uint32_t key, std::uint32_t reference) {
  return (std::uint64_t{key} << 32) | reference;
}
constexpr std::uint32_t word_key(std::uint64_t word) {
  return static_cast<std::uint32_t>(word >> 32);
}
constexpr std::uint32_t word_reference(std::uint64_t word) {
  return static_cast<std::uint32_t>(word);
}

/// Where the key begins in a word.
inline constexpr int word_key_bit = 32;

/// The key of a reference that has no word.
inline constexpr std::uint32_t no_key = 0xFFFFFFFFU;

}  // namespace palpate
