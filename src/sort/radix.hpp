#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "parallel/parallel.hpp"

namespace palpate {

/// Parallel radix sort, least significant digit first; stable. Keys of b bits take ceil(b / 11) passes with
/// digits of equal width: more than 2^11 open write positions are slower (docs/notes/benchmarks.md).
class RadixSort {
 public:
  /// Sorts `words` by the bits from `first_bit` up to the highest bit set in `largest`; digits above it are
  /// ignored, so `largest` must be >= each word. O(words x digits); keeps its scratch memory.
  void operator()(const parallel::Threads& threads, std::vector<std::uint64_t>& words, int first_bit,
                  std::uint64_t largest);

  /// Replaces `words` by one word for each reference that has a key (keys[reference] != no_key), sorted. All
  /// keys must be < key_count. Saves the pass that would write unsorted words.
  void from_keys(const parallel::Threads& threads, std::span<const std::uint32_t> keys,
                 std::uint32_t key_count, std::vector<std::uint64_t>& words);

 private:
  /// Sorts by `digit_bits` bits from `bit`; does nothing if all words have the same digit.
  void pass(const parallel::Threads& threads, std::vector<std::uint64_t>& words, int bit, int digit_bits);

  std::vector<std::uint64_t> scratch_;
  std::vector<std::uint32_t> histograms_;  ///< (chunks x digits)
  std::vector<std::uint32_t> digit_begin_;
};

}  // namespace palpate
