#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "parallel/parallel.hpp"
#include "sort/key_changes.hpp"
#include "sort/radix.hpp"

namespace palpate {

/// Sorts by repairing the order of the last frame (paper 5, "Parallel sorting": the domain is predominantly
/// sorted). The old and the new word of each mover are sorted, and merged with last frame's words: words that
/// stay are only copied. The result is exactly that of a full sort.
class RepairSort {
 public:
  /// Turns `words`, sorted for the keys that `changes` last accepted, into those of its last find(); does not
  /// accept them. In the first frame all words are new, and this is a full sort.
  /// \param cell_begin  if given: where the words of each key begin, in and out (key_count + 1), for the same
  ///                    key_count as last frame
  /// O(words + movers x digits of the keys); keeps its scratch memory.
  void operator()(const parallel::Threads& threads, KeyChanges& changes, std::uint32_t key_count,
                  std::vector<std::uint64_t>& words, std::vector<std::uint32_t>* cell_begin);

 private:
  /// Words [first_word, ...) of last frame, the events from first_event and the position of the merged words.
  struct Segment {
    std::size_t first_event = 0;
    std::size_t first_merged = 0;
  };
  void sort_events(const parallel::Threads& threads, std::uint32_t key_count);
  void cut(const parallel::Threads& threads, std::span<const std::uint64_t> words);
  void shift_cells(const parallel::Threads& threads, std::span<const std::uint64_t> words,
                   std::vector<std::uint32_t>& cell_begin) const;

  std::vector<std::uint64_t> events_;
  std::vector<Segment> segments_;  ///< one more than there are, for the end
  std::vector<std::uint64_t> merged_;
  RadixSort radix_;
};

}  // namespace palpate
