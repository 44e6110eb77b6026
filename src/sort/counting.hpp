#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "parallel/parallel.hpp"

namespace palpate {

/// Parallel counting sort for dense domains; gives the cell starts C (paper 4.2) on the way. Stable.
///
/// One pass by the high bits of the key cuts the words into ranges of cells; each range is then counted and
/// written on its own, in the cache. (Counting over the whole domain at once misses the cache with each word
/// of a large, unordered domain; a histogram for each thread would take threads x cells memory.)
class CountingSort {
 public:
  /// Replaces `words` by one word for each reference that has a key (keys[reference] != no_key), sorted, and
  /// `cell_begin` (key_count + 1) by where the words of each key begin. All keys must be < key_count.
  /// O(references + key_count); keeps its scratch memory. Where nearly all keys fall into one range, that
  /// range is the work of one thread.
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
