#include "simd/merge_events.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/merge_events.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// One of the equal parts into which a merge is split. The parts are independent, so that the processor can
/// overlap them.
struct Stream {
  const std::uint64_t* in;
  const std::uint64_t* in_end;
  std::uint64_t* out;
  std::uint64_t* out_end;
  const std::uint64_t* event;
  const std::uint64_t* event_end;
};

/// Copies words up to the next event and applies the event. A step copies `vectors` vectors; words beyond the
/// event are overwritten later.
template <std::ptrdiff_t vectors>
HWY_INLINE void merge_one(Stream& s) {
  const hn::ScalableTag<std::uint64_t> d;
  const auto lanes = static_cast<std::ptrdiff_t>(hn::Lanes(d));
  const std::ptrdiff_t step = vectors * lanes;
  const std::uint64_t word = *s.event & ~removal;
  const auto bound = hn::Set(d, word);
  bool found = false;
  while (!found && s.in_end - s.in >= step && s.out_end - s.out >= step) {
    std::size_t smaller = 0;
    for (std::ptrdiff_t v = 0; v < vectors; ++v) {
      const auto copied = hn::LoadU(d, s.in + v * lanes);
      hn::StoreU(copied, d, s.out + v * lanes);
      smaller += hn::CountTrue(d, hn::Lt(copied, bound));
    }
    // The branch lets the processor start the next step before the count is known.
    found = s.in[step - 1] >= word;
    const auto taken = found ? static_cast<std::ptrdiff_t>(smaller) : step;
    s.in += taken;
    s.out += taken;
  }
  if (!found) {
    while (s.in < s.in_end && *s.in < word) *s.out++ = *s.in++;
  }
  const std::ptrdiff_t removes = (*s.event & removal) != 0 ? 1 : 0;
  if (s.out < s.out_end) *s.out = word;
  s.in += removes;
  s.out += 1 - removes;
  ++s.event;
}

/// The index of each event depends on the event before it. Four interleaved streams hide that latency.
constexpr std::size_t streams = 4;

template <std::ptrdiff_t vectors>
void merge_streams(std::array<Stream, streams>& all) {
  std::ptrdiff_t shortest = all[0].event_end - all[0].event;
  for (const Stream& s : all) shortest = std::min(shortest, s.event_end - s.event);
  for (std::ptrdiff_t e = 0; e < shortest; ++e)
    for (Stream& s : all) merge_one<vectors>(s);
  for (Stream& s : all) {
    while (s.event != s.event_end) merge_one<vectors>(s);
    std::copy(s.in, s.in_end, s.out);
  }
}

void merge_events(std::span<const std::uint64_t> words, std::span<const std::uint64_t> events,
                  std::span<std::uint64_t> merged) {
  std::array<Stream, streams> all{};
  const std::uint64_t* in = words.data();
  std::uint64_t* out = merged.data();
  for (std::size_t k = 0; k < streams; ++k) {
    const std::uint64_t* const event = events.data() + k * events.size() / streams;
    const std::uint64_t* const event_end = events.data() + (k + 1) * events.size() / streams;
    const std::uint64_t* in_end = words.data() + words.size();
    if (k + 1 < streams && event_end != events.data() + events.size())
      in_end = std::lower_bound(in, in_end, *event_end & ~removal);
    std::ptrdiff_t grows = 0;
    for (const std::uint64_t* e = event; e != event_end; ++e) grows += (*e & removal) != 0 ? -1 : 1;
    std::uint64_t* const out_end = out + (in_end - in) + grows;
    all[k] = {in, in_end, out, out_end, event, event_end};
    in = in_end;
    out = out_end;
  }
  // Use long steps where events are rare, short ones where they are dense.
  if (words.size() > hn::Lanes(hn::ScalableTag<std::uint64_t>()) * events.size()) {
    merge_streams<6>(all);
  } else {
    merge_streams<1>(all);
  }
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
    if ((event & removal) != 0) {
      ++i;
    } else {
      merged[o++] = word;
    }
  }
  std::copy(words.begin() + static_cast<std::ptrdiff_t>(i), words.end(),
            merged.begin() + static_cast<std::ptrdiff_t>(o));
}

}  // namespace palpate::simd
#endif
