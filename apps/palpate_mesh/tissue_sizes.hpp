#pragma once

#include <array>
#include <span>
#include <vector>

#include "lattice.hpp"
#include "tissues.hpp"

namespace palpate::app {

/// Sizes of triangles and tets, mm, over the tissues of a map.
struct TissueSizes {
  /// The size at the interface of two tissues (0: the outside).
  struct Interface {
    std::array<int, 2> tissues{};
    double size = 0.0;
  };
  /// A ball in which tets are to be small, in the axes of the map.
  struct Focus {
    Vec3 center;
    double radius = 0.0;
    double size = 0.0;
  };
  double general = 1.0;                 ///< of tissues without a size of their own
  std::vector<double> own;              ///< (n_tissues + 1), 0: none; the first is not used
  std::vector<Interface> interfaces{};  ///< interfaces with a size of their own
  std::vector<Focus> focuses{};
  double of_thickness = 1.0;  ///< largest size relative to the thickness of the tissue
  double growth = 0.3;  ///< growth of the size with the distance from positions where it must be smaller
};

/// Thickness of the tissue at each voxel, mm: the shortest run of voxels of the same tissue along the 13
/// directions to its neighbours; infinite where no run ends. O(voxels x thickness).
std::vector<float> thickness_of(const Tissues& tissues, double most);

/// The size at the voxel centres. No size is larger than that of another position plus `growth` times the
/// distance to it. O(voxels).
Lattice size_field(const Tissues& tissues, const TissueSizes& sizes, std::span<const float> thickness);

}  // namespace palpate::app
