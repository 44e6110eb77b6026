#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "simd/vector_rows.hpp"

namespace palpate::simd {

/// Of orient3d() in double (Shewchuk's o3derrboundA, and what products that underflow add): the error is at
/// most `relative` times the permanent plus `tiny` times (4 + the sizes of the z differences).
struct OrientationBound {
  static constexpr double half_ulp = std::numeric_limits<double>::epsilon() / 2.0;
  static constexpr double relative = (7.0 + 56.0 * half_ulp) * half_ulp;
  static constexpr double tiny = std::numeric_limits<double>::min();
};
/// Relative error of the distances that a crossing's parameter is made of.
inline constexpr double parameter_accuracy = 1e-9;

/// Segments (a, b) that meet triangles, one a lane.
struct SegmentsInTriangles {
  static constexpr std::size_t most = VectorRows::most;
  VectorRows a;
  VectorRows b;
  std::array<VectorRows, 3> corner;
  LaneRow parameter;  ///< what find_parameters() finds; -1 where double precision is not certain
};

/// crossing_parameter() of the first `size` lanes, to the bit, but for those that need exact numbers. Lanes
/// beyond may change.
void find_parameters(SegmentsInTriangles& segments, std::size_t size);

}  // namespace palpate::simd
