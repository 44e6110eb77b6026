#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

namespace palpate::fem {

/// The free points, body by body along a Z-curve (Morton 1966) through the box of the rest positions, so that
/// most neighbours in space are close in memory. Ties are ordered by index. O(n_points log n_points).
/// \param points          (n_points x 3), at rest
/// \param body_of_point   (n_points)
/// \param free            (n_points) 1: is listed
std::vector<Index> points_along_curve(std::span<const Vec3> points, std::span<const Index> body_of_point,
                                      std::span<const std::uint8_t> free);

/// All tets, body by body in the order in which that curve meets the first of their corners. Ties are ordered
/// by index. O(n_tets log n_tets).
std::vector<Index> tets_along_curve(const Bodies& bodies);

}  // namespace palpate::fem
