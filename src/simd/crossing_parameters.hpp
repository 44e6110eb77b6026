#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include <palpate/detection.hpp>
#include <palpate/types.hpp>

#include "simd/vector_rows.hpp"

namespace palpate::simd {

/// Error bound of orient3d() in double: at most `relative` (Shewchuk's o3derrboundA) times the permanent,
/// plus `tiny` times (4 + the absolute z differences) for products that underflow.
struct OrientationBound {
  static constexpr double half_ulp = std::numeric_limits<double>::epsilon() / 2.0;
  static constexpr double relative = (7.0 + 56.0 * half_ulp) * half_ulp;
  static constexpr double tiny = std::numeric_limits<double>::min();
};
/// Relative error allowed in the two distances that give a crossing's parameter.
inline constexpr double parameter_accuracy = 1e-9;

/// Segments that meet triangles, one per lane.
struct SegmentsInTriangles {
  static constexpr std::size_t most = LaneRow::most;
  using Points = std::array<std::int32_t, most>;
  std::array<Points, 2> end{};  ///< index of each point
  std::array<Points, 3> corner{};
  // Outputs of find_parameters():
  LaneRow parameter;  ///< -1 where double precision cannot decide
  /// Elsewhere the orientation of the triangle's corners with the first end, less that with the second:
  /// positive where the segment passes against the normal.
  LaneRow passage;
};

/// Computes crossing_parameter() of the first `size` lanes, with the same bits, except where it needs exact
/// arithmetic. Lanes beyond may change.
void find_parameters(const Vec3* positions, SegmentsInTriangles& segments, std::size_t size);

/// Border edges, and the triangles that they meet.
struct CrossedTriangles {
  std::span<const Vec3> positions;
  std::span<const Index> point_of_contact;
  std::span<const BorderEdge> edges;
  std::span<const Triangle> triangles;
};
/// The same for crossings. Returns whether double precision can decide all of them.
bool find_parameters(const CrossedTriangles& all, std::span<Crossing> crossings);

}  // namespace palpate::simd
