#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/settings.hpp>

#include "parallel/parallel.hpp"
#include "sort/comparison.hpp"
#include "sort/counting.hpp"
#include "sort/key_changes.hpp"
#include "sort/radix.hpp"
#include "sort/repair.hpp"
#include "sort/sort_switch.hpp"

namespace palpate {

/// Keeps words (key, reference) sorted from frame to frame, where each reference has one key at most. The
/// words depend neither on the method nor on the thread count.
class PointSort {
 public:
  struct Result {
    Sort used = Sort::radix;  ///< never adaptive
    std::size_t movers = 0;   ///< references whose key changed since last frame; all of the first frame
  };

  explicit PointSort(Sort method = Sort::adaptive) : method_(method) {}

  /// Sorts one frame. Allocates nothing after frames of this size with at least half as many movers.
  /// O(references x digits of the keys) at most for radix.
  /// \param keys  key of each reference, < key_count, or no_key for those without a word; fewer than 2^31
  /// \param words  in: what the last call gave (in the first call, or with another size, its content is
  ///               ignored); out: one word for each reference with a key, sorted
  /// \param cell_begin  optional, (key_count + 1): in: what the last call gave, out: where each key's words
  ///                    begin
  Result update(const parallel::Threads& threads, std::span<const std::uint32_t> keys,
                std::uint32_t key_count, std::vector<std::uint64_t>& words,
                std::vector<std::uint32_t>* cell_begin = nullptr);
  /// Makes the next update() a full sort, like the first one.
  void forget() { changes_.clear(); }
  /// Of Sort::adaptive.
  [[nodiscard]] SortSwitch& adaptive_switch() { return switch_; }
  [[nodiscard]] const SortSwitch& adaptive_switch() const { return switch_; }

 private:
  [[nodiscard]] Sort choose(std::uint32_t key_count, bool wants_cells);
  void sort_by_comparison(const parallel::Threads& threads, std::span<const std::uint32_t> keys,
                          std::vector<std::uint64_t>& words);

  Sort method_;
  SortSwitch switch_;
  KeyChanges changes_;
  RadixSort radix_;
  CountingSort counting_;
  ComparisonSort comparison_;
  RepairSort repair_;
  std::vector<std::uint32_t> own_cell_begin_;  ///< for counting, if the caller needs no C
  std::uint32_t cells_of_last_frame_ = 0;      ///< key_count for which the caller's C was written; 0: none
};

}  // namespace palpate
