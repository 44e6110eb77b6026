// Pairs of doubles from and to scattered places, one place per lane. A vector of the geometry is two pairs
// that overlap, so nothing beyond it is read. Included once for each target.
#if defined(PALPATE_SIMD_VECTOR_GATHER_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_SIMD_VECTOR_GATHER_INL
#undef PALPATE_SIMD_VECTOR_GATHER_INL
#else
#define PALPATE_SIMD_VECTOR_GATHER_INL
#endif

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <hwy/highway.h>

#include "simd/vector_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t double_lanes = hn::MaxLanes(doubles);

/// A block of as many items as there are lanes. Lanes beyond the end have the last item.
struct Block {
  std::size_t begin;
  std::size_t last;
  HWY_INLINE std::size_t item(std::size_t lane) const { return std::min(begin + lane, last); }
  [[nodiscard]] HWY_INLINE bool contains(std::size_t lane) const { return begin + lane <= last; }
};

/// Bit i is that of lane i.
HWY_INLINE std::uint32_t bits_of(hn::Mask<Doubles> mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(doubles, mask, bytes);
  return bytes[0];
}

struct PairLanes {
  Double first;
  Double second;
};

#if HWY_TARGET != HWY_SCALAR
using Pair = hn::FixedTag<double, 2>;
using FourDoubles = hn::CappedTag<double, 4>;

/// The pairs of every second lane, from `from` on.
template <class Place>
HWY_INLINE Double every_second_pair(const Place& place, std::size_t from) {
  const auto load = [&](std::size_t lane) HWY_ATTR { return hn::LoadU(Pair(), place(from + lane)); };
#if HWY_MAX_BYTES >= 64
  return hn::Combine(doubles, hn::Combine(FourDoubles(), load(6), load(4)),
                     hn::Combine(FourDoubles(), load(2), load(0)));
#elif HWY_MAX_BYTES >= 32
  return hn::Combine(doubles, load(2), load(0));
#else
  return load(0);
#endif
}

/// Inverse of every_second_pair().
template <class Place>
HWY_INLINE void store_every_second(Double pairs, const Place& place, std::size_t from) {
  const auto store = [&](auto pair, std::size_t lane)
                         HWY_ATTR { hn::StoreU(pair, Pair(), place(from + lane)); };
#if HWY_MAX_BYTES >= 64
  const auto lower = hn::LowerHalf(FourDoubles(), pairs);
  const auto upper = hn::UpperHalf(FourDoubles(), pairs);
  store(hn::LowerHalf(Pair(), lower), 0);
  store(hn::UpperHalf(Pair(), lower), 2);
  store(hn::LowerHalf(Pair(), upper), 4);
  store(hn::UpperHalf(Pair(), upper), 6);
#elif HWY_MAX_BYTES >= 32
  store(hn::LowerHalf(Pair(), pairs), 0);
  store(hn::UpperHalf(Pair(), pairs), 2);
#else
  store(pairs, 0);
#endif
}
#endif

/// The two doubles at place(lane), which is called for each lane just before its load, so that few addresses
/// are kept in registers.
template <class Place>
HWY_INLINE PairLanes load_pairs(const Place& place) {
#if HWY_TARGET == HWY_SCALAR
  return {hn::LoadU(doubles, place(0)), hn::LoadU(doubles, place(0) + 1)};
#else
  const Double even = every_second_pair(place, 0);
  const Double odd = every_second_pair(place, 1);
  return {hn::InterleaveLower(doubles, even, odd), hn::InterleaveUpper(doubles, even, odd)};
#endif
}

/// The vectors at place(lane).
template <class Place>
HWY_INLINE Vector load_vectors(const Place& place) {
  const PairLanes xy = load_pairs([&](std::size_t lane) HWY_ATTR { return &place(lane).x; });
  const PairLanes yz = load_pairs([&](std::size_t lane) HWY_ATTR { return &place(lane).y; });
  return {xy.first, xy.second, yz.second};
}

/// Inverse of load_pairs().
template <class Place>
HWY_INLINE void store_pairs(const PairLanes& pairs, const Place& place) {
#if HWY_TARGET == HWY_SCALAR
  hn::StoreU(pairs.first, doubles, place(0));
  hn::StoreU(pairs.second, doubles, place(0) + 1);
#else
  store_every_second(hn::InterleaveLower(doubles, pairs.first, pairs.second), place, 0);
  store_every_second(hn::InterleaveUpper(doubles, pairs.first, pairs.second), place, 1);
#endif
}

}  // namespace
}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
