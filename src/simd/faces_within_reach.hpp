#pragma once

#include <array>
#include <cstddef>

#include "simd/vector_rows.hpp"

namespace palpate::simd {

/// Points in tets, and the search distance of each; one point per lane.
struct ReachingPoints {
  static constexpr std::size_t most = VectorRows::most;
  VectorRows point;
  std::array<VectorRows, 4> corner;
  LaneRow reach;
  LaneRow meets;  ///< output of find_faces_within_reach(): 1 or 0
};

/// Sets `meets` where the plane of a face of the tet is nearer than the reach, a face has no area, or a value
/// is NaN. Elsewhere ExitSearch::walk() ends at this tet and finds nothing. The decision has the same bits as
/// there. Computes the first `size` lanes; those beyond may change.
void find_faces_within_reach(ReachingPoints& points, std::size_t size);

}  // namespace palpate::simd
