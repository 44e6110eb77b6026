#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <palpate/types.hpp>

namespace palpate::anatomy {

/// A label map on cubic voxels: 0 is no organ, l + 1 is names[l].
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

/// The piece of the orbital floor that breaks out: an ellipse seen from above.
struct FloorDefect {
  double width = 13.0;   ///< along x, mm, in [2, 22]
  double length = 16.0;  ///< along y, mm, in [2, 24]
  double x = -2.0;       ///< of its centre, mm, in [-8, 8]
  double y = 7.0;        ///< of its centre, mm, in [0, 16]
};

/// An orbit over a maxillary sinus, for the repair of a fracture of its floor: bulb, recti, nerve, fat,
/// fragment, floor (where the tissue is lifted from the bone) and bone; no skin, no plate. `edge` as above.
/// Throws Error if it or the defect is out of range. O(cubes).
OrganLabels orbit_labels(double edge, const FloorDefect& defect);

}  // namespace palpate::anatomy
