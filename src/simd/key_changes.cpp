#include "simd/key_changes.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/key_changes.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own header after foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

std::size_t list_changes(std::span<const std::uint32_t> before, std::span<const std::uint32_t> now,
                         std::uint32_t first, std::uint32_t* changed) {
  const hn::ScalableTag<std::uint32_t> d;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t count = 0;
  std::size_t i = 0;
  // A vector stored at `count` <= i ends at or before i + lanes: it never leaves the room of the list.
  for (; i + lanes <= before.size(); i += lanes) {
    const auto differs = hn::Ne(hn::LoadU(d, before.data() + i), hn::LoadU(d, now.data() + i));
    if (hn::AllFalse(d, differs)) continue;
    const auto references = hn::Iota(d, first + static_cast<std::uint32_t>(i));
    count += hn::CompressStore(references, differs, d, changed + count);
  }
  for (; i < before.size(); ++i) {
    changed[count] = first + static_cast<std::uint32_t>(i);
    count += before[i] != now[i] ? 1 : 0;
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
