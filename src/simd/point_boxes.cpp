#include "simd/point_boxes.hpp"

#include <cstddef>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/point_boxes.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our header is compiled for each target, so it comes after that.
#include "simd/point_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {

struct Range {
  Coordinates lower;
  Coordinates upper;
};
HWY_INLINE Range nothing() {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  return {hn::Set(coordinates, infinity), hn::Set(coordinates, -infinity)};
}
HWY_INLINE void extend(Range& range, Coordinates x) {
  range.lower = hn::Min(range.lower, x);
  range.upper = hn::Max(range.upper, x);
}
HWY_INLINE void store(const Range& range, PointBox& box, std::size_t part) {
  hn::StoreU(range.lower, coordinates, box.lower.data() + part);
  hn::StoreU(range.upper, coordinates, box.upper.data() + part);
}

template <bool wants_remainders>
HWY_INLINE void find(const Vec3* now, const Vec3* before, std::span<const Index> points,
                     const LinearMotion* common, PointBoxes& boxes) {
  for (std::size_t part = 0; part < parts; ++part) {
    Range places = nothing();
    Range displacements = nothing();
    Range remainders = nothing();
    for (const Index p : points) {
      const Vec3& from = before[p];
      const Coordinates to = load(now[p], part);
      const Coordinates displacement = hn::Sub(to, load(from, part));
      extend(places, to);
      extend(displacements, displacement);
      if constexpr (wants_remainders) {
        const auto column = [&](std::size_t k)
                                HWY_ATTR { return hn::LoadU(coordinates, (*common)[k].data() + part); };
        Coordinates moved = hn::MulAdd(hn::Set(coordinates, from.x), column(0), column(3));
        moved = hn::MulAdd(hn::Set(coordinates, from.y), column(1), moved);
        moved = hn::MulAdd(hn::Set(coordinates, from.z), column(2), moved);
        extend(remainders, hn::Sub(displacement, moved));
      }
    }
    store(places, boxes.places, part);
    store(displacements, boxes.displacements, part);
    if constexpr (wants_remainders) store(remainders, boxes.remainders, part);
  }
}

void find_boxes(const Vec3* now, const Vec3* before, std::span<const Index> points,
                const LinearMotion* common, PointBoxes& boxes) {
  if (common == nullptr) return find<false>(now, before, points, common, boxes);
  return find<true>(now, before, points, common, boxes);
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(find_boxes);

void find_boxes(const Vec3* now, const Vec3* before, std::span<const Index> points,
                const LinearMotion* common, PointBoxes& boxes) {
  HWY_DYNAMIC_DISPATCH(find_boxes)(now, before, points, common, boxes);
}

}  // namespace palpate::simd
#endif
