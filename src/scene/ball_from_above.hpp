#pragma once

#include <optional>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>
#include <palpate/types.hpp>

namespace palpate {

/// The surface of a body as points that are close to each other: corners of triangles, and places on them.
/// \param spacing  largest distance of neighbours on a triangle, m, > 0
///
/// O(triangles + area / spacing^2).
std::vector<Vec3> surface_samples(const Bodies& bodies, double spacing);

/// Where a ball that comes down along a vertical line first touches.
struct Touch {
  double height = 0.0;  ///< of its centre, m
  double beside = 0.0;  ///< distance of the touched place from the line, m; up to the radius
};

/// The first touch along the line through (x, y); none where the ball meets no sample. O(samples).
std::optional<Touch> touch_from_above(std::span<const Vec3> samples, double x, double y, double radius);

/// The place of the centre of a ball that comes down on the body, where it first touches it. Of a lattice of
/// vertical lines it is the one whose touch is highest, less half of its distance from (0, 0), so that a rim
/// that is hardly higher than the middle is not chosen, and less up to three tenths of the body's height
/// where the ball touches on a slope, from which it would slip.
Vec3 place_of_touch(const Bodies& bodies, double radius);

}  // namespace palpate
