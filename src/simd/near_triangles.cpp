#include "simd/near_triangles.hpp"

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

/// \param around  of the lanes that meet the box; null: not wanted
template <std::size_t size, class Places>
HWY_INLINE std::uint32_t place_meeting_lanes(const LocalPoints& points, const Places& places,
                                             const FloatBox& box, CornerLanes<size>& placed,
                                             FloatBox* around) {
  const hn::Rebind<std::uint8_t, Ints> bytes;
  const Float most = hn::Set(floats, std::numeric_limits<float>::max());
  Float lowest[3] = {most, most, most};
  Float highest[3] = {hn::Neg(most), hn::Neg(most), hn::Neg(most)};
  std::uint32_t all = 0;
  for (std::size_t lane = 0; lane < Cluster::most_primitives; lane += lanes()) {
    auto meets = hn::FirstN(floats, lanes());
    Float lower[3];
    Float upper[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& row = k == 0 ? points.x : k == 1 ? points.y : points.z;
      for (std::size_t i = 0; i < size; ++i) {
        const Float x = pick(row, hn::PromoteTo(ints, hn::LoadU(bytes, places[i].data() + lane)));
        hn::Store(x, floats, placed.corner[i][k].data() + lane);
        lower[k] = i == 0 ? x : hn::Min(lower[k], x);
        upper[k] = i == 0 ? x : hn::Max(upper[k], x);
      }
      meets = hn::And(meets, hn::And(hn::Le(lower[k], hn::Set(floats, box.upper[k])),
                                     hn::Le(hn::Set(floats, box.lower[k]), upper[k])));
    }
    all |= bits_of(floats, meets) << lane;
    if (around == nullptr) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      lowest[k] = hn::Min(lowest[k], hn::IfThenElse(meets, lower[k], most));
      highest[k] = hn::Max(highest[k], hn::IfThenElse(meets, upper[k], hn::Neg(most)));
    }
  }
  for (std::size_t k = 0; around != nullptr && k < 3; ++k) {
    around->lower[k] = hn::GetLane(hn::MinOfLanes(floats, lowest[k]));
    around->upper[k] = hn::GetLane(hn::MaxOfLanes(floats, highest[k]));
  }
  return all;
}

std::uint32_t place_segments(const LocalPoints& points, const CornerPlaces<2>& places, const FloatBox& box,
                             SegmentLanes& segments) {
  return place_meeting_lanes<2>(points, places, box, segments, nullptr);
}
std::uint32_t place_triangles(const LocalPoints& points, const Cluster& cluster, const FloatBox& box,
                              TriangleLanes& triangles, FloatBox& around) {
  return place_meeting_lanes<3>(points, cluster.corners, box, triangles, &around);
}

/// A segment (a, b) and a triangle with sides u and v, relative to the triangle's first corner.
struct SegmentAndTriangle {
  Vector a;
  Vector b;
  Vector u;
  Vector v;
};

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
  const auto is_said = hn::And(hn::Gt(squared_length, hn::Set(floats, smallest)),
                               hn::Le(squared, hn::Set(floats, std::numeric_limits<float>::max())));
  return hn::IfThenElseZero(is_said, squared);
}

/// Gap of the boxes along an axis; negative where they overlap.
HWY_INLINE Float axis_gap(Float x0, Float x1, Float x2, Float a, Float b) {
  return hn::Max(hn::Sub(min3(x0, x1, x2), hn::Max(a, b)), hn::Sub(hn::Min(a, b), max3(x0, x1, x2)));
}

NearTriangles find_near_triangles(const TriangleLanes& triangles, std::uint32_t wanted,
                                  const SegmentLanes& segments, std::size_t segment, float margin,
                                  float rounding) {
  const auto end = [&](std::size_t i) {
    const auto& x = segments.corner[i];
    return Vector{hn::Set(floats, x[0][segment]), hn::Set(floats, x[1][segment]),
                  hn::Set(floats, x[2][segment])};
  };
  const Vector a = end(0);
  const Vector b = end(1);
  const Vector along = difference(b, a);
  const Float within = hn::Set(floats, margin + rounding);
  constexpr float up = 1.0F + 1e-5F;  // for rounding
  const Float squared_within = hn::Set(floats, up * (margin + rounding) * (margin + rounding));
  NearTriangles found;
  Float least = hn::Set(floats, std::numeric_limits<float>::max());
  for (std::size_t lane = 0; lane < Cluster::most_primitives; lane += lanes()) {
    const std::uint32_t here = wanted >> lane & ((1U << lanes()) - 1U);
    if (here == 0) continue;
    const auto corner = [&](std::size_t i) {
      return Vector{hn::Load(floats, triangles.corner[i][0].data() + lane),
                    hn::Load(floats, triangles.corner[i][1].data() + lane),
                    hn::Load(floats, triangles.corner[i][2].data() + lane)};
    };
    const Vector x0 = corner(0);
    const Vector x1 = corner(1);
    const Vector x2 = corner(2);
    const Float of_boxes = max3(axis_gap(x0.x, x1.x, x2.x, a.x, b.x), axis_gap(x0.y, x1.y, x2.y, a.y, b.y),
                                axis_gap(x0.z, x1.z, x2.z, a.z, b.z));
    std::uint32_t left = bits_of(floats, hn::Le(of_boxes, within)) & here;
    if (left == 0) continue;
    const SegmentAndTriangle pair{difference(a, x0), difference(b, x0), difference(x1, x0),
                                  difference(x2, x0)};
    Float most = squared_gap(pair, cross(pair.u, pair.v));
    // Most triangles are beyond the margin along their normal already.
    const auto are_far = [&] { return (left &= bits_of(floats, hn::Le(most, squared_within))) == 0; };
    if (are_far()) continue;
    most = hn::Max(most, squared_gap(pair, cross(along, pair.u)));
    if (are_far()) continue;
    most = hn::Max(most, squared_gap(pair, cross(along, pair.v)));
    if (are_far()) continue;
    most = hn::Max(most, squared_gap(pair, cross(along, difference(pair.v, pair.u))));
    const Float gap = hn::Max(of_boxes, hn::Sqrt(most));
    const std::uint32_t near = bits_of(floats, hn::Le(gap, within)) & here;
    found.near |= near << lane;
    found.touching |= (bits_of(floats, hn::Le(gap, hn::Set(floats, rounding))) & near) << lane;
    least = hn::Min(least, gap);
  }
  found.apart = hn::GetLane(hn::MinOfLanes(floats, least)) - rounding;
  return found;
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
NearTriangles find_near_triangles(const TriangleLanes& triangles, std::uint32_t wanted,
                                  const SegmentLanes& segments, std::size_t lane, float margin,
                                  float rounding) {
  return HWY_DYNAMIC_DISPATCH(find_near_triangles)(triangles, wanted, segments, lane, margin, rounding);
}

}  // namespace palpate::simd
#endif
