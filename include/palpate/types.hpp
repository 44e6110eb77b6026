#pragma once

#include <array>
#include <cstdint>

namespace palpate {

/// Index of a point, edge, triangle, tet or body: 0-based, 32 bits; -1 means "none".
using Index = std::int32_t;

/// A position, displacement, velocity or force; an array of n of them has the layout of an (n x 3) float64
/// array.
struct Vec3 {
  double x = 0.0;  ///< component along x, in the unit of the quantity
  double y = 0.0;  ///< component along y
  double z = 0.0;  ///< component along z
  friend bool operator==(const Vec3&, const Vec3&) = default;
};

/// The two end points of an edge.
using Edge = std::array<Index, 2>;
/// The three corners of a triangle.
using Triangle = std::array<Index, 3>;
/// The four corners of a tet.
using Tet = std::array<Index, 4>;

/// Half-open range [begin, end) of indices.
struct Range {
  Index begin = 0;                                          ///< first index
  Index end = 0;                                            ///< one past the last index
  [[nodiscard]] Index size() const { return end - begin; }  ///< number of indices
  /// Whether an index is in the range.
  [[nodiscard]] bool contains(Index i) const { return begin <= i && i < end; }
};

}  // namespace palpate
