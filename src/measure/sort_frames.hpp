#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace palpate::measure {

/// How many references change their key from one frame to the next, and how far.
enum class Movers { still, near_2, near_10, near_50, near_100, random_100 };

std::string name_of(Movers movers);

/// Frames of keys for a sort, and what each must give. Points lie at random in a cube of cells, about one a
/// cell, and are numbered without regard to where they are; a near mover goes to one of the 6 cells beside
/// its own. Played forth and back, each step of which has the wanted fraction of movers.
struct SortFrames {
  std::uint32_t key_count = 0;
  std::vector<std::vector<std::uint32_t>> keys;    ///< (frames x entries)
  std::vector<std::vector<std::uint64_t>> sorted;  ///< (frames x entries), by std::sort
  [[nodiscard]] std::size_t entries() const { return keys.front().size(); }
  /// Steps of one turn forth and back.
  [[nodiscard]] std::size_t steps() const { return 2 * (keys.size() - 1); }
  /// The frame at a step; any step, one turn after the other.
  [[nodiscard]] std::size_t frame_at(std::size_t step) const;
};

/// 41 distinct frames; 6 for 10M entries, where 41 would take 5 GB.
SortFrames make_frames(std::size_t entries, Movers movers);

}  // namespace palpate::measure
