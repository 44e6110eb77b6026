#include "simd/separations.hpp"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/separations.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own header after foreach_target.h.
#include <hwy/highway.h>
// Our header is compiled for each target, so it comes after that.
#include "simd/vector_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A segment (a, b) and a triangle with sides u and v, relative to the triangle's first corner.
struct SegmentAndTriangle {
  Vector a;
  Vector b;
  Vector u;
  Vector v;
};

/// Squared gap between the two along a direction. Zero where they overlap, underflow or overflow.
HWY_INLINE Double squared_gap(const SegmentAndTriangle& pair, const Vector& direction) {
  const Double zero = hn::Zero(doubles);
  const Double da = dot(direction, pair.a);
  const Double db = dot(direction, pair.b);
  const Double du = dot(direction, pair.u);
  const Double dv = dot(direction, pair.v);
  const Double above = hn::Sub(hn::Min(da, db), hn::Max(zero, hn::Max(du, dv)));
  const Double below = hn::Sub(hn::Min(zero, hn::Min(du, dv)), hn::Max(da, db));
  const Double gap = hn::Max(zero, hn::Max(above, below));
  const Double squared_length = dot(direction, direction);
  constexpr double smallest = 1e-280;  // squared length with full precision
  const Double squared = hn::Div(hn::Mul(gap, gap), squared_length);
  const auto is_said = hn::And(hn::Gt(squared_length, hn::Set(doubles, smallest)),
                               hn::Le(squared, hn::Set(doubles, std::numeric_limits<double>::max())));
  return hn::IfThenElseZero(is_said, squared);
}

HWY_INLINE Double size_of(const Vector& v) {
  return hn::Add(hn::Add(hn::Abs(v.x), hn::Abs(v.y)), hn::Abs(v.z));
}

void find_separations(SegmentsAndTriangles& pairs, std::size_t size) {
  // Bound of the rounding errors, relative to the size of the pair.
  const Double rounding = hn::Set(doubles, 1e-14);
  for (std::size_t lane = 0; lane < size; lane += hn::Lanes(doubles)) {
    const Vector corner = load(pairs.corner[0], lane);
    const SegmentAndTriangle pair{
        difference(load(pairs.end[0], lane), corner), difference(load(pairs.end[1], lane), corner),
        difference(load(pairs.corner[1], lane), corner), difference(load(pairs.corner[2], lane), corner)};
    const Vector along = difference(pair.b, pair.a);
    const Double of_normal = squared_gap(pair, cross(pair.u, pair.v));
    const Double of_u = squared_gap(pair, cross(along, pair.u));
    const Double of_v = squared_gap(pair, cross(along, pair.v));
    const Double of_third = squared_gap(pair, cross(along, difference(pair.v, pair.u)));
    const Double most = hn::Max(hn::Max(of_normal, of_u), hn::Max(of_v, of_third));
    const Double extent =
        hn::Max(hn::Max(size_of(pair.a), size_of(pair.b)), hn::Max(size_of(pair.u), size_of(pair.v)));
    store(hn::Sub(hn::Sqrt(most), hn::Mul(rounding, extent)), pairs.apart, lane);
  }
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(find_separations);

void find_separations(SegmentsAndTriangles& pairs, std::size_t size) {
  HWY_DYNAMIC_DISPATCH(find_separations)(pairs, size);
}

}  // namespace palpate::simd
#endif
