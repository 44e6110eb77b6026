#pragma once

#include <array>
#include <optional>

#include "geometry/vector.hpp"

namespace palpate {

/// Where four points are at the start and at the end of a step; between, each moves along a straight line at
/// constant speed. Of a point and a triangle (0; 1, 2, 3) or of two edges (0, 1; 2, 3).
struct SweptPoints {
  std::array<Vec3, 4> start;
  std::array<Vec3, 4> end;
};

/// Where two primitives first touch.
struct SweptTouch {
  double time = 0.0;  ///< in [0, 1] of the step; never after the first touch
  /// Of the place of the touch: three barycentric weights in the triangle, or a parameter of each edge (0 at
  /// its first point).
  std::array<double, 3> weights{};
  /// Unit: at `time` a plane across it lies between the two, the first on the side that it leads to. Zero
  /// where they touch at the start of the step, so that there is no such plane.
  Vec3 direction{};
};

/// When a point and a triangle, or two edges, first touch within a step; none: they do not.
///
/// Conservative: where the exact motions touch, however degenerate (coplanar, parallel, at corners, of no
/// area or length), the result is a touch, at a time that is not after it. A touch is reported only where the
/// two come within swept_tolerance() of each other; where the advances below are used up (10^4), within that
/// or a 10^4th of their relative motion.
///
/// Method: advance in time from plane to plane. At a time, of the directions in which the two may be nearest
/// (normal of the triangle or common normal of the edges; from each point to each edge) the one that
/// separates them most is taken. Along it, differences of corners are linear in time; so two ends prove the
/// whole interval free, with a bound of what rounding adds. The next time is where the proof ends. As in
/// conservative advancement (Mirtich 1996; additive CCD: Li et al. 2021), but only motion along the direction
/// counts, so that what slides past is dismissed at once; and where that is slow, directions that turn with
/// the primitives prove further, by Bernstein coefficients of cubics. As in Tight-Inclusion (Wang et al., "A
/// Large Scale Benchmark and an Inclusion-Based Algorithm for Continuous Collision Detection", 2021), nothing
/// is dismissed without an interval that holds all values and all rounding. \param tolerance  m
std::optional<SweptTouch> point_meets_triangle(const SweptPoints& points, double tolerance);
std::optional<SweptTouch> edge_meets_edge(const SweptPoints& points, double tolerance);

/// The distance within which a touch may be reported: `tolerance`, but no less than rounding asks for, 2.4e-7
/// of the size of the box of both over the step.
double swept_tolerance(const SweptPoints& points, double tolerance);

}  // namespace palpate
