#pragma once

#include <array>
#include <cstddef>

#include "simd/vector_rows.hpp"

namespace palpate::simd {

/// Points on triangles whose corners have normals, one point per lane.
struct TrianglePoints {
  static constexpr std::size_t most = VectorRows::most;
  VectorRows point;
  std::array<VectorRows, 3> corner;
  std::array<VectorRows, 3> corner_normal;
  // Output of interpolate_normals():
  VectorRows normal;              ///< unit, or zero where the mean is zero or not finite
  std::array<LaneRow, 3> weight;  ///< of the three corners: not negative, sum 1
};

/// Weighted means of the corners' normals at the first `size` points: SurfaceNormals::at_point() without
/// creases, with the same bits. Lanes beyond may change.
void interpolate_normals(TrianglePoints& points, std::size_t size);

/// Edges that cross triangles whose corners have normals, one edge per lane, and the planes of the surface at
/// the crossings.
struct CrossingEdges {
  static constexpr std::size_t most = TrianglePoints::most;
  VectorRows from;
  VectorRows to;
  LaneRow parameter;        ///< of the crossing, from 0 at `from` to 1 at `to`
  TrianglePoints crossing;  ///< the triangle at the crossing; its point need not be set
  // Output of find_planes(), from the normals that interpolate_normals() gives at the crossing:
  LaneRow nearest;      ///< the parameter of the crossing, at most 1
  LaneRow distance;     ///< of the crossing from `from`
  LaneRow weight;       ///< 1 / parameter^2 - lost
  LaneRow depth;        ///< weight times the distance of `from` to the plane
  VectorRows weighted;  ///< weight times the normal
};

/// Computes the first `size` lanes as EdgeExit does for one crossing that is not at the point, with the same
/// bits. Lanes beyond may change.
void find_planes(CrossingEdges& edges, double lost, std::size_t size);

}  // namespace palpate::simd
