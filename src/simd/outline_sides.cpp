#include "simd/outline_sides.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/outline_sides.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our header is compiled for each target, so it comes after that.
#include "simd/vector_gather-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using Sides = hn::CappedTag<double, 4>;
constexpr Sides sides_tag;
using Number = hn::Vec<Sides>;
using SideVector = VectorOf<Number>;

HWY_INLINE SideVector all(const Vec3& v) {
  return {hn::Set(sides_tag, v.x), hn::Set(sides_tag, v.y), hn::Set(sides_tag, v.z)};
}
/// As silhouette.cpp does it for one side, with the same order of operations.
HWY_INLINE void find(const Vec3* positions, const SideVector& x, const SideVector& d, std::size_t lane,
                     OutlineSides& sides) {
  const Number zero = hn::Zero(sides_tag);
  const Number one = hn::Set(sides_tag, 1.0);
  const auto across = [&](const SideVector& point) HWY_ATTR {
    const SideVector from_line = difference(point, x);
    return difference(from_line, scaled(dot(from_line, d), d));
  };
  const SideVector a = across(load_points(sides_tag, positions, &sides.from[lane]));
  const SideVector ab = difference(across(load_points(sides_tag, positions, &sides.to[lane])), a);
  const Number length2 = dot(ab, ab);
  const Number ratio = hn::Div(hn::Neg(dot(a, ab)), length2);
  const Number clamped =
      hn::IfThenElse(hn::Lt(ratio, zero), zero, hn::IfThenElse(hn::Lt(one, ratio), one, ratio));
  const Number t = hn::IfThenElseZero(hn::Lt(zero, length2), clamped);
  const SideVector offset = sum(a, scaled(t, ab));
  const SideVector n0 = load_points(sides_tag, positions, &sides.neighbor[0][lane]);
  const SideVector area = cross(difference(load_points(sides_tag, positions, &sides.neighbor[1][lane]), n0),
                                difference(load_points(sides_tag, positions, &sides.neighbor[2][lane]), n0));
  hn::Store(offset.x, sides_tag, sides.x.data() + lane);
  hn::Store(offset.y, sides_tag, sides.y.data() + lane);
  hn::Store(offset.z, sides_tag, sides.z.data() + lane);
  hn::Store(hn::Sqrt(dot(offset, offset)), sides_tag, sides.distance.data() + lane);
  hn::Store(length2, sides_tag, sides.length2.data() + lane);
  hn::Store(hn::Div(dot(area, d), hn::Sqrt(dot(area, area))), sides_tag, sides.facing.data() + lane);
}

}  // namespace

void find_sides(const Vec3* positions, const Vec3& origin, const Vec3& direction, OutlineSides& sides) {
  const SideVector x = all(origin);
  const SideVector d = all(direction);
  for (std::size_t lane = 0; lane < 3; lane += hn::MaxLanes(sides_tag)) find(positions, x, d, lane, sides);
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(find_sides);

void find_sides(const Vec3* positions, const Vec3& origin, const Vec3& direction, OutlineSides& sides) {
  HWY_DYNAMIC_DISPATCH(find_sides)(positions, origin, direction, sides);
}

}  // namespace palpate::simd
#endif
