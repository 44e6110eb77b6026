#pragma once

#include <vector>

#include <palpate/types.hpp>

#include "anatomy/stuffing.hpp"

/// Shapes as signed distances, and their combinations, to build organs. Lengths in the unit of the points;
/// the formulas are those of Quilez, "Distance functions" (iquilezles.org), where no other source is named.
namespace palpate::anatomy {

Distance ball(const Vec3& center, double radius);

/// An ellipsoid, with an approximate distance: exact on the surface, too small far away (first order: value
/// over gradient).
Distance ellipsoid(const Vec3& center, const Vec3& radii);

/// Two balls with the tangent cone between them.
Distance round_cone(const Vec3& a, const Vec3& b, double radius_a, double radius_b);

/// The half space behind the plane through `point` with this normal (any length).
Distance half_space(const Vec3& point, const Vec3& normal);

Distance box(const Vec3& lower, const Vec3& upper);

/// A cross section of a tube.
struct TubeStation {
  Vec3 center;
  Vec3 across;       ///< unit vector of the first half axis, at right angles to the axis
  double width = 0;  ///< half axis along `across`
  double depth = 0;  ///< half axis at right angles to `across` and the axis
};

/// An elliptic tube along a polyline of two or more stations, with round ends. The distance is approximate
/// (like ellipsoid()).
Distance tube(std::vector<TubeStation> stations);

/// The shape grown by `distance` on all sides (shrunk, where negative).
Distance grown(Distance shape, double distance);

/// The part of `shape` at distances between `inner` and `outer` from its surface (negative: inside).
Distance layer(Distance shape, double inner, double outer);

/// Union and intersection of one or more shapes.
Distance united(std::vector<Distance> shapes);
Distance common(std::vector<Distance> shapes);

/// Union (with the crease filled) and intersection (with the edge rounded) of two shapes, smooth over about
/// `radius`.
Distance smoothly_united(Distance a, Distance b, double radius);
Distance smoothly_common(Distance a, Distance b, double radius);

/// `shape` without `other`, with the edge between them cut over about `radius`.
Distance smoothly_without(Distance shape, Distance other, double radius);

/// `shape` without its part nearer than `gap` to `other`.
Distance without(Distance shape, Distance other, double gap = 0.0);

}  // namespace palpate::anatomy
