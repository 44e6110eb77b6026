#pragma once

#include <vector>

#include <palpate/types.hpp>

#include "anatomy/stuffing.hpp"

/// Shapes to build organs of, as signed distances, and how they are put together. Lengths in the unit of the
/// points; the formulas are those of Quilez, "Distance functions" (iquilezles.org), where no other source is
/// named.
namespace palpate::anatomy {

Distance ball(const Vec3& center, double radius);

/// About the distance: exact on the surface, too small far away (first order: value by gradient).
Distance ellipsoid(const Vec3& center, const Vec3& radii);

/// Two balls and the tangent cone between them.
Distance round_cone(const Vec3& a, const Vec3& b, double radius_a, double radius_b);

/// What lies behind the plane through `point` with that normal (any length).
Distance half_space(const Vec3& point, const Vec3& normal);

Distance box(const Vec3& lower, const Vec3& upper);

/// A place on a swept tube.
struct TubeStation {
  Vec3 center;
  Vec3 across;       ///< unit vector of the first half axis, at right angles to the axis
  double width = 0;  ///< half axis along `across`
  double depth = 0;  ///< half axis at right angles to `across` and the axis
};

/// An elliptic tube along a polyline of two or more stations, with round ends. About the distance (as
/// ellipsoid()).
Distance tube(std::vector<TubeStation> stations);

/// The shape grown by `distance` on all sides (shrunk, where negative).
Distance grown(Distance shape, double distance);

/// Of `shape` what lies between `inner` and `outer` from its surface (negative: inside).
Distance layer(Distance shape, double inner, double outer);

/// Of at least one shape: all together; what is common to all.
Distance united(std::vector<Distance> shapes);
Distance common(std::vector<Distance> shapes);

/// Both, with the crease between them filled (union) or cut (common part) over about `radius`.
Distance smoothly_united(Distance a, Distance b, double radius);
Distance smoothly_common(Distance a, Distance b, double radius);

/// `shape` without `other`, with the edge between them cut over about `radius`.
Distance smoothly_without(Distance shape, Distance other, double radius);

/// `shape` without what is nearer than `gap` to `other`.
Distance without(Distance shape, Distance other, double gap = 0.0);

}  // namespace palpate::anatomy
