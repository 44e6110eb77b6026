#pragma once

#include <array>
#include <cstdint>

namespace palpate {

/// Index of a point, edge, triangle, tet or body: 0-based, 32 bits; -1 says "none".
using Index = std::int32_t;

/// A position, displacement, velocity or force; an array of n of them has the layout of an (n x 3) float64
/// array.
struct Vec3 {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  friend bool operator==(const Vec3&, const Vec3&) = default;
};

using Edge = std::array<Index, 2>;
using Triangle = std::array<Index, 3>;
using Tet = std::array<Index, 4>;

/// Half-open range [begin, end) of indices.
struct Range {
  Index begin = 0;
  Index end = 0;
  [[nodiscard]] Index size() const { return end - begin; }
  [[nodiscard]] bool contains(Index i) const { return begin <= i && i < end; }
};

}  // namespace palpate
