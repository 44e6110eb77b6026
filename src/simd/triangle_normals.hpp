#pragma once

#include <array>
#include <cstddef>

#include "simd/vector_rows.hpp"

namespace palpate::simd {

/// Points of triangles whose corners have normals, in rows: one point a lane.
struct TrianglePoints {
  static constexpr std::size_t most = VectorRows::most;
  VectorRows point;
  std::array<VectorRows, 3> corner;
  std::array<VectorRows, 3> corner_normal;
  // What interpolate_normals() finds:
  VectorRows normal;              ///< unit, or zero where the mean is zero or not finite
  std::array<LaneRow, 3> weight;  ///< of the corners: none negative, sum 1
};

/// Means of the normals of the corners at the first `size` points, by their weights there: what
/// SurfaceNormals::at_point() computes without creases, to the bit. Lanes beyond may change.
void interpolate_normals(TrianglePoints& points, std::size_t size);

/// Edges that cross triangles whose corners have normals, one a lane, and the planes of the surface there as
/// they see it.
struct CrossingEdges {
  static constexpr std::size_t most = TrianglePoints::most;
  VectorRows from;
  VectorRows to;
  LaneRow parameter;        ///< of the crossing, from 0 at `from` to 1 at `to`
  TrianglePoints crossing;  ///< its point need not be given
  // What find_planes() finds, from the normals of the crossing that interpolate_normals() finds:
  LaneRow nearest;      ///< the parameter, at most 1
  LaneRow distance;     ///< of the crossing from `from`
  LaneRow weight;       ///< 1 / parameter^2 - lost
  LaneRow depth;        ///< weight times the distance of `from` to the plane
  VectorRows weighted;  ///< weight times the normal
};

/// Of the first `size` lanes; what EdgeExit computes for one crossing that is not at the point, to the bit.
/// Lanes beyond may change.
void find_planes(CrossingEdges& edges, double lost, std::size_t size);

}  // namespace palpate::simd
