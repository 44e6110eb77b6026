#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace palpate::test {

/// The words (key, reference) of all references that have a key, by std::stable_sort.
inline std::vector<std::uint64_t> stably_sorted(std::span<const std::uint32_t> keys) {
  std::vector<std::uint64_t> words;
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (keys[i] != 0xFFFFFFFFU) words.push_back((std::uint64_t{keys[i]} << 32) | i);
  std::stable_sort(words.begin(), words.end(), [](auto a, auto b) { return (a >> 32) < (b >> 32); });
  return words;
}

/// Where the words of each key begin: counts, summed up.
inline std::vector<std::uint32_t> cell_starts(std::span<const std::uint64_t> words, std::size_t key_count) {
  std::vector<std::uint32_t> begin(key_count + 1, 0);
  for (const std::uint64_t word : words) ++begin.at((word >> 32) + 1);
  for (std::size_t k = 0; k < key_count; ++k) begin[k + 1] += begin[k];
  return begin;
}

}  // namespace palpate::test
