#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "parallel/parallel.hpp"

namespace palpate {

/// Parallel counting sort for dense domains; also computes the cell starts C (paper 4.2). Stable.
///
/// One pass by the high bits of the key cuts the words into ranges of cells; each range is then counted and
/// written separately, in the cache. (Counting the whole domain at once has a cache miss for each word of a
/// large, unordered domain; a histogram per thread needs threads x cells memory.)
class CountingSort {
 public:
  /// Replaces `words` by one word for each reference that has a key (keys[reference] != no_key), sorted, and
  /// `cell_begin` (key_count + 1) by where the words of each key begin. All keys must be < key_count.
  /// O(references + key_count); keeps its scratch memory. If nearly all keys are in one range, one thread
  /// does that range alone.
  void operator()(const parallel::Threads& threads, std::span<const std::uint32_t> keys,
                  std::uint32_t key_count, std::vector<std::uint64_t>& words,
                  std::vector<std::uint32_t>& cell_begin);

 private:
  std::vector<std::uint64_t> scratch_;
  std::vector<std::uint32_t> histograms_;
  std::vector<std::uint32_t> range_begin_;
};

/// Replaces `cell_begin` (key_count + 1) by where the words of each key begin in sorted `words`.
/// O(words + key_count).
void index_cells(const parallel::Threads& threads, std::span<const std::uint64_t> words,
                 std::uint32_t key_count, std::vector<std::uint32_t>& cell_begin);

}  // namespace palpate
