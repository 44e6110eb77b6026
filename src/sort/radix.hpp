#pragma once

#include <cstdint>
#include <vector>

#include "parallel/parallel.hpp"

namespace palpate {

/// Parallel radix sort, least significant digit first, 8 bits a digit. Stable.
class RadixSort {
 public:
  /// Sorts `words` by the bits from `first_bit` up to the highest bit set in `largest`; digits above it are
  /// not looked at, so `largest` must be >= each word. O(words x digits); keeps its scratch memory.
  void operator()(const parallel::Threads& threads, std::vector<std::uint64_t>& words, int first_bit,
                  std::uint64_t largest);

 private:
  std::vector<std::uint64_t> scratch_;
  std::vector<std::uint32_t> histograms_;  ///< (chunks x 256)
};

}  // namespace palpate
