#pragma once

#include <array>
#include <cstddef>

#include "simd/vector_rows.hpp"

namespace palpate::simd {

/// Segments and triangles, one of each a lane.
struct SegmentsAndTriangles {
  static constexpr std::size_t most = VectorRows::most;
  std::array<VectorRows, 2> end;
  std::array<VectorRows, 3> corner;
  LaneRow apart;  ///< what find_separations() finds
};

/// How far the segments and triangles of the first `size` lanes are apart, never more than they are: the most
/// that they are apart along one of four directions (the triangle's normal, and those across the segment and
/// a side). Not above zero where they meet, and sometimes where they do not. The same bits on every target.
/// Lanes beyond may change.
void find_separations(SegmentsAndTriangles& pairs, std::size_t size);

}  // namespace palpate::simd
