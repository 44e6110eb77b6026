// Clusters with one lane for each primitive; used by the kernels of both queries. Included once for each
// target.
#if defined(PALPATE_SIMD_CLUSTER_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_SIMD_CLUSTER_LANES_INL
#undef PALPATE_SIMD_CLUSTER_LANES_INL
#else
#define PALPATE_SIMD_CLUSTER_LANES_INL
#endif

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <hwy/highway.h>

#include "simd/cluster_query.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, Cluster::most_primitives>;
using Ints = hn::RebindToSigned<Floats>;
using Float = hn::Vec<Floats>;
using Int = hn::Vec<Ints>;
constexpr Floats floats;
constexpr Ints ints;

constexpr std::size_t lanes() {
  return hn::MaxLanes(floats);
}
static_assert(Cluster::most_primitives % hn::MaxLanes(Floats()) == 0);

/// The mask as a number: bit i is lane i.
template <class D>
HWY_INLINE std::uint32_t bits_of([[maybe_unused]] D d, hn::Mask<D> mask) {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3
  return static_cast<std::uint32_t>(mask.raw);  // without StoreMaskBits, which goes through memory
#else
  std::array<std::uint8_t, 8> bytes{};
  hn::StoreMaskBits(d, mask, bytes.data());
  return bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8;
#endif
}

/// Compaction table: in the row whose number is the bits of the mask, entry i is the source lane of lane i of
/// the result.
template <std::size_t n>
constexpr auto make_places_kept() {
  std::array<std::array<std::uint8_t, n>, std::size_t{1} << n> places{};
  for (std::size_t bits = 0; bits < places.size(); ++bits) {
    std::size_t count = 0;
    for (std::size_t lane = 0; lane < n; ++lane)
      if ((bits >> lane & 1) != 0) places[bits][count++] = static_cast<std::uint8_t>(lane);
  }
  return places;
}
constexpr std::size_t few_lanes = lanes() < 16 ? lanes() : 1;
constexpr auto places_kept = make_places_kept<few_lanes>();

/// Stores the lanes that a mask keeps, contiguously. Values after them are undefined. Returns the number of
/// lanes kept. Highway's Compress copies its table at each call (1.0.3, GCC), except with AVX-512, which
/// needs none.
HWY_INLINE std::size_t store_kept(Int numbers, hn::Mask<Ints> keep, std::int32_t* to) {
  const std::uint32_t bits = bits_of(ints, keep);
  if constexpr (lanes() == 16) {
    hn::StoreU(hn::Compress(numbers, keep), ints, to);
  } else {
    const hn::Rebind<std::uint8_t, Ints> bytes;
    const Int places = hn::PromoteTo(ints, hn::LoadU(bytes, places_kept[bits].data()));
    hn::StoreU(hn::TableLookupLanes(numbers, hn::IndicesFromVec(ints, places)), ints, to);
  }
  return static_cast<std::size_t>(std::popcount(bits));
}

/// The first `size` numbers, or as many as there are lanes; zeros after them. Reads nothing beyond, and needs
/// no alignment (MaskedLoad does without AVX).
template <class D, class T>
HWY_INLINE hn::Vec<D> load_some(D d, const T* from, std::size_t size) {
  if (size >= lanes()) return hn::LoadU(d, from);
  alignas(64) T some[lanes()] = {};
  for (std::size_t i = 0; i < size; ++i) some[i] = from[i];
  return hn::Load(d, some);
}
/// Stores the first `size` numbers, or as many as there are lanes.
template <class D, class T>
HWY_INLINE void store_some(hn::Vec<D> numbers, D d, T* to, std::size_t size) {
  if (size >= lanes()) return hn::StoreU(numbers, d, to);
  alignas(64) T some[lanes()];
  hn::Store(numbers, d, some);
  for (std::size_t i = 0; i < size; ++i) to[i] = some[i];
}

struct Vector {
  Float x;
  Float y;
  Float z;
};
HWY_INLINE Vector difference(const Vector& a, const Vector& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Float cross_part(Float ay, Float bz, Float az, Float by) {
  return hn::MulSub(ay, bz, hn::Mul(az, by));
}
HWY_INLINE Vector cross(const Vector& a, const Vector& b) {
  return {cross_part(a.y, b.z, a.z, b.y), cross_part(a.z, b.x, a.x, b.z), cross_part(a.x, b.y, a.y, b.x)};
}
HWY_INLINE Float dot(const Vector& a, const Vector& b) {
  return hn::MulAdd(a.z, b.z, hn::MulAdd(a.y, b.y, hn::Mul(a.x, b.x)));
}
}  // namespace
}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
