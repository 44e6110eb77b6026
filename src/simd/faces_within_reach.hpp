#pragma once

#include <array>
#include <cstddef>

#include "simd/vector_rows.hpp"

namespace palpate::simd {

/// Points in tets, one a lane, and the search distance of each.
struct ReachingPoints {
  static constexpr std::size_t most = VectorRows::most;
  VectorRows point;
  std::array<VectorRows, 4> corner;
  LaneRow reach;
  LaneRow meets;  ///< what find_faces_within_reach() finds: 1 or 0
};

/// Whether the plane of a face of the tet is nearer than the reach, or the face has no area, or a number is
/// none: where not, ExitSearch::walk() ends at the tet without having found anything. Computed as there, to
/// the bit. Of the first `size` lanes; those beyond may change.
void find_faces_within_reach(ReachingPoints& points, std::size_t size);

}  // namespace palpate::simd
