#include "simd/reached_pairs.hpp"

#include <algorithm>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/reached_pairs.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our header is compiled for each target, so it comes after that.
#include "simd/cluster_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {

using IntMask = hn::Mask<Ints>;

/// Which edges have an end in contact with the other body, and which ends have several contacts.
struct InContact {
  IntMask surely;
  IntMask perhaps;
};
HWY_INLINE InContact in_contact(const ContactsOfEdges& contacts, Int edge) {
  const Int twice = hn::ShiftLeft<1>(edge);
  const Int ends[2] = {hn::GatherIndex(ints, contacts.edges->data(), twice),
                       hn::GatherIndex(ints, contacts.edges->data() + 1, twice)};
  const Range& own = contacts.points_of_first;
  const IntMask of_second =
      hn::Lt(outside(ends[0], hn::Set(ints, own.begin), hn::Set(ints, own.end - 1)), hn::Zero(ints));
  const Int other = hn::IfThenElse(of_second, hn::Set(ints, contacts.first), hn::Set(ints, contacts.second));
  const auto find = [&](Int point) HWY_ATTR {
    const Int place = hn::Add(point, hn::ShiftLeft<1>(point));
    const IntMask several = hn::Gt(hn::GatherIndex(ints, contacts.of_point + 1, place), hn::Set(ints, 1));
    return InContact{hn::AndNot(several, hn::Eq(hn::GatherIndex(ints, contacts.of_point + 2, place), other)),
                     several};
  };
  const InContact a = find(ends[0]);
  const InContact b = find(ends[1]);
  const IntMask surely = hn::Or(a.surely, b.surely);
  return {surely, hn::AndNot(surely, hn::Or(a.perhaps, b.perhaps))};
}

/// Leaves out and marks the pairs with an end in contact.
HWY_INLINE void keep_free(const PairColumns& pairs, const ContactsOfEdges& contacts, std::int32_t* places,
                          ReachedPairs& found) {
  const std::size_t size = std::exchange(found.size, 0);
  for (std::size_t i = 0; i < size; i += lanes()) {
    const IntMask ours = hn::FirstN(ints, std::min(lanes(), size - i));
    const Int place = hn::IfThenElseZero(ours, hn::LoadU(ints, places + i));
    const InContact touching = in_contact(contacts, hn::GatherIndex(ints, pairs.edge, place));
    const IntMask keep = hn::AndNot(touching.surely, ours);
    const Int mark = hn::IfThenElseZero(touching.perhaps, hn::Set(ints, ReachedPairs::unsure));
    found.size += store_kept(hn::Or(place, mark), keep, places + found.size);
    const IntMask leave_out = hn::And(touching.surely, ours);
    if (hn::AllFalse(ints, leave_out)) continue;
    std::int32_t left_out[lanes()];
    const std::size_t count = store_kept(place, leave_out, left_out);
    for (std::size_t k = 0; k < count; ++k) pairs.apart[left_out[k]] = apart_by_contact;
  }
}

}  // namespace

ReachedPairs find_reached(const PairColumns& pairs, float limit, float least, const ContactsOfEdges& contacts,
                          std::int32_t* places) {
  ReachedPairs found;
  const Float bound = hn::Set(floats, limit);
  Float lowest = hn::Set(floats, least);
  Int place = hn::Iota(ints, 0);
  // What is not a number is reached.
  const auto take = [&](Float apart, hn::Mask<Floats> beyond, hn::Mask<Floats> ours) HWY_ATTR {
    lowest = hn::IfThenElse(beyond, hn::Min(lowest, apart), lowest);
    const IntMask reached = hn::RebindMask(ints, hn::AndNot(beyond, ours));
    if (!hn::AllFalse(ints, reached)) found.size += store_kept(place, reached, places + found.size);
    place = hn::Add(place, hn::Set(ints, static_cast<std::int32_t>(lanes())));
  };
  const auto all = hn::FirstN(floats, lanes());
  std::size_t i = 0;
  for (; i + lanes() <= pairs.size; i += lanes()) {
    const Float apart = hn::LoadU(floats, pairs.apart + i);
    take(apart, hn::Lt(bound, apart), all);
  }
  if (i < pairs.size) {
    const auto ours = hn::FirstN(floats, pairs.size - i);
    const Float apart = load_some(floats, pairs.apart + i, pairs.size - i);
    take(apart, hn::And(ours, hn::Lt(bound, apart)), ours);
  }
  found.least = hn::GetLane(hn::MinOfLanes(floats, lowest));
  if (found.size > 0) keep_free(pairs, contacts, places, found);
  return found;
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(find_reached);

ReachedPairs find_reached(const PairColumns& pairs, float limit, float least, const ContactsOfEdges& contacts,
                          std::int32_t* places) {
  return HWY_DYNAMIC_DISPATCH(find_reached)(pairs, limit, least, contacts, places);
}

}  // namespace palpate::simd
#endif
