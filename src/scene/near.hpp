#pragma once

#include <span>

#include <palpate/mesh.hpp>
#include <palpate/types.hpp>

namespace palpate {

/// Whether the surface of a body at rest comes as near to a point as `distance`. O(triangles of the body).
bool is_near(const Bodies& bodies, Index body, const Vec3& point, double distance);

/// The tet of a body at these positions (n_points x 3) that holds a point, of several the lowest; else the
/// one behind the nearest triangle of its surface, of several the first. O(tets of the body).
Index nearest_tet(const Bodies& bodies, std::span<const Vec3> positions, Index body, const Vec3& point);

}  // namespace palpate
