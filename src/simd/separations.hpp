#pragma once

#include <array>
#include <cstddef>

#include "simd/vector_rows.hpp"

namespace palpate::simd {

/// One segment and one triangle per lane.
struct SegmentsAndTriangles {
  static constexpr std::size_t most = VectorRows::most;
  std::array<VectorRows, 2> end;
  std::array<VectorRows, 3> corner;
  LaneRow apart;  ///< output of find_separations()
};

/// Lower bound of the distance of segment and triangle in the first `size` lanes: the largest gap along four
/// directions (the triangle's normal, and the cross products of the segment and a side). Not above zero where
/// they meet, and sometimes where they do not. The same bits on every target. Lanes beyond may change.
void find_separations(SegmentsAndTriangles& pairs, std::size_t size);

}  // namespace palpate::simd
