#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace palpate::simd {

/// Marks an event that removes its word; an event without it inserts the word. References have 31 bits, so
/// the bit is free in every word.
inline constexpr std::uint64_t removal = std::uint64_t{1} << 31;

/// Merges events into sorted words: `merged` gets the words that no event removes and the inserted ones,
/// sorted. `merged` must have exactly words + insertions - removals places.
/// \param words   sorted
/// \param events  sorted with the mark cleared; each removal is one of `words`, no insertion is
///
/// O(words + events).
void merge_events(std::span<const std::uint64_t> words, std::span<const std::uint64_t> events,
                  std::span<std::uint64_t> merged);

namespace scalar {
/// simd::merge_events in plain C++.
void merge_events(std::span<const std::uint64_t> words, std::span<const std::uint64_t> events,
                  std::span<std::uint64_t> merged);
}  // namespace scalar

}  // namespace palpate::simd
