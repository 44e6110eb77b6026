#include "simd/key_changes.hpp"

#include <array>
#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/key_changes.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The mask as a number: bit i is lane i.
template <class D>
std::uint64_t bits_of(D d, hn::Mask<D> mask) {
  static_assert(hn::MaxLanes(D()) <= 16);
  std::array<std::uint8_t, 2> bytes{};
  hn::StoreMaskBits(d, mask, bytes.data());
  return bytes[0] | static_cast<std::uint64_t>(bytes[1]) << 8;
}

/// Appends the positions of the set bits. Always writes four without a test, since most words have few set
/// bits and a branch on their number would be mispredicted.
std::size_t append_places(std::uint64_t bits, std::uint32_t first, std::uint32_t* places) {
  const auto count = static_cast<std::size_t>(std::popcount(bits));
  for (std::size_t k = 0; k < 4 || k < count; ++k) {
    places[k] = first + static_cast<std::uint32_t>(std::countr_zero(bits));
    bits &= bits - 1;
  }
  return count;
}

std::size_t list_changes(std::span<const std::uint32_t> before, std::span<const std::uint32_t> now,
                         std::uint32_t first, std::uint32_t* changed) {
  const hn::CappedTag<std::uint32_t, 16> d;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t count = 0;
  std::size_t i = 0;
  // Uses neither CompressStore, which is microcoded on AMD, nor a branch per vector.
  for (; i + 64 <= before.size(); i += 64) {
    std::uint64_t bits = 0;
    for (std::size_t j = 0; j < 64; j += lanes) {
      const auto old_keys = hn::LoadU(d, before.data() + i + j);
      bits |= bits_of(d, hn::Ne(old_keys, hn::LoadU(d, now.data() + i + j))) << j;
    }
    count += append_places(bits, first + static_cast<std::uint32_t>(i), changed + count);
  }
  for (; i < before.size(); ++i) {
    if (before[i] != now[i]) changed[count++] = first + static_cast<std::uint32_t>(i);
  }
  return count;
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(list_changes);

std::size_t list_changes(std::span<const std::uint32_t> before, std::span<const std::uint32_t> now,
                         std::uint32_t first, std::uint32_t* changed) {
  return HWY_DYNAMIC_DISPATCH(list_changes)(before, now, first, changed);
}

std::size_t scalar::list_changes(std::span<const std::uint32_t> before, std::span<const std::uint32_t> now,
                                 std::uint32_t first, std::uint32_t* changed) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    changed[count] = first + static_cast<std::uint32_t>(i);
    count += before[i] != now[i] ? 1 : 0;
  }
  return count;
}

}  // namespace palpate::simd
#endif
