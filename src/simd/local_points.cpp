#include "simd/local_points.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/local_points.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our header is compiled for each target, so it comes after that.
#include "simd/point_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {

void read_points(const Vec3* positions, std::span<const Index> points, const Vec3& origin, double scale,
                 LocalPoints& local) {
  const hn::Rebind<float, CoordinateTag> in_float;
  const Coordinates by = hn::Set(coordinates, scale);
  for (std::size_t part = 0; part < parts; ++part) {
    const Coordinates from = load(origin, part);
    auto* to = local.point.data();
    for (const Index p : points) {
      const Coordinates x = hn::Mul(by, hn::Sub(load(positions[p], part), from));
      hn::StoreU(hn::DemoteTo(in_float, x), in_float, (to++)->data() + part);
    }
  }
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(read_points);

void read_points(const Vec3* positions, std::span<const Index> points, const Vec3& origin, double scale,
                 LocalPoints& local) {
  HWY_DYNAMIC_DISPATCH(read_points)(positions, points, origin, scale, local);
}

}  // namespace palpate::simd
#endif
