// The coordinates of a point in lanes. Included once for each target.
#if defined(PALPATE_SIMD_POINT_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_SIMD_POINT_LANES_INL
#undef PALPATE_SIMD_POINT_LANES_INL
#else
#define PALPATE_SIMD_POINT_LANES_INL
#endif

#include <cstddef>
#include <hwy/highway.h>

#include <palpate/types.hpp>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using CoordinateTag = hn::CappedTag<double, 4>;
using Coordinates = hn::Vec<CoordinateTag>;
constexpr CoordinateTag coordinates;

/// Part i of a point has its coordinates from i on, as many as there are lanes. Parts overlap, so that no
/// load goes beyond the point. A single part has a zero as its fourth coordinate.
constexpr std::size_t parts = hn::MaxLanes(CoordinateTag()) == 4 ? 1 : 4 - hn::MaxLanes(CoordinateTag());

HWY_INLINE Coordinates load(const Vec3& point, std::size_t part) {
  if constexpr (parts == 1) return hn::MaskedLoad(hn::FirstN(coordinates, 3), coordinates, &point.x);
  return hn::LoadU(coordinates, &point.x + part);
}

}  // namespace
}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
