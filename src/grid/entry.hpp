#pragma once

#include <palpate/types.hpp>

#include "sort/word.hpp"

namespace palpate {

/// One row of L (paper 4.2): the key of a cell and the primitive that covers it, as a word of the sorts. The
/// key is the cell index, or its leading bits where it has more than 31.
using Entry = std::uint64_t;

constexpr Entry make_entry(std::uint32_t key, Index reference) {
  return make_word(key, static_cast<std::uint32_t>(reference));
}
constexpr std::uint32_t cell_key_of(Entry entry) {
  return word_key(entry);
}
constexpr Index reference_of(Entry entry) {
  return static_cast<Index>(word_reference(entry));
}

/// Where the key begins in an entry.
inline constexpr int entry_key_bit = word_key_bit;

}  // namespace palpate
