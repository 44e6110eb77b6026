#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "simd/cluster.hpp"

namespace palpate::simd {

/// The points of a cluster, relative to an origin nearby.
struct LocalPoints {
  alignas(64) std::array<float, Cluster::most_points> x;
  alignas(64) std::array<float, Cluster::most_points> y;
  alignas(64) std::array<float, Cluster::most_points> z;
};
/// Corners of 16 triangles (size 3) or segments (2): a lane for each, [corner][lane], as indices in the list
/// of a cluster's points.
template <std::size_t size>
using CornerPlaces = std::array<std::array<std::uint8_t, Cluster::most_primitives>, size>;

/// Coordinates of these corners: [corner][axis][lane].
template <std::size_t size>
struct CornerLanes {
  alignas(64) std::array<std::array<std::array<float, Cluster::most_primitives>, 3>, size> corner;
};
using TriangleLanes = CornerLanes<3>;
using SegmentLanes = CornerLanes<2>;

/// Box in float.
struct FloatBox {
  std::array<float, 3> lower;
  std::array<float, 3> upper;
};

/// Triangles near a segment; a bit for each lane.
struct NearTriangles {
  std::uint32_t near = 0;      ///< those that may be within the margin
  std::uint32_t touching = 0;  ///< those of them that may touch it
  float apart = 0.0F;          ///< lower bound of the distance from each near one
};

/// Places the corners of segments, and finds the lanes whose boxes meet a box.
std::uint32_t place_meeting(const LocalPoints& points, const CornerPlaces<2>& places, const FloatBox& box,
                            SegmentLanes& segments);
/// place_meeting() for the triangles of a cluster (its first three corners). Sets `around` to the box of the
/// triangles that meet the box.
std::uint32_t place_meeting(const LocalPoints& points, const Cluster& cluster, const FloatBox& box,
                            TriangleLanes& triangles, FloatBox& around);

/// Tests the segment in a lane against the triangles of `wanted`, by lower bounds of their distance: the gap
/// of their boxes, and along four directions (the triangle's normal, and the cross products of the segment
/// and each side). \param margin    beyond this distance a triangle is not near \param rounding  bound of the
/// errors of a distance by rounding, those of the coordinates included
NearTriangles find_near_triangles(const TriangleLanes& triangles, std::uint32_t wanted,
                                  const SegmentLanes& segments, std::size_t lane, float margin,
                                  float rounding);

}  // namespace palpate::simd
