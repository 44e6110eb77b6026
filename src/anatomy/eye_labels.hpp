#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <palpate/types.hpp>

namespace palpate::anatomy {

/// A label map on cubic voxels: 0 is nothing, l + 1 is names[l].
struct OrganLabels {
  std::array<int, 3> size{};  ///< cubes along x, y, z
  Vec3 origin;                ///< centre of the first cube, mm
  double edge = 1.0;          ///< of a cube, mm
  std::vector<std::string> names;
  std::vector<std::uint8_t> labels;  ///< (z, y, x), x fastest
};

/// The orbit of make_eye() without plate and without gaps between organs, like a segmentation of it. Throws
/// Error unless `edge` is in [0.25, 4]. O(cubes).
OrganLabels eye_labels(double edge);

}  // namespace palpate::anatomy
