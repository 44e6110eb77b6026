#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "simd/cluster.hpp"
#include "simd/local_points.hpp"

namespace palpate::simd {

/// Corners of 16 triangles (size 3) or segments (2): a lane for each, [corner][lane], as indices in the list
/// of a cluster's points.
template <std::size_t size>
using CornerPlaces = std::array<std::array<std::uint8_t, Cluster::most_primitives>, size>;

/// A number for each lane.
using PrimitiveRow = std::array<float, Cluster::most_primitives>;
/// Boxes of 16 primitives: [axis][lane].
struct BoxLanes {
  alignas(64) std::array<PrimitiveRow, 3> lower;
  alignas(64) std::array<PrimitiveRow, 3> upper;
};
/// Box in float.
struct FloatBox {
  std::array<float, 3> lower;
  std::array<float, 3> upper;
};

/// Places the boxes of segments, and finds the lanes whose boxes meet a box.
std::uint32_t place_meeting(const LocalPoints& points, const CornerPlaces<2>& places, const FloatBox& box,
                            BoxLanes& segments);
/// The same for the triangles of a cluster (its first three corners). Sets `around` to the box of the
/// triangles that meet the box.
std::uint32_t place_meeting(const LocalPoints& points, const Cluster& cluster, const FloatBox& box,
                            BoxLanes& triangles, FloatBox& around);

/// For each box of `which` (bits): removes the lanes whose boxes are beyond a distance along an axis from
/// those that it has in `others_of`. Returns the bits of the boxes that keep some.
std::uint32_t keep_within(float distance, const BoxLanes& boxes, std::uint32_t which, const BoxLanes& others,
                          std::array<std::uint16_t, Cluster::most_primitives>& others_of);

}  // namespace palpate::simd
