#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

namespace palpate {

/// A point of a body's surface, seen from a point inside the body.
struct SurfacePoint {
  Vec3 position;
  Vec3 outward;  ///< unit vector from the given point to it; the triangle's normal where both are the same
  double distance = 0.0;
};

/// Finds nearest surface points by walking from tet to tet, from the one that holds the point, through the
/// faces nearer than the best found. Keeps its memory between searches; one for each thread.
///
/// Where the tets of a body do not overlap that is the nearest point of its whole surface: the straight way
/// there stays in the body. Where they do (tissue folded onto itself) it is the nearest way out of the layer
/// that holds the point, and not the surface of another layer that happens to pass nearby.
class ExitSearch {
 public:
  /// What a search may take and where it may end.
  struct Limits {
    double radius;       ///< looks no further; where nothing is nearer, `distance` of the result is this
    double enough;       ///< ends at the first surface point as near as this
    Index without = -1;  ///< a point whose tets and triangles are left out: the searching point of self-contact
  };
  /// Of several nearest points, the one met first. O(tets nearer than the surface).
  SurfacePoint nearest(const Bodies& bodies, std::span<const Vec3> positions, Index tet, const Vec3& p,
                       const Limits& limits);

 private:
  bool insert(Index tet);
  void grow();

  std::vector<Index> reached_;
  std::vector<Index> table_;  ///< open addressing, -1: free; the size is a power of two
};

/// Nearest surface point of a whole body, not counting triangles at the point `without`; distance infinite
/// where there is none. O(triangles of the body).
SurfacePoint nearest_surface_point(const Bodies& bodies, std::span<const Vec3> positions, Index body,
                                   const Vec3& p, Index without = -1);

/// The nearest side exit of p, a point in `tet`: the nearest point within `radius` on a surface triangle
/// whose normal is neither along `direction` (cosine over 0.5) nor against it (under -0.3). None: `distance`
/// is `radius`.
///
/// Walks from tet to tet through the faces that are nearer than `radius`, so a small radius costs a few tets;
/// ends after 64 tets with what it has found.
SurfacePoint nearest_side_exit(const Bodies& bodies, std::span<const Vec3> positions, Index tet,
                               const Vec3& p, const Vec3& direction, double radius);

}  // namespace palpate
