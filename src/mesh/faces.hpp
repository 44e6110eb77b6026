#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include <palpate/types.hpp>

namespace palpate {

/// Corners of the face opposite corner i of a tet of positive volume, counter-clockwise seen from outside.
inline constexpr std::array<std::array<std::size_t, 3>, 4> outward_face{
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// Whether a point is one of the corners of a tet or triangle, or an end of an edge.
inline bool has_corner(const auto& corners, Index point) {
  return std::find(corners.begin(), corners.end(), point) != corners.end();
}

}  // namespace palpate
