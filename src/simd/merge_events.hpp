#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace palpate::simd {

/// Marks an event that takes its word out; without it the word is put in. References have 31 bits, so the bit
/// is free in every word.
inline constexpr std::uint64_t removal = std::uint64_t{1} << 31;

/// Merges events into sorted words: `merged` gets those of `words` that no event removes, and the inserted
/// ones, sorted. Exact and complete: `merged` must have words + insertions - removals places.
/// \param words   sorted
/// \param events  sorted without their mark; each removal names one of `words`, no insertion does
/// O(words + events).
void merge_events(std::span<const std::uint64_t> words, std::span<const std::uint64_t> events,
                  std::span<std::uint64_t> merged);

namespace scalar {
/// The twin of simd::merge_events in plain C++.
void merge_events(std::span<const std::uint64_t> words, std::span<const std::uint64_t> events,
                  std::span<std::uint64_t> merged);
}  // namespace scalar

}  // namespace palpate::simd
