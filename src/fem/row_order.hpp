#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fem/elements.hpp"

namespace palpate::fem {

/// The free points, body by body along a Z-curve (Morton 1966) through the box of the rest positions, so that
/// neighbours in space mostly are so in memory. Ties go by the point's index. O(n_points log n_points).
/// \param free  (n_points) 1: is listed
std::vector<Index> points_along_curve(const Elements& elements, std::span<const std::uint8_t> free);

}  // namespace palpate::fem
