#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace palpate {

/// A few tets that lie together, as the query reads them: corners are bytes that count in the cluster's own
/// list of points (docs/query.md).
struct TetCluster {
  static constexpr std::size_t most_tets = 16;
  static constexpr std::size_t most_points = 32;

  /// (4 x 16): corner c of tet t, as a place in the list of points; beyond the tets, those of the first one.
  std::array<std::array<std::uint8_t, most_tets>, 4> corners;
  std::int32_t first_tet;    ///< into TetClusters::tets
  std::int32_t first_point;  ///< into TetClusters::points
  std::int32_t body;
  std::uint8_t tets;    ///< 1 to 16
  std::uint8_t points;  ///< 4 to 32
};

}  // namespace palpate
