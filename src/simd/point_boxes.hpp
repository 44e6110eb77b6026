#pragma once

#include <array>
#include <span>

#include <palpate/types.hpp>

namespace palpate::simd {

/// A box; fourth numbers mean nothing.
struct PointBox {
  alignas(32) std::array<double, 4> lower;
  alignas(32) std::array<double, 4> upper;
};
/// The displacement m[3] + x m[0] + y m[1] + z m[2] of a point (x, y, z).
using LinearMotion = std::array<std::array<double, 4>, 4>;

/// Boxes of points that move.
struct PointBoxes {
  PointBox places;         ///< where they are now
  PointBox displacements;  ///< now minus before
  PointBox remainders;     ///< displacements less those of a linear motion
};

/// Finds the boxes of some points. O(points).
/// \param common  the linear motion; null: no remainders
void find_boxes(const Vec3* now, const Vec3* before, std::span<const Index> points,
                const LinearMotion* common, PointBoxes& boxes);

}  // namespace palpate::simd
