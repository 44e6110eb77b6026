#include "simd/near_triangles.hpp"

#include <bit>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/near_triangles.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our header is compiled for each target, so it comes after that.
#include "simd/cluster_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

HWY_INLINE Float min3(Float a, Float b, Float c) {
  return hn::Min(a, hn::Min(b, c));
}
HWY_INLINE Float max3(Float a, Float b, Float c) {
  return hn::Max(a, hn::Max(b, c));
}

/// The lanes of these bits.
HWY_INLINE hn::Mask<Floats> lanes_of(std::uint32_t bits) {
  const Int bit = hn::Shl(hn::Set(ints, 1), hn::Iota(ints, 0));
  return hn::RebindMask(floats, hn::TestBit(hn::Set(ints, static_cast<std::int32_t>(bits)), bit));
}

HWY_INLINE Float load(const PrimitiveRow& row, std::size_t lane) {
  return hn::Load(floats, row.data() + lane);
}
HWY_INLINE Vector load(const std::array<PrimitiveRow, 3>& rows, std::size_t lane) {
  return {load(rows[0], lane), load(rows[1], lane), load(rows[2], lane)};
}
HWY_INLINE Vector spread(const std::array<PrimitiveRow, 3>& rows, std::size_t lane) {
  return {hn::Set(floats, rows[0][lane]), hn::Set(floats, rows[1][lane]), hn::Set(floats, rows[2][lane])};
}

/// The lanes from this one on whose boxes meet a box. Places their corners and boxes.
template <std::size_t size, class Places>
HWY_INLINE std::uint32_t place_lanes(const LocalPoints& points, const Places& places, const FloatBox& box,
                                     std::size_t lane, CornerLanes<size>& placed) {
  const hn::Rebind<std::uint8_t, Ints> bytes;
  Int place[size];
  for (std::size_t i = 0; i < size; ++i)
    place[i] = hn::PromoteTo(ints, hn::LoadU(bytes, places[i].data() + lane));
  auto meets = hn::FirstN(floats, lanes());
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& row = k == 0 ? points.x : k == 1 ? points.y : points.z;
    Float lower;
    Float upper;
    for (std::size_t i = 0; i < size; ++i) {
      const Float x = pick(row, place[i]);
      hn::Store(x, floats, placed.corner[i][k].data() + lane);
      lower = i == 0 ? x : hn::Min(lower, x);
      upper = i == 0 ? x : hn::Max(upper, x);
    }
    hn::Store(lower, floats, placed.lower[k].data() + lane);
    hn::Store(upper, floats, placed.upper[k].data() + lane);
    meets = hn::And(meets, hn::And(hn::Le(lower, hn::Set(floats, box.upper[k])),
                                   hn::Le(hn::Set(floats, box.lower[k]), upper)));
  }
  return bits_of(floats, meets);
}

std::uint32_t place_segments(const LocalPoints& points, const CornerPlaces<2>& places, const FloatBox& box,
                             SegmentLanes& segments) {
  std::uint32_t all = 0;
  for (std::size_t lane = 0; lane < Cluster::most_primitives; lane += lanes())
    all |= place_lanes<2>(points, places, box, lane, segments) << lane;
  return all;
}

/// The inverse of a squared length; 0 if that underflows or overflows.
HWY_INLINE Float inverse_of(Float squared_length) {
  constexpr float smallest = 1e-30F;  // of full precision, here and in its inverse
  constexpr float largest = 1e37F;
  const auto is_precise = hn::And(hn::Gt(squared_length, hn::Set(floats, smallest)),
                                  hn::Le(squared_length, hn::Set(floats, largest)));
  return hn::IfThenElseZero(is_precise, hn::Div(hn::Set(floats, 1.0F), squared_length));
}

HWY_INLINE void place_normals(std::size_t lane, TriangleLanes& triangles) {
  const Vector x0 = load(triangles.corner[0], lane);
  const Vector u = difference(load(triangles.corner[1], lane), x0);
  const Vector v = difference(load(triangles.corner[2], lane), x0);
  const Vector normal = cross(u, v);
  const Float zero = hn::Zero(floats);
  const Float du = dot(normal, u);
  const Float dv = dot(normal, v);
  hn::Store(normal.x, floats, triangles.normal[0].data() + lane);
  hn::Store(normal.y, floats, triangles.normal[1].data() + lane);
  hn::Store(normal.z, floats, triangles.normal[2].data() + lane);
  hn::Store(min3(zero, du, dv), floats, triangles.lowest.data() + lane);
  hn::Store(max3(zero, du, dv), floats, triangles.highest.data() + lane);
  hn::Store(inverse_of(dot(normal, normal)), floats, triangles.inverse.data() + lane);
}

std::uint32_t place_triangles(const LocalPoints& points, const Cluster& cluster, const FloatBox& box,
                              TriangleLanes& triangles, FloatBox& around) {
  const Float most = hn::Set(floats, std::numeric_limits<float>::max());
  Vector lowest{most, most, most};
  Vector highest{hn::Neg(most), hn::Neg(most), hn::Neg(most)};
  std::uint32_t all = 0;
  for (std::size_t lane = 0; lane < Cluster::most_primitives; lane += lanes()) {
    const std::uint32_t here = place_lanes<3>(points, cluster.corners, box, lane, triangles);
    if (here == 0) continue;
    all |= here << lane;
    place_normals(lane, triangles);
    const auto meets = lanes_of(here);
    const Vector lower = load(triangles.lower, lane);
    const Vector upper = load(triangles.upper, lane);
    lowest = {hn::Min(lowest.x, hn::IfThenElse(meets, lower.x, most)),
              hn::Min(lowest.y, hn::IfThenElse(meets, lower.y, most)),
              hn::Min(lowest.z, hn::IfThenElse(meets, lower.z, most))};
    highest = {hn::Max(highest.x, hn::IfThenElse(meets, upper.x, hn::Neg(most))),
               hn::Max(highest.y, hn::IfThenElse(meets, upper.y, hn::Neg(most))),
               hn::Max(highest.z, hn::IfThenElse(meets, upper.z, hn::Neg(most)))};
  }
  if (all == 0) return 0;
  around.lower = {hn::GetLane(hn::MinOfLanes(floats, lowest.x)),
                  hn::GetLane(hn::MinOfLanes(floats, lowest.y)),
                  hn::GetLane(hn::MinOfLanes(floats, lowest.z))};
  around.upper = {hn::GetLane(hn::MaxOfLanes(floats, highest.x)),
                  hn::GetLane(hn::MaxOfLanes(floats, highest.y)),
                  hn::GetLane(hn::MaxOfLanes(floats, highest.z))};
  return all;
}

/// A segment (a, b) and a triangle with sides u and v, relative to the triangle's first corner.
struct SegmentAndTriangle {
  Vector a;
  Vector b;
  Vector u;
  Vector v;
};

/// Square of a gap, given times the length of a vector with this inverse of its squared length. Zero where
/// they overlap or the square overflows.
HWY_INLINE Float squared_gap(Float gap, Float inverse) {
  const Float positive = hn::Max(hn::Zero(floats), gap);
  const Float squared = hn::Mul(hn::Mul(positive, positive), inverse);
  return hn::IfThenElseZero(hn::Le(squared, hn::Set(floats, std::numeric_limits<float>::max())), squared);
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
  return squared_gap(hn::Max(above, below), inverse_of(dot(direction, direction)));
}

/// Distances of the segment in a lane from triangles.
class SegmentGaps {
 public:
  SegmentGaps(const TriangleLanes& triangles, const SegmentLanes& segments, std::size_t segment, float within)
      : triangles_(triangles),
        a_(spread(segments.corner[0], segment)),
        b_(spread(segments.corner[1], segment)),
        lower_(spread(segments.lower, segment)),
        upper_(spread(segments.upper, segment)),
        within_(within) {}

  /// Lower bounds of the distances of triangles from this lane on, and in `left` the bits of those within.
  /// Not all bounds are computed if no triangle of `left` is within.
  HWY_INLINE Float bound(std::size_t lane, std::uint32_t& left) const {
    const Vector lower = load(triangles_.lower, lane);
    const Vector upper = load(triangles_.upper, lane);
    const Float of_boxes = max3(hn::Max(hn::Sub(lower.x, upper_.x), hn::Sub(lower_.x, upper.x)),
                                hn::Max(hn::Sub(lower.y, upper_.y), hn::Sub(lower_.y, upper.y)),
                                hn::Max(hn::Sub(lower.z, upper_.z), hn::Sub(lower_.z, upper.z)));
    if ((left &= bits_of(floats, hn::Le(of_boxes, hn::Set(floats, within_)))) == 0) return of_boxes;
    constexpr float up = 1.0F + 1e-5F;  // for rounding
    const Float squared_within = hn::Set(floats, up * within_ * within_);
    const auto are_far = [&](Float squared) HWY_ATTR {
      return (left &= bits_of(floats, hn::Le(squared, squared_within))) == 0;
    };
    const Vector x0 = load(triangles_.corner[0], lane);
    SegmentAndTriangle pair{difference(a_, x0), difference(b_, x0), {}, {}};
    Float most = along_normal(pair, lane);
    // Most triangles are beyond the margin along their normal already.
    if (are_far(most)) return of_boxes;
    pair.u = difference(load(triangles_.corner[1], lane), x0);
    pair.v = difference(load(triangles_.corner[2], lane), x0);
    const Vector along = difference(b_, a_);
    for (const Vector& side : {pair.u, pair.v, difference(pair.v, pair.u)}) {
      most = hn::Max(most, squared_gap(pair, cross(along, side)));
      if (are_far(most)) return of_boxes;
    }
    return hn::Max(of_boxes, hn::Sqrt(most));
  }

 private:
  HWY_INLINE Float along_normal(const SegmentAndTriangle& pair, std::size_t lane) const {
    const Vector normal = load(triangles_.normal, lane);
    const Float da = dot(normal, pair.a);
    const Float db = dot(normal, pair.b);
    const Float above = hn::Sub(hn::Min(da, db), load(triangles_.highest, lane));
    const Float below = hn::Sub(load(triangles_.lowest, lane), hn::Max(da, db));
    return squared_gap(hn::Max(above, below), load(triangles_.inverse, lane));
  }

  const TriangleLanes& triangles_;
  Vector a_;
  Vector b_;
  Vector lower_;
  Vector upper_;
  float within_;
};

std::uint32_t find_near_triangles(const TriangleLanes& triangles, const SegmentLanes& segments,
                                  std::uint32_t which,
                                  const std::array<std::uint16_t, Cluster::most_primitives>& wanted,
                                  float margin, float rounding, NearSegments& found) {
  const float within = margin + rounding;
  std::uint32_t all = 0;
  for (; which != 0; which &= which - 1) {
    const auto segment = static_cast<std::size_t>(std::countr_zero(which));
    const SegmentGaps gaps(triangles, segments, segment, within);
    NearTriangles near;
    Float least = hn::Set(floats, std::numeric_limits<float>::max());
    for (std::size_t lane = 0; lane < Cluster::most_primitives; lane += lanes()) {
      const std::uint32_t here = std::uint32_t{wanted[segment]} >> lane & ((1U << lanes()) - 1U);
      std::uint32_t left = here;
      if (left == 0) continue;
      const Float gap = gaps.bound(lane, left);
      if (left == 0) continue;
      const std::uint32_t close = bits_of(floats, hn::Le(gap, hn::Set(floats, within))) & here;
      near.near |= close << lane;
      near.touching |= (bits_of(floats, hn::Le(gap, hn::Set(floats, rounding))) & close) << lane;
      least = hn::Min(least, hn::IfThenElse(lanes_of(close), gap, least));
    }
    if (near.near == 0) continue;
    near.apart = hn::GetLane(hn::MinOfLanes(floats, least)) - rounding;
    found[segment] = near;
    all |= 1U << segment;
  }
  return all;
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(place_segments);
HWY_EXPORT(place_triangles);
HWY_EXPORT(find_near_triangles);

std::uint32_t place_meeting(const LocalPoints& points, const CornerPlaces<2>& places, const FloatBox& box,
                            SegmentLanes& segments) {
  return HWY_DYNAMIC_DISPATCH(place_segments)(points, places, box, segments);
}
std::uint32_t place_meeting(const LocalPoints& points, const Cluster& cluster, const FloatBox& box,
                            TriangleLanes& triangles, FloatBox& around) {
  return HWY_DYNAMIC_DISPATCH(place_triangles)(points, cluster, box, triangles, around);
}
std::uint32_t find_near_triangles(const TriangleLanes& triangles, const SegmentLanes& segments,
                                  std::uint32_t which,
                                  const std::array<std::uint16_t, Cluster::most_primitives>& wanted,
                                  float margin, float rounding, NearSegments& found) {
  return HWY_DYNAMIC_DISPATCH(find_near_triangles)(triangles, segments, which, wanted, margin, rounding,
                                                   found);
}

}  // namespace palpate::simd
#endif
