#include "simd/merge_events.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/merge_events.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own header after foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void merge_events(std::span<const std::uint64_t> words, std::span<const std::uint64_t> events,
                  std::span<std::uint64_t> merged) {
  const hn::ScalableTag<std::uint64_t> d;
  const std::size_t lanes = hn::Lanes(d);
  const std::uint64_t* const in = words.data();
  std::uint64_t* const out = merged.data();
  const std::size_t in_size = words.size();
  const std::size_t out_size = merged.size();
  std::size_t i = 0;
  std::size_t o = 0;
  for (const std::uint64_t event : events) {
    const std::uint64_t word = event & ~removal;
    const auto bound = hn::Set(d, word);
    // Whole vectors are copied, also words beyond the event: what follows overwrites them.
    std::size_t smaller = lanes;
    while (smaller == lanes && i + lanes <= in_size && o + lanes <= out_size) {
      const auto v = hn::LoadU(d, in + i);
      hn::StoreU(v, d, out + o);
      smaller = hn::CountTrue(d, hn::Lt(v, bound));
      i += smaller;
      o += smaller;
    }
    if (smaller == lanes) {
      while (i < in_size && in[i] < word) out[o++] = in[i++];
    }
    const std::size_t removes = (event & removal) != 0 ? 1 : 0;
    if (o < out_size) out[o] = word;
    i += removes;
    o += 1 - removes;
  }
  std::copy(words.begin() + static_cast<std::ptrdiff_t>(i), words.end(),
            merged.begin() + static_cast<std::ptrdiff_t>(o));
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(merge_events);

void merge_events(std::span<const std::uint64_t> words, std::span<const std::uint64_t> events,
                  std::span<std::uint64_t> merged) {
  HWY_DYNAMIC_DISPATCH(merge_events)(words, events, merged);
}

void scalar::merge_events(std::span<const std::uint64_t> words, std::span<const std::uint64_t> events,
                          std::span<std::uint64_t> merged) {
  std::size_t i = 0;
  std::size_t o = 0;
  for (const std::uint64_t event : events) {
    const std::uint64_t word = event & ~removal;
    while (i < words.size() && words[i] < word) merged[o++] = words[i++];
    if ((event & removal) != 0)
      ++i;
    else
      merged[o++] = word;
  }
  std::copy(words.begin() + static_cast<std::ptrdiff_t>(i), words.end(),
            merged.begin() + static_cast<std::ptrdiff_t>(o));
}

}  // namespace palpate::simd
#endif
