#pragma once

#include <array>
#include <optional>

#include "geometry/vector.hpp"

namespace palpate {

/// Positions of four points at the start and at the end of a step; in between, each moves along a straight
/// line at constant speed. They are a point and a triangle (0; 1, 2, 3), or two edges (0, 1; 2, 3).
struct SweptPoints {
  std::array<Vec3, 4> start;
  std::array<Vec3, 4> end;
};

/// Where two primitives first touch.
struct SweptTouch {
  double time = 0.0;  ///< in [0, 1] of the step; never after the first touch
  /// Position of the touch: three barycentric weights in the triangle, or a parameter of each edge (0 at its
  /// first point).
  std::array<double, 3> weights{};
  /// Unit normal of a plane that separates the two at `time`, on the side of the first. Zero if they touch at
  /// the start of the step, where no such plane exists.
  Vec3 direction{};
};

/// The first touch of a point and a triangle, or of two edges, within a step; empty: none.
///
/// Conservative: where the exact motions touch, also in degenerate cases (coplanar, parallel, at corners, no
/// area or length), the result is a touch, at a time that is not later. A touch is reported only where the
/// two come within swept_tolerance() of each other. If all advances (10^4) are used up, the distance is at
/// most that, or 1e-4 of their relative motion.
///
/// Method: conservative advancement (Mirtich 1996; additive CCD: Li et al. 2021) with separating planes. At
/// each time the candidate directions are the normal of the triangle or the common normal of the edges, and
/// those between each point and each edge of the other. The one with the largest separation is used. Along
/// it, differences of vertices are linear in time. So their values at both ends of an interval, with a bound
/// of rounding errors, prove that the interval is free of contact. The search continues at its end. Motion
/// perpendicular to the direction does not count, so sliding pairs are rejected early. If advances are small,
/// directions that rotate with the primitives give longer intervals (Bernstein coefficients of cubics). As in
/// Tight-Inclusion (Wang et al., "A Large Scale Benchmark and an Inclusion-Based Algorithm for Continuous
/// Collision Detection", 2021), a pair is rejected only by intervals that bound all values and rounding
/// errors.
/// \param tolerance  m
std::optional<SweptTouch> point_meets_triangle(const SweptPoints& points, double tolerance);
std::optional<SweptTouch> edge_meets_edge(const SweptPoints& points, double tolerance);

/// The distance within which a touch may be reported: `tolerance`, but at least the bound of rounding, 2.4e-7
/// times the size of the box of both over the step.
double swept_tolerance(const SweptPoints& points, double tolerance);

}  // namespace palpate
