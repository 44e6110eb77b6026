#include "simd/reached_pairs.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/reached_pairs.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our header is compiled for each target, so it comes after that.
#include "simd/cluster_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {

ReachedPairs find_reached(std::span<const float> distances, float limit, float least, std::int32_t* places) {
  ReachedPairs found;
  const Float bound = hn::Set(floats, limit);
  Float lowest = hn::Set(floats, least);
  Int place = hn::Iota(ints, 0);
  // What is not a number is reached.
  const auto take = [&](Float distance, hn::Mask<Floats> beyond, hn::Mask<Floats> ours) HWY_ATTR {
    lowest = hn::IfThenElse(beyond, hn::Min(lowest, distance), lowest);
    const auto reached = hn::RebindMask(ints, hn::AndNot(beyond, ours));
    if (!hn::AllFalse(ints, reached)) found.size += store_kept(place, reached, places + found.size);
    place = hn::Add(place, hn::Set(ints, static_cast<std::int32_t>(lanes())));
  };
  const auto all = hn::FirstN(floats, lanes());
  std::size_t i = 0;
  for (; i + lanes() <= distances.size(); i += lanes()) {
    const Float distance = hn::LoadU(floats, distances.data() + i);
    take(distance, hn::Lt(bound, distance), all);
  }
  if (i < distances.size()) {
    const auto ours = hn::FirstN(floats, distances.size() - i);
    const Float distance = load_some(floats, distances.data() + i, distances.size() - i);
    take(distance, hn::And(ours, hn::Lt(bound, distance)), ours);
  }
  found.least = hn::GetLane(hn::MinOfLanes(floats, lowest));
  return found;
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(find_reached);

ReachedPairs find_reached(std::span<const float> distances, float limit, float least, std::int32_t* places) {
  return HWY_DYNAMIC_DISPATCH(find_reached)(distances, limit, least, places);
}

}  // namespace palpate::simd
#endif
