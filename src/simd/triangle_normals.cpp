#include "simd/triangle_normals.hpp"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/triangle_normals.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own header after foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 8>;
using Double = hn::Vec<Doubles>;
constexpr Doubles doubles;

/// Sums in the order of geometry/vector.hpp, so that all bits are those of the same work one by one.
struct Vector {
  Double x;
  Double y;
  Double z;
};
HWY_INLINE Vector load(const TrianglePoints::Rows& rows, std::size_t lane) {
  return {hn::Load(doubles, rows.x.data() + lane), hn::Load(doubles, rows.y.data() + lane),
          hn::Load(doubles, rows.z.data() + lane)};
}
HWY_INLINE Vector difference(const Vector& a, const Vector& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Vector cross(const Vector& a, const Vector& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE Double dot(const Vector& a, const Vector& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE Vector scaled(Double s, const Vector& a) {
  return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)};
}
HWY_INLINE Vector sum(const Vector& a, const Vector& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}

void interpolate_normals(TrianglePoints& points, std::size_t size) {
  const Double zero = hn::Zero(doubles);
  for (std::size_t lane = 0; lane < size; lane += hn::Lanes(doubles)) {
    const Vector point = load(points.point, lane);
    const Vector corner[3] = {load(points.corner[0], lane), load(points.corner[1], lane),
                              load(points.corner[2], lane)};
    const Vector area = cross(difference(corner[1], corner[0]), difference(corner[2], corner[0]));
    const Vector to[3] = {difference(corner[0], point), difference(corner[1], point),
                          difference(corner[2], point)};
    Double weight[3] = {dot(cross(to[1], to[2]), area), dot(cross(to[2], to[0]), area),
                        dot(cross(to[0], to[1]), area)};
    Double total = zero;
    for (Double& w : weight) {
      w = hn::IfThenElseZero(hn::Gt(w, zero), w);
      total = hn::Add(total, w);
    }
    const auto has_area = hn::Gt(total, zero);
    Vector mean{zero, zero, zero};
    for (std::size_t i = 0; i < 3; ++i) {
      const Double w = hn::IfThenElse(has_area, hn::Div(weight[i], total), hn::Set(doubles, 1.0 / 3.0));
      hn::Store(w, doubles, points.weight[i].data() + lane);
      mean = sum(mean, scaled(w, load(points.corner_normal[i], lane)));
    }
    const Double length = hn::Sqrt(dot(mean, mean));
    const auto is_length =
        hn::And(hn::Gt(length, zero), hn::Le(length, hn::Set(doubles, std::numeric_limits<double>::max())));
    const Vector normal = scaled(hn::Div(hn::Set(doubles, 1.0), length), mean);
    hn::Store(hn::IfThenElseZero(is_length, normal.x), doubles, points.normal.x.data() + lane);
    hn::Store(hn::IfThenElseZero(is_length, normal.y), doubles, points.normal.y.data() + lane);
    hn::Store(hn::IfThenElseZero(is_length, normal.z), doubles, points.normal.z.data() + lane);
  }
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(interpolate_normals);

void interpolate_normals(TrianglePoints& points, std::size_t size) {
  HWY_DYNAMIC_DISPATCH(interpolate_normals)(points, size);
}

}  // namespace palpate::simd
#endif
