#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace palpate::io {

/// An array of numbers at the points of a .vtu file.
struct PointArrayInfo {
  std::string name;
  int components = 1;
};

/// The arrays at the points of the one piece of a frame, in the order of the file. Throws Error for anything
/// but a complete .vtu file.
std::vector<PointArrayInfo> list_point_arrays(const std::filesystem::path& path);

/// The numbers of one of them (n_points x components); NaN is allowed. Empty where no array has that name.
/// Throws Error if it is cut off or damaged. O(file size).
std::vector<double> read_point_array(const std::filesystem::path& path, const std::string& name);

}  // namespace palpate::io
