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

}  // namespace palpate::simd
