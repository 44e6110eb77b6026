#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace palpate::measure {

/// The fraction of references that change their key between frames, and how far they move.
enum class Movers { still, near_2, near_10, near_50, near_100, random_100 };

std::string name_of(Movers movers);

/// Frames of keys for a sort, and the expected results. Points are at random positions in a cube of cells,
/// about one per cell, in random order. A near mover goes to one of the 6 cells beside its own. The frames
/// are played forwards and backwards, and each step has the wanted fraction of movers.
struct SortFrames {
  std::uint32_t key_count = 0;
  std::vector<std::vector<std::uint32_t>> keys;    ///< (frames x entries)
  std::vector<std::vector<std::uint64_t>> sorted;  ///< (frames x entries), by std::sort
  [[nodiscard]] std::size_t entries() const { return keys.front().size(); }
  /// Steps of one pass forwards and backwards.
  [[nodiscard]] std::size_t steps() const { return 2 * (keys.size() - 1); }
  /// The frame at a step; passes are repeated without end.
  [[nodiscard]] std::size_t frame_at(std::size_t step) const;
};

/// 41 distinct frames; 6 for 10M entries, where 41 would take 5 GB.
SortFrames make_frames(std::size_t entries, Movers movers);

}  // namespace palpate::measure
