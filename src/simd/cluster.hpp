#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace palpate {

/// A few tets, or surface triangles, that lie together, as the queries read them: corners are bytes that
/// count in the cluster's own list of points (docs/query.md).
struct Cluster {
  static constexpr std::size_t most_primitives = 16;
  static constexpr std::size_t most_points = 32;

  /// (4 x 16): corner c of primitive i, as a place in the list of points; a triangle's last corner comes
  /// twice. Beyond the size, corners of the first primitive.
  std::array<std::array<std::uint8_t, most_primitives>, 4> corners;
  std::int32_t first;        ///< into Clusters::primitives
  std::int32_t first_point;  ///< into Clusters::points
  std::int32_t body;
  std::uint8_t size;    ///< primitives, 1 to 16
  std::uint8_t points;  ///< 3 to 32
};

}  // namespace palpate
