#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <palpate/types.hpp>

namespace palpate::app {

/// Name and colour of a label, from a table or header.
struct LabelName {
  std::int32_t label = 0;
  std::string name;
  std::optional<std::array<double, 3>> color;  ///< red, green, blue in [0, 1]
};

/// A transform from own axes to world coordinates: world = origin + axes[0] x + axes[1] y + axes[2] z.
struct Frame {
  Vec3 origin{};
  std::array<Vec3, 3> axes{{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
  [[nodiscard]] Vec3 to_world(const Vec3& p) const;
};

/// A volume of voxels with a number each: 0 is outside, every other number is an organ.
struct LabelMap {
  std::array<int, 3> size{};  ///< voxels along i, j, k
  Vec3 spacing{};             ///< mm from one voxel to the next along i, j, k
  Frame frame;  ///< of the voxels in mm: voxel (i, j, k) has its centre at frame.to_world(spacing * ijk); LPS
  std::vector<std::int32_t> labels;  ///< (k, j, i), i fastest
  std::vector<LabelName> names;      ///< from the header of the file; empty where it has none

  [[nodiscard]] std::int32_t at(int i, int j, int k) const {
    const auto row =
        static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(j);
    return labels[row * static_cast<std::size_t>(size[0]) + static_cast<std::size_t>(i)];
  }
};

/// Box of voxels, both ends included.
struct VoxelBox {
  std::array<int, 3> lower{};
  std::array<int, 3> upper{};
};

/// A label and its voxels in a map.
struct LabelExtent {
  std::int32_t label = 0;
  std::size_t voxels = 0;
  VoxelBox box;
};

/// Reads a label map: NRRD (.nrrd .nhdr, .seg.nrrd of 3D Slicer with its names and colours), NIfTI (.nii
/// .nii.gz), MetaImage (.mha .mhd), or a folder with one DICOM series.
///
/// World coordinates are LPS in mm (x to the left, y to the back, z to the head), what DICOM and ITK use;
/// files in RAS (NIfTI, NRRD that says so) are converted. A NRRD without `space` is taken as it is. Throws
/// Error naming the file if it is missing, damaged, of another kind, not three-dimensional, or holds no
/// whole numbers >= 0 (a CT itself).
LabelMap read_label_map(const std::filesystem::path& path);

/// Whether read_label_map() reads this path: by its extension, or because it is a folder.
bool is_label_map(const std::filesystem::path& path);

/// The labels that occur in a map, except 0, ascending. O(voxels).
std::vector<LabelExtent> labels_in(const LabelMap& map);

}  // namespace palpate::app
