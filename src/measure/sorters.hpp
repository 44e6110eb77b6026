#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "measure/sort_frames.hpp"

namespace palpate::measure {

/// Sorts the next frame in its own memory; returns the words.
using Sorter = std::function<const std::vector<std::uint64_t>&(const SortFrames&, std::size_t frame)>;

struct Competitor {
  std::string name;
  std::function<Sorter()> make;
};

/// memcpy of the same bytes (the lower bound), std::sort from the last frame's order and from the order of
/// references, and all our sorts, with and without the array C of cells.
std::vector<Competitor> competitors();

}  // namespace palpate::measure
