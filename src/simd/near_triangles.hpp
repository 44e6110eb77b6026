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

/// A number for each lane.
using PrimitiveRow = std::array<float, Cluster::most_primitives>;
/// These corners, and the boxes of the primitives, all [axis].
template <std::size_t size>
struct CornerLanes {
  alignas(64) std::array<std::array<PrimitiveRow, 3>, size> corner;
  alignas(64) std::array<PrimitiveRow, 3> lower;
  alignas(64) std::array<PrimitiveRow, 3> upper;
};
using SegmentLanes = CornerLanes<2>;
struct TriangleLanes : CornerLanes<3> {
  alignas(64) std::array<PrimitiveRow, 3> normal;
  alignas(64) PrimitiveRow lowest;   ///< of the corners along the normal, relative to the first one
  alignas(64) PrimitiveRow highest;  ///< the same
  alignas(64) PrimitiveRow inverse;  ///< 1 / the squared length of the normal; 0 if that is not precise
};

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

/// Triangles near each of 16 segments.
using NearSegments = std::array<NearTriangles, Cluster::most_primitives>;

/// Places the corners of segments, and finds the lanes whose boxes meet a box.
std::uint32_t place_meeting(const LocalPoints& points, const CornerPlaces<2>& places, const FloatBox& box,
                            SegmentLanes& segments);
/// place_meeting() for the triangles of a cluster (its first three corners). Sets `around` to the box of the
/// triangles that meet the box. Other triangles need not have a normal.
std::uint32_t place_meeting(const LocalPoints& points, const Cluster& cluster, const FloatBox& box,
                            TriangleLanes& triangles, FloatBox& around);

/// Tests segments against triangles, by lower bounds of their distance: the gap of their boxes, and along
/// four directions (the triangle's normal, and the cross products of the segment and each side). \param which
/// bits of the segments to test \param wanted    the triangles to test with each of them, among those that
/// met the box of place_meeting() \param margin    beyond this distance a triangle is not near \param
/// rounding  bound of the errors of a distance by rounding, those of the coordinates included \param found
/// those of the segments that are returned Returns the bits of the segments that have near triangles.
std::uint32_t find_near_triangles(const TriangleLanes& triangles, const SegmentLanes& segments,
                                  std::uint32_t which,
                                  const std::array<std::uint16_t, Cluster::most_primitives>& wanted,
                                  float margin, float rounding, NearSegments& found);

}  // namespace palpate::simd
