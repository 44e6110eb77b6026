// Rows of a slice in lanes of float: conversion from quads in memory and back, and sums in double.
// Included once for each target.
#if defined(PALPATE_SIMD_SLICE_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_SIMD_SLICE_LANES_INL
#undef PALPATE_SIMD_SLICE_LANES_INL
#else
#define PALPATE_SIMD_SLICE_LANES_INL
#endif

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <hwy/highway.h>

#include "simd/sliced_rows.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET != HWY_SCALAR && !HWY_HAVE_SCALABLE

using Floats = hn::CappedTag<float, slice_rows>;
using FloatV = hn::Vec<Floats>;
constexpr std::size_t float_lanes = hn::MaxLanes(Floats());

struct QuadLanes {
  FloatV x, y, z, w;
};

/// Vector k of a transposition: load(k), load(k + 4), load(k + 8) and load(k + 12), each four floats.
template <class Load>
HWY_INLINE FloatV fours(Load&& load, std::size_t k) {
  [[maybe_unused]] const hn::CappedTag<float, 8> d8;
  [[maybe_unused]] const Floats whole;
#if HWY_MAX_BYTES >= 64
  return hn::Combine(whole, hn::Combine(d8, load(k + 12), load(k + 8)),
                     hn::Combine(d8, load(k + 4), load(k)));
#elif HWY_MAX_BYTES >= 32
  return hn::Combine(d8, load(k + 4), load(k));
#else
  return load(k);
#endif
}

/// Lane i: the four floats that load(i) gives.
template <class Load>
HWY_INLINE QuadLanes transposed(Load&& load) {
  const Floats d;
  const hn::Repartition<double, Floats> pairs;
  const FloatV v0 = fours(load, 0);
  const FloatV v1 = fours(load, 1);
  const FloatV v2 = fours(load, 2);
  const FloatV v3 = fours(load, 3);
  const auto xy01 = hn::BitCast(pairs, hn::InterleaveLower(d, v0, v1));
  const auto xy23 = hn::BitCast(pairs, hn::InterleaveLower(d, v2, v3));
  const auto zw01 = hn::BitCast(pairs, hn::InterleaveUpper(d, v0, v1));
  const auto zw23 = hn::BitCast(pairs, hn::InterleaveUpper(d, v2, v3));
  return {hn::BitCast(d, hn::InterleaveLower(pairs, xy01, xy23)),
          hn::BitCast(d, hn::InterleaveUpper(pairs, xy01, xy23)),
          hn::BitCast(d, hn::InterleaveLower(pairs, zw01, zw23)),
          hn::BitCast(d, hn::InterleaveUpper(pairs, zw01, zw23))};
}

/// Lane i: quads[places[i]], where places are indices.
HWY_INLINE QuadLanes load_quads(const Quad* quads, const std::uint32_t* places) {
  return transposed([&](std::size_t i) { return hn::Load(hn::FixedTag<float, 4>(), &quads[places[i]].x); });
}
/// Lane i: quads[i].
HWY_INLINE QuadLanes load_rows_of(const Quad* quads) {
  return transposed([&](std::size_t i) { return hn::Load(hn::FixedTag<float, 4>(), &quads[i].x); });
}

/// The inverse conversion; writes zero to the fourth value of each quad.
HWY_INLINE void store_rows_of(const QuadLanes& v, Quad* quads) {
  const Floats d;
  const hn::Repartition<double, Floats> pairs;
  const FloatV zero = hn::Zero(d);
  const auto xy01 = hn::BitCast(pairs, hn::InterleaveLower(d, v.x, v.y));
  const auto xy23 = hn::BitCast(pairs, hn::InterleaveUpper(d, v.x, v.y));
  const auto z01 = hn::BitCast(pairs, hn::InterleaveLower(d, v.z, zero));
  const auto z23 = hn::BitCast(pairs, hn::InterleaveUpper(d, v.z, zero));
  const auto store = [&](auto rows, std::size_t k) {
    alignas(64) std::array<float, float_lanes> values;
    hn::Store(hn::BitCast(d, rows), d, values.data());
    const hn::FixedTag<float, 4> four;
    for (std::size_t i = 0; i < float_lanes; i += 4)
      hn::Store(hn::Load(four, values.data() + i), four, &quads[k + i].x);
  };
  store(hn::InterleaveLower(pairs, xy01, z01), 0);
  store(hn::InterleaveUpper(pairs, xy01, z01), 1);
  store(hn::InterleaveLower(pairs, xy23, z23), 2);
  store(hn::InterleaveUpper(pairs, xy23, z23), 3);
}

/// Adds floats in double, since in float the rounding of many terms would make solver steps inexact. Row i is
/// added to partial sum i % 8, and the partial sums are added in a fixed order, whatever the number of lanes:
/// the same bits on every target.
class Sum {
 public:
  HWY_INLINE Sum() { sums_.fill(hn::Zero(doubles)); }
  /// Adds the next rows. Call in row order, for whole slices.
  HWY_INLINE void add(FloatV value) {
    const hn::Half<Floats> half;
    const auto low = hn::PromoteTo(doubles, hn::LowerHalf(half, value));
    const auto high = hn::PromoteTo(doubles, hn::UpperHalf(half, value));
    if constexpr (parts == 1) {
      sums_[0] = hn::Add(hn::Add(sums_[0], low), high);
    } else {
      sums_[0] = hn::Add(sums_[0], low);
      sums_[1] = hn::Add(sums_[1], high);
      // The next call adds to the other partial sums.
      if constexpr (parts > 2) std::rotate(sums_.begin(), sums_.begin() + 2, sums_.end());
    }
  }
  [[nodiscard]] HWY_INLINE double total() const {
    alignas(64) std::array<double, count> s;
    for (std::size_t k = 0; k < parts; ++k)
      hn::Store(sums_[k], doubles, s.data() + k * hn::MaxLanes(doubles));
    return ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
  }

 private:
  using Doubles = hn::Repartition<double, Floats>;
  static constexpr Doubles doubles{};
  static constexpr std::size_t count = 8;
  static constexpr std::size_t parts = count / hn::MaxLanes(Doubles());
  std::array<hn::Vec<Doubles>, parts> sums_;
};

#endif

}  // namespace
}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
