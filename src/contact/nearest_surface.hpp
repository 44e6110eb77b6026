#pragma once

#include <span>

#include <palpate/mesh.hpp>

namespace palpate {

/// The point of a body's surface that is nearest to a point inside the body.
struct SurfacePoint {
  Vec3 position;
  Vec3 outward;  ///< unit vector from the given point to it; the triangle's normal where both are the same
  double distance = 0.0;
};

/// Nearest surface point of `body` at `positions`; of several, that of the lowest triangle. O(triangles of
/// the body).
SurfacePoint nearest_surface_point(const Bodies& bodies, std::span<const Vec3> positions, Index body,
                                   const Vec3& p);

/// The nearest side exit of p, a point in `tet`: the nearest point within `radius` on a surface triangle
/// whose normal is neither along `direction` (cosine over 0.5) nor against it (under -0.3). None: `distance`
/// is `radius`.
///
/// Walks from tet to tet through the faces that are nearer than `radius`, so a small radius costs a few tets;
/// ends after 64 tets with what it has found.
SurfacePoint nearest_side_exit(const Bodies& bodies, std::span<const Vec3> positions, Index tet,
                               const Vec3& p, const Vec3& direction, double radius);

}  // namespace palpate
