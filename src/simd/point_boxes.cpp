#include "simd/point_boxes.hpp"

#include <cstddef>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/point_boxes.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 4>;
using Double = hn::Vec<Doubles>;
constexpr Doubles doubles;

/// A vector has up to four coordinates of a point, from this offset on. Offsets overlap, so that no load goes
/// beyond the point.
constexpr std::size_t lanes = hn::MaxLanes(Doubles());
constexpr std::size_t offsets = lanes == 4 ? 1 : 4 - lanes;

HWY_INLINE Double load(const Vec3& point, std::size_t offset) {
  if constexpr (lanes == 4) return hn::MaskedLoad(hn::FirstN(doubles, 3), doubles, &point.x);
  return hn::LoadU(doubles, &point.x + offset);
}

struct Range {
  Double lower;
  Double upper;
};
HWY_INLINE Range nothing() {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  return {hn::Set(doubles, infinity), hn::Set(doubles, -infinity)};
}
HWY_INLINE void extend(Range& range, Double x) {
  range.lower = hn::Min(range.lower, x);
  range.upper = hn::Max(range.upper, x);
}
HWY_INLINE void store(const Range& range, PointBox& box, std::size_t offset) {
  hn::StoreU(range.lower, doubles, box.lower.data() + offset);
  hn::StoreU(range.upper, doubles, box.upper.data() + offset);
}

template <bool wants_remainders>
HWY_INLINE void find(const Vec3* now, const Vec3* before, std::span<const Index> points,
                     const LinearMotion* common, PointBoxes& boxes) {
  for (std::size_t offset = 0; offset < offsets; ++offset) {
    Range places = nothing();
    Range displacements = nothing();
    Range remainders = nothing();
    for (const Index p : points) {
      const Vec3& from = before[p];
      const Double to = load(now[p], offset);
      const Double displacement = hn::Sub(to, load(from, offset));
      extend(places, to);
      extend(displacements, displacement);
      if constexpr (wants_remainders) {
        const auto column = [&](std::size_t k)
                                HWY_ATTR { return hn::LoadU(doubles, (*common)[k].data() + offset); };
        Double moved = hn::MulAdd(hn::Set(doubles, from.x), column(0), column(3));
        moved = hn::MulAdd(hn::Set(doubles, from.y), column(1), moved);
        moved = hn::MulAdd(hn::Set(doubles, from.z), column(2), moved);
        extend(remainders, hn::Sub(displacement, moved));
      }
    }
    store(places, boxes.places, offset);
    store(displacements, boxes.displacements, offset);
    if constexpr (wants_remainders) store(remainders, boxes.remainders, offset);
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
