#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <palpate/types.hpp>

namespace palpate::simd {

/// What indices of edges and triangles refer to.
struct EdgesAndTriangles {
  const Vec3* positions;
  const Edge* edges;
  const Triangle* triangles;
};

/// Some pairs of an edge and a triangle.
struct EdgeTrianglePairs {
  static constexpr std::size_t most = 64;
  // Whole vectors are read, so each pair must have valid indices, used or not.
  alignas(64) std::array<Index, most> edge{};
  alignas(64) std::array<Index, most> triangle{};
  /// Output of find_gaps(): a lower bound of the distance; or what it says of two that may meet.
  alignas(64) std::array<float, most> gap;

  static constexpr float may_meet = 0.0F;  ///< or not
  static constexpr float meet = -1.0F;     ///< surely
};

/// Finds gaps of the first `size` pairs, in units: the largest of the gap of their boxes and the gaps along
/// four directions (the triangle's normal, and the cross products of the edge and each side), less all errors
/// of rounding. Lanes beyond may change.
/// \param scale  1 / unit
void find_gaps(const EdgesAndTriangles& surfaces, double scale, std::size_t size, EdgeTrianglePairs& pairs);

}  // namespace palpate::simd
