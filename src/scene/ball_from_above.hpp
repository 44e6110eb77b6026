#pragma once

#include <optional>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>
#include <palpate/types.hpp>

namespace palpate {

/// Samples of a body's surface that are close to each other: corners of triangles, and positions on them.
/// \param spacing  largest distance of neighbouring samples on a triangle, m, > 0
///
/// O(triangles + area / spacing^2).
std::vector<Vec3> surface_samples(const Bodies& bodies, double spacing);

/// Where a ball that moves down along a vertical line touches first.
struct Touch {
  double height = 0.0;  ///< of the ball's centre, m
  double beside = 0.0;  ///< horizontal distance of the touched position from the line, m; at most the radius
};

/// The first touch of the ball along the line through (x, y); none if it meets no sample. O(samples).
std::optional<Touch> touch_from_above(std::span<const Vec3> samples, double x, double y, double radius);

/// Finds where a ball should come down on the body, and returns the position of its centre at the first
/// touch. It chooses among the vertical lines of a lattice: the higher the touch, the better. Half of the
/// line's distance from (0, 0) is subtracted, so that a rim that is hardly higher than the middle is not
/// chosen. Up to three tenths of the body's height is subtracted where the ball touches on a slope, from
/// which it would slip.
Vec3 place_of_touch(const Bodies& bodies, double radius);

}  // namespace palpate
