#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "parallel/parallel.hpp"

namespace palpate {

/// Parallel comparison sort, like the STL sort of the paper (5, "Parallel sorting"): chunks are sorted
/// independently and merged in pairs, each merge cut into pieces of equal size.
///
/// It is faster for predominantly sorted input: in each chunk, words out of order are taken out, sorted and
/// merged back; chunks that are already in order are not merged.
class ComparisonSort {
 public:
  /// Sorts `words`. O(n log n), O(n) where they are nearly sorted; keeps its scratch memory.
  void operator()(const parallel::Threads& threads, std::vector<std::uint64_t>& words);

 private:
  void sort_chunk(std::span<std::uint64_t> words, std::span<std::uint64_t> scratch) const;
  /// Merges sorted runs of `run` words in pairs from `in` to `out`.
  void merge_runs(const parallel::Threads& threads, std::span<const std::uint64_t> in, std::size_t run,
                  std::span<std::uint64_t> out) const;

  std::vector<std::uint64_t> scratch_;
};

}  // namespace palpate
