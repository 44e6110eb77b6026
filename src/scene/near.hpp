#pragma once

#include <span>

#include <palpate/mesh.hpp>
#include <palpate/types.hpp>

namespace palpate {

/// Whether the surface of a body at rest is within `distance` of a point. O(triangles of the body).
bool is_near(const Bodies& bodies, Index body, const Vec3& point, double distance);

/// The tet of a body at these positions (n_points x 3) that contains a point (if several do, the lowest
/// index). If there is none, the tet behind the nearest surface triangle (if several are nearest, the first).
Index nearest_tet(const Bodies& bodies, std::span<const Vec3> positions, Index body, const Vec3& point);

}  // namespace palpate
