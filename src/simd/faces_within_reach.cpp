#include "simd/faces_within_reach.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/faces_within_reach.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our header is compiled for each target, so it comes after that.
#include "simd/vector_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void find_faces_within_reach(ReachingPoints& points, std::size_t size) {
  const Double zero = hn::Zero(doubles);
  for (std::size_t lane = 0; lane < size; lane += hn::Lanes(doubles)) {
    const Vector p = load(points.point, lane);
    const Vector x[4] = {load(points.corner[0], lane), load(points.corner[1], lane),
                         load(points.corner[2], lane), load(points.corner[3], lane)};
    const Double reach = load(points.reach, lane);
    const Double reach2 = hn::Mul(reach, reach);
    const auto is_beyond = [&](const Vector& a, const Vector& b, const Vector& c) {
      const Vector normal = cross(difference(b, a), difference(c, a));
      const Double to_plane = dot(difference(a, p), normal);
      const auto is_far = hn::Ge(hn::Mul(to_plane, to_plane), hn::Mul(reach2, dot(normal, normal)));
      const auto has_area = hn::Or(hn::Or(hn::Ne(normal.x, zero), hn::Ne(normal.y, zero)),  //
                                   hn::Ne(normal.z, zero));
      return hn::And(is_far, has_area);
    };
    // Corners in the order of outward_face.
    const auto beyond = hn::And(hn::And(is_beyond(x[1], x[2], x[3]), is_beyond(x[0], x[3], x[2])),
                                hn::And(is_beyond(x[0], x[1], x[3]), is_beyond(x[0], x[2], x[1])));
    store(hn::IfThenElse(beyond, zero, hn::Set(doubles, 1.0)), points.meets, lane);
  }
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(find_faces_within_reach);

void find_faces_within_reach(ReachingPoints& points, std::size_t size) {
  HWY_DYNAMIC_DISPATCH(find_faces_within_reach)(points, size);
}

}  // namespace palpate::simd
#endif
