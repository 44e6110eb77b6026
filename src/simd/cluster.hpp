#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace palpate {

/// A few neighbouring tets or surface triangles, in the form that queries read (docs/query.md). Corners are
/// stored as bytes: indices into the cluster's own list of points.
struct Cluster {
  static constexpr std::size_t most_primitives = 16;
  static constexpr std::size_t most_points = 32;

  /// (4 x 16): corner c of primitive i, as an index into the list of points. A triangle repeats its last
  /// corner. Lanes beyond the size repeat the first primitive.
  std::array<std::array<std::uint8_t, most_primitives>, 4> corners;
  std::int32_t first;        ///< into Clusters::primitives
  std::int32_t first_point;  ///< into Clusters::points
  std::int32_t body;
  std::uint8_t size;    ///< number of primitives, 1 to 16
  std::uint8_t points;  ///< number of points, 3 to 32
};

}  // namespace palpate
