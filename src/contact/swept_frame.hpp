#pragma once

#include <array>
#include <span>

#include <palpate/mesh.hpp>

#include "geometry/box.hpp"

namespace palpate {

/// Boxes of what moves within a step, for two clusters that move past each other: in a frame that moves with
/// the second one, and with its first axis along the relative motion. Across this motion, boxes are about as
/// small as what is in them, however long the step is. Upright boxes at rest contain all that a long motion
/// passes.
///
/// Positions are linear in time, in the frame as well. So two primitives whose boxes are apart along an axis
/// do not touch within the step. This holds for any three axes, so rounding of the axes does not matter.
class SweptFrame {
 public:
  /// \param places     box of both clusters during the step
  /// \param first      displacement of the first cluster, and of the second, m; any that is about right
  /// \param tolerance  by which boxes are grown, m; rounding errors of the frame are added
  SweptFrame(const Box& places, const Vec3& first, const Vec3& second, double tolerance);

  /// The grown box of primitives with these corners.
  template <class Corners>
  [[nodiscard]] Box box_of(std::span<const Vec3> start, std::span<const Vec3> end,
                           const Corners& corners) const {
    Box box;
    for (const Index corner : corners) {
      box.extend(in_frame(at(start, corner) - origin_));
      box.extend(in_frame(at(end, corner) - origin_ - motion_));
    }
    return {box.lower - margin_, box.upper + margin_};
  }

 private:
  [[nodiscard]] Vec3 in_frame(const Vec3& v) const {
    return {dot(axes_[0], v), dot(axes_[1], v), dot(axes_[2], v)};
  }

  Vec3 origin_;
  Vec3 motion_;  ///< of the frame
  std::array<Vec3, 3> axes_;
  Vec3 margin_;
};

}  // namespace palpate
