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

}  // namespace palpate
