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

#include "simd/row_lanes-inl.hpp"
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

/// A block whose lanes all have an item.
struct FullBlock {
  std::size_t begin;
  HWY_INLINE std::size_t item(std::size_t lane) const { return begin + lane; }
  [[nodiscard]] HWY_INLINE bool contains(std::size_t /*lane*/) const { return true; }
};
/// Calls use(block) for the blocks of some items.
template <class Use>
HWY_INLINE void for_each_block(std::size_t items, const Use& use) {
  std::size_t begin = 0;
  for (; begin + double_lanes <= items; begin += double_lanes) use(FullBlock{begin});
  if (begin < items) use(Block{begin, items - 1});
}

/// Bit i is that of lane i.
HWY_INLINE std::uint32_t bits_of(hn::Mask<Doubles> mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(doubles, mask, bytes);
  return bytes[0];
}

template <class D>
struct PairLanes {
  hn::Vec<D> first;
  hn::Vec<D> second;
};

#if HWY_TARGET != HWY_SCALAR
using Pair = hn::FixedTag<double, 2>;
using FourDoubles = hn::CappedTag<double, 4>;

/// Inverse of every_nth(): pairs to every second lane.
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
template <class D, class Place>
HWY_INLINE PairLanes<D> load_pairs(D d, const Place& place) {
#if HWY_TARGET == HWY_SCALAR
  return {hn::LoadU(d, place(0)), hn::LoadU(d, place(0) + 1)};
#else
  const auto even = every_nth(d, place, 0);
  const auto odd = every_nth(d, place, 1);
  return {hn::InterleaveLower(d, even, odd), hn::InterleaveUpper(d, even, odd)};
#endif
}

/// The vectors at place(lane).
template <class D, class Place>
HWY_INLINE VectorOf<hn::Vec<D>> load_vectors(D d, const Place& place) {
  const PairLanes<D> xy = load_pairs(d, [&](std::size_t lane) HWY_ATTR { return &place(lane).x; });
  const PairLanes<D> yz = load_pairs(d, [&](std::size_t lane) HWY_ATTR { return &place(lane).y; });
  return {xy.first, xy.second, yz.second};
}
template <class Place>
HWY_INLINE Vector load_vectors(const Place& place) {
  return load_vectors(doubles, place);
}
/// The positions of points, one index per lane.
template <class D>
HWY_INLINE VectorOf<hn::Vec<D>> load_points(D d, const Vec3* positions, const std::int32_t* points) {
  return load_vectors(d, [&](std::size_t lane) HWY_ATTR -> const Vec3& { return positions[points[lane]]; });
}

/// Inverse of load_pairs().
template <class Place>
HWY_INLINE void store_pairs(const PairLanes<Doubles>& pairs, const Place& place) {
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
