#include "simd/fixed_points.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/fixed_points.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

std::int32_t placed(double x, double lower, double scale) {
  const double number = (x - lower) * scale;
  constexpr double most = 2147483647.0;
  // A comparison with NaN is false, so NaN becomes 0.
  return number > -most ? static_cast<std::int32_t>(std::min(number, most)) : 0;
}

void place_one(const Vec3& x, const Vec3& lower, double scale, FixedPoint& point, Bounds& bounds) {
  point.x = placed(x.x, lower.x, scale);
  point.y = placed(x.y, lower.y, scale);
  point.z = placed(x.z, lower.z, scale);
  bounds.lower = {std::min(bounds.lower.x, x.x), std::min(bounds.lower.y, x.y),
                  std::min(bounds.lower.z, x.z)};
  bounds.upper = {std::max(bounds.upper.x, x.x), std::max(bounds.upper.y, x.y),
                  std::max(bounds.upper.z, x.z)};
  bounds.finite = bounds.finite && std::isfinite(x.x) && std::isfinite(x.y) && std::isfinite(x.z);
}

Bounds place_points(std::span<const Vec3> positions, const Vec3& lower, double scale, FixedPoint* points) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Bounds bounds{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}, true};
  std::size_t i = 0;
#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE
  if (!positions.empty()) {
    const hn::FixedTag<double, 4> d;
    const hn::FixedTag<std::int32_t, 4> ints;
    alignas(32) std::array<double, 4> numbers{lower.x, lower.y, lower.z, lower.x};
    const auto from = hn::Load(d, numbers.data());
    const auto factor = hn::Set(d, scale);
    const auto coordinates = hn::FirstN(ints, 3);
    auto least = hn::Set(d, infinity);
    auto most = hn::Set(d, -infinity);
    auto zero = hn::Zero(d);  // is NaN if a coordinate is not finite
    // The fourth lane reads the next point's x, so the last point is done separately.
    for (; i + 1 < positions.size(); ++i) {
      const auto x = hn::LoadU(d, &positions[i].x);
      least = hn::Min(least, x);
      most = hn::Max(most, x);
      zero = hn::Add(zero, hn::Mul(x, hn::Zero(d)));
      const auto number = hn::DemoteTo(ints, hn::Mul(hn::Sub(x, from), factor));
      const auto old = hn::Load(ints, &points[i].x);
      hn::Store(hn::IfThenElse(coordinates, number, old), ints, &points[i].x);
    }
    hn::Store(least, d, numbers.data());
    bounds.lower = {numbers[0], numbers[1], numbers[2]};
    hn::Store(most, d, numbers.data());
    bounds.upper = {numbers[0], numbers[1], numbers[2]};
    hn::Store(zero, d, numbers.data());
    bounds.finite = numbers[0] == 0.0 && numbers[1] == 0.0 && numbers[2] == 0.0;
  }
#endif
  for (; i < positions.size(); ++i) place_one(positions[i], lower, scale, points[i], bounds);
  return bounds;
}

void coarse_words(std::span<const FixedPoint> points, int coarse_shift, std::int32_t* words,
                  std::int32_t* names) {
#if HWY_TARGET != HWY_SCALAR
  const hn::CappedTag<std::int32_t, 16> d;
  const auto mask = hn::Set(d, Coarse::mask);
  const auto coarse = [&](auto number) { return hn::And(hn::ShiftRightSame(number, coarse_shift), mask); };
  for (std::size_t i = 0; i < points.size(); i += hn::Lanes(d)) {
    auto x = hn::Zero(d);
    auto y = x;
    auto z = x;
    auto name = x;
    hn::LoadInterleaved4(d, &points.data()[i].x, x, y, z, name);
    const auto yz =
        hn::Or(hn::ShiftLeft<Coarse::step>(coarse(y)), hn::ShiftLeft<2 * Coarse::step>(coarse(z)));
    hn::StoreU(hn::Or(coarse(x), yz), d, words + i);
    hn::StoreU(name, d, names + i);
  }
#else
  for (std::size_t i = 0; i < points.size(); ++i) {
    const FixedPoint& p = points[i];
    const auto coarse = [&](std::int32_t number) { return number >> coarse_shift & Coarse::mask; };
    words[i] = Coarse::word(coarse(p.x), coarse(p.y), coarse(p.z));
    names[i] = p.name;
  }
#endif
}

std::int32_t largest_motion(std::span<const FixedPoint> points, std::span<const FixedPoint> references) {
  std::int32_t largest = 0;
  std::size_t i = 0;
#if HWY_TARGET != HWY_SCALAR
  const hn::CappedTag<std::int32_t, 16> d;
  const std::size_t at_a_time = hn::Lanes(d) / 4;
  auto most = hn::Zero(d);
  // Names are equal, so the differences in their lanes are zero.
  for (; at_a_time > 0 && i + at_a_time <= points.size(); i += at_a_time) {
    const auto motion = hn::Sub(hn::LoadU(d, &points[i].x), hn::LoadU(d, &references[i].x));
    most = hn::Max(most, hn::Abs(motion));
  }
  largest = hn::GetLane(hn::MaxOfLanes(d, most));
#endif
  for (; i < points.size(); ++i) {
    largest = std::max({largest, std::abs(points[i].x - references[i].x),
                        std::abs(points[i].y - references[i].y), std::abs(points[i].z - references[i].z)});
  }
  return largest;
}

std::uint32_t key_of(const FixedPoint& point, const KeyRule& rule) {
  const auto cell = [&](std::int32_t number, std::size_t axis) {
    return static_cast<std::uint32_t>(std::min(number >> rule.fraction_bits, rule.size[axis] - 1));
  };
  const auto size_x = static_cast<std::uint32_t>(rule.size[0]);
  const auto size_y = static_cast<std::uint32_t>(rule.size[1]);
  return cell(point.x, 0) + size_x * (cell(point.y, 1) + size_y * cell(point.z, 2));
}

void linear_keys(std::span<const FixedPoint> points, const KeyRule& rule, std::uint32_t* keys) {
  std::size_t i = 0;
#if HWY_TARGET != HWY_SCALAR
  const hn::CappedTag<std::int32_t, 16> d;
  const std::size_t lanes = hn::Lanes(d);
  const auto size_x = hn::Set(d, rule.size[0]);
  const auto size_y = hn::Set(d, rule.size[1]);
  const auto cell = [&](auto number, std::size_t axis) {
    return hn::Min(hn::ShiftRightSame(number, rule.fraction_bits), hn::Set(d, rule.size[axis] - 1));
  };
  for (; i + lanes <= points.size(); i += lanes) {
    auto x = hn::Zero(d);
    auto y = x;
    auto z = x;
    auto name = x;
    hn::LoadInterleaved4(d, &points[i].x, x, y, z, name);
    const auto plane = hn::Add(cell(y, 1), hn::Mul(size_y, cell(z, 2)));
    const auto key = hn::Add(cell(x, 0), hn::Mul(size_x, plane));
    hn::StoreU(hn::BitCast(hn::RebindToUnsigned<decltype(d)>(), key), hn::RebindToUnsigned<decltype(d)>(),
               keys + i);
  }
#endif
  for (; i < points.size(); ++i) keys[i] = key_of(points[i], rule);
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(place_points);
HWY_EXPORT(linear_keys);
HWY_EXPORT(largest_motion);
HWY_EXPORT(coarse_words);

Bounds place_points(std::span<const Vec3> positions, const Vec3& lower, double scale, FixedPoint* points) {
  return HWY_DYNAMIC_DISPATCH(place_points)(positions, lower, scale, points);
}

void linear_keys(std::span<const FixedPoint> points, const KeyRule& rule, std::uint32_t* keys) {
  HWY_DYNAMIC_DISPATCH(linear_keys)(points, rule, keys);
}

void coarse_words(std::span<const FixedPoint> points, int coarse_shift, std::int32_t* words,
                  std::int32_t* names) {
  HWY_DYNAMIC_DISPATCH(coarse_words)(points, coarse_shift, words, names);
}

std::int32_t largest_motion(std::span<const FixedPoint> points, std::span<const FixedPoint> references) {
  return HWY_DYNAMIC_DISPATCH(largest_motion)(points, references);
}

}  // namespace palpate::simd
#endif
