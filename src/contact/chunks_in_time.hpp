#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "contact/deadline.hpp"
#include "parallel/parallel.hpp"
#include "room.hpp"

namespace palpate {

/// Chunks of work that are skipped once a deadline has passed. The first chunk is always done, so that each
/// detection completes some of the work.
class ChunksInTime {
 public:
  void begin(const Deadline& deadline, std::size_t items, std::size_t grain) {
    deadline_ = deadline;
    grain_ = grain;
    assign_with_room(skipped_, parallel::chunk_count(items, grain), std::uint8_t{0});
  }
  /// Call once for each chunk, from any thread: whether the chunk that begins with this item must be skipped.
  bool skips(std::size_t first_item) {
    if (first_item == 0 || !deadline_.passed()) return false;
    skipped_[first_item / grain_] = 1;
    return true;
  }
  /// Whether the chunk of an item was skipped.
  [[nodiscard]] bool skipped(std::size_t item) const { return skipped_[item / grain_] != 0; }

 private:
  Deadline deadline_;
  std::size_t grain_ = 1;
  std::vector<std::uint8_t> skipped_;
};

}  // namespace palpate
