#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "parallel/parallel.hpp"
#include "sort/word.hpp"

namespace palpate {

inline constexpr int most_digit_bits = 11;
/// Words of a chunk: a histogram of that many bits (8 KiB) is small beside them.
inline constexpr std::size_t digit_grain = std::size_t{1} << 15;

/// The grain of a digit pass. The passes are stable, so the result does not depend on it. A single thread
/// uses one chunk, which needs only one histogram.
inline std::size_t digit_grain_for(const parallel::Threads& threads, std::size_t items) {
  return threads.count() == 1 ? std::max<std::size_t>(items, 1) : digit_grain;
}

/// Turns counts (chunks x digits) into write positions: all of digit 0 in chunk order, then digit 1, and so
/// on. Returns the largest count of one digit over all chunks.
inline std::size_t counts_to_positions(std::span<std::uint32_t> histograms, std::size_t chunks,
                                       std::size_t digits) {
  std::uint32_t position = 0;
  std::uint32_t largest = 0;
  for (std::size_t digit = 0; digit < digits; ++digit) {
    const std::uint32_t before = position;
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
      std::uint32_t& slot = histograms[chunk * digits + digit];
      const std::uint32_t count = slot;
      slot = position;
      position += count;
    }
    largest = std::max(largest, position - before);
  }
  return largest;
}

/// Writes a word for each reference with a key, in stable order of the digit (key >> shift) & (digits - 1).
/// Those without a key get the digit `digits` and come last. `words` has keys.size() places.
/// \param digits       a power of two; higher bits of keys are ignored
/// \param histograms   scratch; holds the end of each digit in each chunk afterwards (chunks x (digits + 1))
/// \param digit_begin  where each digit begins, and where those without a key do (digits + 1)
void scatter_keys(const parallel::Threads& threads, std::span<const std::uint32_t> keys, int shift,
                  std::size_t digits, std::vector<std::uint32_t>& histograms,
                  std::vector<std::uint32_t>& digit_begin, std::span<std::uint64_t> words);

}  // namespace palpate
