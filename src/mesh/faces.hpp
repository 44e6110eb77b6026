#pragma once

#include <array>
#include <cstddef>

namespace palpate {

/// Corners of the face opposite corner i of a tet of positive volume, counter-clockwise seen from outside.
inline constexpr std::array<std::array<std::size_t, 3>, 4> outward_face{
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

}  // namespace palpate
