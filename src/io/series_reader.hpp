#pragma once

#include <filesystem>
#include <vector>

namespace palpate::io {

/// A frame of a series.
struct SeriesFrame {
  double time = 0.0;
  std::filesystem::path file;
};

/// The frames that a ParaView collection (.pvd) lists, in its order. Throws Error naming the file and line
/// if the file is no collection, times do not grow, or a frame is not in the folder of the collection or
/// below it. The frames themselves are not read. O(size of the file).
std::vector<SeriesFrame> read_series(const std::filesystem::path& collection);

}  // namespace palpate::io
