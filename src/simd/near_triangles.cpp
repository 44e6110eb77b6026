#include "simd/near_triangles.hpp"

#include <bit>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/near_triangles.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our headers are compiled for each target, so they come after that.
#include "simd/cluster_lanes-inl.hpp"
#include "simd/row_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

HWY_INLINE Float load(const PrimitiveRow& row, std::size_t lane) {
  return hn::Load(floats, row.data() + lane);
}

/// Places boxes, and finds the lanes whose boxes meet a box.
/// \param around  of these lanes; null: not wanted
template <std::size_t size, class Places>
HWY_INLINE std::uint32_t place_boxes(const LocalPoints& points, const Places& places, const FloatBox& box,
                                     BoxLanes& placed, FloatBox* around) {
  const Float most = hn::Set(floats, std::numeric_limits<float>::max());
  Float lowest[3] = {most, most, most};
  Float highest[3] = {hn::Neg(most), hn::Neg(most), hn::Neg(most)};
  std::uint32_t all = 0;
  for (std::size_t lane = 0; lane < Cluster::most_primitives; lane += lanes()) {
    auto meets = hn::FirstN(floats, lanes());
    Float lower[3];
    Float upper[3];
    for (std::size_t i = 0; i < size; ++i) {
      const auto [x, y, z] = load_rows(
          floats, [&](std::size_t at) HWY_ATTR { return points.point[places[i][lane + at]].data(); });
      const Float corner[3] = {x, y, z};
      for (std::size_t k = 0; k < 3; ++k) {
        lower[k] = i == 0 ? corner[k] : hn::Min(lower[k], corner[k]);
        upper[k] = i == 0 ? corner[k] : hn::Max(upper[k], corner[k]);
      }
    }
    for (std::size_t k = 0; k < 3; ++k) {
      hn::Store(lower[k], floats, placed.lower[k].data() + lane);
      hn::Store(upper[k], floats, placed.upper[k].data() + lane);
      meets = hn::And(meets, hn::And(hn::Le(lower[k], hn::Set(floats, box.upper[k])),
                                     hn::Le(hn::Set(floats, box.lower[k]), upper[k])));
    }
    all |= bits_of(floats, meets) << lane;
    if (around == nullptr) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      lowest[k] = hn::Min(lowest[k], hn::IfThenElse(meets, lower[k], most));
      highest[k] = hn::Max(highest[k], hn::IfThenElse(meets, upper[k], hn::Neg(most)));
    }
  }
  for (std::size_t k = 0; around != nullptr && k < 3; ++k) {
    around->lower[k] = hn::GetLane(hn::MinOfLanes(floats, lowest[k]));
    around->upper[k] = hn::GetLane(hn::MaxOfLanes(floats, highest[k]));
  }
  return all;
}

std::uint32_t place_segments(const LocalPoints& points, const CornerPlaces<2>& places, const FloatBox& box,
                             BoxLanes& segments) {
  return place_boxes<2>(points, places, box, segments, nullptr);
}
std::uint32_t place_triangles(const LocalPoints& points, const Cluster& cluster, const FloatBox& box,
                              BoxLanes& triangles, FloatBox& around) {
  return place_boxes<3>(points, cluster.corners, box, triangles, &around);
}

std::uint32_t keep_within(float distance, const BoxLanes& boxes, std::uint32_t which, const BoxLanes& others,
                          std::array<std::uint16_t, Cluster::most_primitives>& others_of) {
  std::uint32_t all = 0;
  for (; which != 0; which &= which - 1) {
    const auto box = static_cast<std::size_t>(std::countr_zero(which));
    Float lower[3];
    Float upper[3];
    for (std::size_t k = 0; k < 3; ++k) {
      lower[k] = hn::Set(floats, boxes.lower[k][box] - distance);
      upper[k] = hn::Set(floats, boxes.upper[k][box] + distance);
    }
    std::uint32_t within = 0;
    for (std::size_t lane = 0; lane < Cluster::most_primitives; lane += lanes()) {
      const auto along = [&](std::size_t k) HWY_ATTR {
        return hn::And(hn::Le(load(others.lower[k], lane), upper[k]),
                       hn::Le(lower[k], load(others.upper[k], lane)));
      };
      within |= bits_of(floats, hn::And(along(0), hn::And(along(1), along(2)))) << lane;
    }
    others_of[box] = static_cast<std::uint16_t>(others_of[box] & within);
    all |= (others_of[box] != 0 ? 1U : 0U) << box;
  }
  return all;
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(place_segments);
HWY_EXPORT(place_triangles);
HWY_EXPORT(keep_within);

std::uint32_t place_meeting(const LocalPoints& points, const CornerPlaces<2>& places, const FloatBox& box,
                            BoxLanes& segments) {
  return HWY_DYNAMIC_DISPATCH(place_segments)(points, places, box, segments);
}
std::uint32_t place_meeting(const LocalPoints& points, const Cluster& cluster, const FloatBox& box,
                            BoxLanes& triangles, FloatBox& around) {
  return HWY_DYNAMIC_DISPATCH(place_triangles)(points, cluster, box, triangles, around);
}
std::uint32_t keep_within(float distance, const BoxLanes& boxes, std::uint32_t which, const BoxLanes& others,
                          std::array<std::uint16_t, Cluster::most_primitives>& others_of) {
  return HWY_DYNAMIC_DISPATCH(keep_within)(distance, boxes, which, others, others_of);
}

}  // namespace palpate::simd
#endif
