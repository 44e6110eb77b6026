#pragma once

#include <array>

#include <palpate/types.hpp>

/// Exact geometric predicates: the answer equals that of exact arithmetic on the given doubles, for all
/// finite input.
///
/// A floating-point filter with a proven error bound (Shewchuk, "Adaptive precision floating-point arithmetic
/// and fast robust geometric predicates", 1997, orient3d stage A) decides almost every call. Deviation: a
/// term keeps the bound valid under underflow. Expansions of doubles (the same, stage D) decide the rest:
/// bodies with common points, as in conforming meshes, need them often. Where these would overflow or
/// underflow, integers of any length decide (Boost.Multiprecision).
namespace palpate {

/// Sign (-1, 0, +1) of det[b - a, c - a, d - a]: six times the signed volume of the tet (a, b, c, d).
int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Whether p lies in the closed tet (boundary counts), for both orientations. A tet of zero volume contains
/// nothing.
bool point_in_tet(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Whether the closed segment (a, b) meets the closed triangle (t0, t1, t2). A segment in the triangle's
/// plane does not: where it leaves a closed surface, it also meets a triangle that is not in its plane.
bool segment_meets_triangle(const Vec3& a, const Vec3& b, const Vec3& t0, const Vec3& t1, const Vec3& t2);

/// Where a segment that meets a triangle (see above) crosses its plane: a + t (b - a), t in [0, 1], with a
/// relative error of t and of 1 - t of about 1e-9, also for slender triangles and for segments almost
/// parallel to the plane.
double crossing_parameter(const Vec3& a, const Vec3& b, const Vec3& t0, const Vec3& t1, const Vec3& t2);

/// Barycentric weights of p in the tet (a, b, c, d), for p inside it: each in [0, 1], their sum 1 up to
/// rounding.
std::array<double, 4> barycentric_weights(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c,
                                          const Vec3& d);

}  // namespace palpate
