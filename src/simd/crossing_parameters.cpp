#include "simd/crossing_parameters.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/crossing_parameters.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our header is compiled for each target, so it comes after that.
#include "simd/vector_gather-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

struct Filtered {
  Double value;
  Double error;
};

/// orient3d() from two sides u and v of a triangle and the vector w from the same corner to a point, with the
/// same order of operations.
HWY_INLINE Filtered orientation(const Vector& u, const Vector& v, const Vector& w) {
  const Double vxwy = hn::Mul(v.x, w.y);
  const Double vywx = hn::Mul(v.y, w.x);
  const Double wxuy = hn::Mul(w.x, u.y);
  const Double wyux = hn::Mul(w.y, u.x);
  const Double uxvy = hn::Mul(u.x, v.y);
  const Double uyvx = hn::Mul(u.y, v.x);
  const Double value = hn::Add(hn::Add(hn::Mul(u.z, hn::Sub(vxwy, vywx)), hn::Mul(v.z, hn::Sub(wxuy, wyux))),
                               hn::Mul(w.z, hn::Sub(uxvy, uyvx)));
  const Double uz = hn::Abs(u.z);
  const Double vz = hn::Abs(v.z);
  const Double wz = hn::Abs(w.z);
  const auto sizes = [](Double a, Double b) { return hn::Add(hn::Abs(a), hn::Abs(b)); };
  const Double permanent = hn::Add(hn::Add(hn::Mul(uz, sizes(vxwy, vywx)), hn::Mul(vz, sizes(wxuy, wyux))),
                                   hn::Mul(wz, sizes(uxvy, uyvx)));
  const Double underflow = hn::Mul(hn::Set(doubles, OrientationBound::tiny),
                                   hn::Add(hn::Add(hn::Add(hn::Set(doubles, 4.0), uz), vz), wz));
  return {value, hn::Add(hn::Mul(hn::Set(doubles, OrientationBound::relative), permanent), underflow)};
}

}  // namespace

void find_parameters(const Vec3* positions, SegmentsInTriangles& segments, std::size_t size) {
  const Double zero = hn::Zero(doubles);
  const Double one = hn::Set(doubles, 1.0);
  const Double accuracy = hn::Set(doubles, parameter_accuracy);
  for (std::size_t lane = 0; lane < size; lane += hn::Lanes(doubles)) {
    const Vector t0 = load_points(doubles, positions, &segments.corner[0][lane]);
    const Vector u = difference(load_points(doubles, positions, &segments.corner[1][lane]), t0);
    const Vector v = difference(load_points(doubles, positions, &segments.corner[2][lane]), t0);
    const Filtered a =
        orientation(u, v, difference(load_points(doubles, positions, &segments.end[0][lane]), t0));
    const Filtered b =
        orientation(u, v, difference(load_points(doubles, positions, &segments.end[1][lane]), t0));
    const auto tells = [&](const Filtered& f) {
      return hn::Lt(f.error, hn::Mul(accuracy, hn::Abs(f.value)));
    };
    const Double passage = hn::Sub(a.value, b.value);
    const Double ratio = hn::Div(a.value, passage);
    const Double clamped =
        hn::IfThenElse(hn::Lt(ratio, zero), zero, hn::IfThenElse(hn::Lt(one, ratio), one, ratio));
    store(hn::IfThenElse(hn::And(tells(a), tells(b)), clamped, hn::Set(doubles, -1.0)), segments.parameter,
          lane);
    store(passage, segments.passage, lane);
  }
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(find_parameters);

void find_parameters(const Vec3* positions, SegmentsInTriangles& segments, std::size_t size) {
  HWY_DYNAMIC_DISPATCH(find_parameters)(positions, segments, size);
}

}  // namespace palpate::simd
#endif
