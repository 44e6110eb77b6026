#include "simd/edge_triangle_gaps.hpp"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/edge_triangle_gaps.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our headers are compiled for each target, so they come after that.
#include "simd/cluster_lanes-inl.hpp"
#include "simd/point_lanes-inl.hpp"
#include "simd/row_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {

constexpr float largest = std::numeric_limits<float>::max();

/// A segment (a, b) and a triangle with sides u and v, relative to the triangle's first corner.
struct SegmentAndTriangle {
  Vector a;
  Vector b;
  Vector u;
  Vector v;
};
/// Points relative to an origin, in units, a row for each lane.
using LocalRows = std::array<std::array<float, 4>, hn::MaxLanes(Floats())>;

HWY_INLINE void put(const Vec3& point, const Vec3& origin, double scale, std::array<float, 4>& row) {
  const hn::Rebind<float, CoordinateTag> in_float;
  const Coordinates factor = hn::Set(coordinates, scale);
  for (std::size_t part = 0; part < parts; ++part) {
    const Coordinates local = hn::Mul(factor, hn::Sub(load(point, part), load(origin, part)));
    hn::StoreU(hn::DemoteTo(in_float, local), in_float, row.data() + part);
  }
}
HWY_INLINE Vector vector_of(const LocalRows& rows) {
  const auto [x, y, z] = load_rows(floats, [&](std::size_t lane) HWY_ATTR { return rows[lane].data(); });
  return {x, y, z};
}
HWY_INLINE SegmentAndTriangle read(const EdgesAndTriangles& s, double scale, const Index* edge,
                                   const Index* triangle) {
  alignas(64) std::array<LocalRows, 4> rows;
  if constexpr (parts > 1) rows = {};
  for (std::size_t lane = 0; lane < lanes(); ++lane) {
    const Edge& ends = s.edges[edge[lane]];
    const Triangle& corners = s.triangles[triangle[lane]];
    const Vec3& origin = s.positions[corners[0]];
    put(s.positions[ends[0]], origin, scale, rows[0][lane]);
    put(s.positions[ends[1]], origin, scale, rows[1][lane]);
    put(s.positions[corners[1]], origin, scale, rows[2][lane]);
    put(s.positions[corners[2]], origin, scale, rows[3][lane]);
  }
  return {vector_of(rows[0]), vector_of(rows[1]), vector_of(rows[2]), vector_of(rows[3])};
}

HWY_INLINE Float min3(Float a, Float b, Float c) {
  return hn::Min(a, hn::Min(b, c));
}
HWY_INLINE Float max3(Float a, Float b, Float c) {
  return hn::Max(a, hn::Max(b, c));
}

/// Squared gap between the two along a direction. Zero where they overlap, underflow or overflow.
HWY_INLINE Float squared_gap(const SegmentAndTriangle& pair, const Vector& direction) {
  const Float zero = hn::Zero(floats);
  const Float da = dot(direction, pair.a);
  const Float db = dot(direction, pair.b);
  const Float du = dot(direction, pair.u);
  const Float dv = dot(direction, pair.v);
  const Float above = hn::Sub(hn::Min(da, db), max3(zero, du, dv));
  const Float below = hn::Sub(min3(zero, du, dv), hn::Max(da, db));
  const Float gap = max3(zero, above, below);
  const Float squared_length = dot(direction, direction);
  constexpr float smallest = 1e-30F;  // squared length with full precision
  const Float squared = hn::Div(hn::Mul(gap, gap), squared_length);
  const auto is_said =
      hn::And(hn::Gt(squared_length, hn::Set(floats, smallest)), hn::Le(squared, hn::Set(floats, largest)));
  return hn::IfThenElseZero(is_said, squared);
}

/// Gap of the boxes along an axis; negative where they overlap.
HWY_INLINE Float axis_gap(Float a, Float b, Float u, Float v) {
  const Float zero = hn::Zero(floats);
  return hn::Max(hn::Sub(min3(zero, u, v), hn::Max(a, b)), hn::Sub(hn::Min(a, b), max3(zero, u, v)));
}

/// Where the segment surely passes through the inside of the triangle: its ends are on both sides of the
/// plane, and the segment has the same orientation with regard to all sides.
/// \param extent  no coordinate is larger
HWY_INLINE auto surely_meet(const SegmentAndTriangle& pair, const Vector& normal, Float extent) {
  // The sum of all rounding errors of a volume is below 400 units in the last place of extent^3.
  constexpr float rounding = 4e-5F;
  constexpr float smallest = 1e-30F;  // underflows are far below
  const Float error = hn::Mul(hn::Set(floats, rounding), hn::Mul(extent, hn::Mul(extent, extent)));
  const Vector along = difference(pair.b, pair.a);
  const Vector moment = cross(pair.a, along);
  const Float da = dot(normal, pair.a);
  const Float db = dot(normal, pair.b);
  const Float side_u = dot(pair.u, moment);
  const Float side_v = hn::Neg(dot(pair.v, moment));
  const Float across = hn::Sub(hn::Sub(dot(along, normal), side_u), side_v);
  const Float below = hn::Neg(error);
  const auto same =
      hn::Or(hn::Gt(min3(side_u, side_v, across), error), hn::Lt(max3(side_u, side_v, across), below));
  const auto apart = hn::And(hn::Gt(hn::Max(da, db), error), hn::Lt(hn::Min(da, db), below));
  const auto is_said =
      hn::And(hn::Gt(error, hn::Set(floats, smallest)), hn::Le(error, hn::Set(floats, largest)));
  return hn::And(is_said, hn::And(same, apart));
}

HWY_INLINE Float largest_of(const Vector& v) {
  return max3(hn::Abs(v.x), hn::Abs(v.y), hn::Abs(v.z));
}

HWY_INLINE Float gap_of(const SegmentAndTriangle& pair) {
  // In units in the last place of the largest coordinate, a distance along a direction has an error of at
  // most 35 by its two projections and 20 by its division and root.
  constexpr float rounding = 4e-6F;
  constexpr float of_underflow = std::numeric_limits<float>::min();
  const Float extent = hn::Max(hn::Max(largest_of(pair.a), largest_of(pair.b)),
                               hn::Max(largest_of(pair.u), largest_of(pair.v)));
  const Vector along = difference(pair.b, pair.a);
  const Vector normal = cross(pair.u, pair.v);
  const Float of_boxes =
      max3(axis_gap(pair.a.x, pair.b.x, pair.u.x, pair.v.x), axis_gap(pair.a.y, pair.b.y, pair.u.y, pair.v.y),
           axis_gap(pair.a.z, pair.b.z, pair.u.z, pair.v.z));
  const Float of_sides =
      max3(squared_gap(pair, cross(along, pair.u)), squared_gap(pair, cross(along, pair.v)),
           squared_gap(pair, cross(along, difference(pair.v, pair.u))));
  const Float found = hn::Max(of_boxes, hn::Sqrt(hn::Max(squared_gap(pair, normal), of_sides)));
  const Float least =
      hn::Sub(found, hn::MulAdd(hn::Set(floats, rounding), extent, hn::Set(floats, of_underflow)));
  // Not a number where positions are not finite.
  const Float gap = hn::IfThenElseZero(hn::Gt(least, hn::Zero(floats)), least);
  return hn::IfThenElse(surely_meet(pair, normal, extent), hn::Set(floats, EdgeTrianglePairs::meet), gap);
}

}  // namespace

void find_gaps(const EdgesAndTriangles& surfaces, double scale, std::size_t size, EdgeTrianglePairs& pairs) {
  for (std::size_t lane = 0; lane < size; lane += lanes()) {
    const SegmentAndTriangle pair =
        read(surfaces, scale, pairs.edge.data() + lane, pairs.triangle.data() + lane);
    hn::Store(gap_of(pair), floats, pairs.gap.data() + lane);
  }
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(find_gaps);

void find_gaps(const EdgesAndTriangles& surfaces, double scale, std::size_t size, EdgeTrianglePairs& pairs) {
  HWY_DYNAMIC_DISPATCH(find_gaps)(surfaces, scale, size, pairs);
}

}  // namespace palpate::simd
#endif
