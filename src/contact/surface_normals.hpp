#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"
#include "parallel/parallel.hpp"
#include "simd/triangle_normals.hpp"

namespace palpate {

/// A point of a surface triangle.
struct TrianglePoint {
  Index triangle;
  Vec3 x;
};

/// A normal field on the surfaces of bodies that is continuous along the surface, and equal to the triangle's
/// normal where the surface is flat.
///
/// The corners of a triangle have the area-weighted normal of the triangles around the point that are joined
/// by smooth edges (normals of both triangles at most 60 degrees apart at rest); between corners it is
/// interpolated. At a crease the normal rotates within a band of 5 % of the triangle's height on both sides,
/// so it is continuous there too. Contact with a flat face is exact outside of that band along its rim.
class SurfaceNormals {
 public:
  /// O(n log n) in triangles. `bodies` must not change afterwards.
  explicit SurfaceNormals(const Bodies& bodies);

  /// Corner normals of the bodies marked in `wanted` (n_bodies) at `positions`. O(triangles), parallel.
  void update(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
              std::span<const std::uint8_t> wanted);

  /// Unit normal at x, a point of a triangle; zero where the triangle and all around it have no area.
  [[nodiscard]] Vec3 at_point(const Bodies& bodies, std::span<const Vec3> positions, Index triangle,
                              const Vec3& x) const;
  /// at_point() for many points, with the same bits.
  void at_points(const Bodies& bodies, std::span<const Vec3> positions, std::span<const TrianglePoint> points,
                 std::span<Vec3> normals) const;

  /// at_point() at given positions, without update() and with the same bits. O(triangles at the corners).
  [[nodiscard]] Vec3 at_point_now(const Bodies& bodies, std::span<const Vec3> positions, Index triangle,
                                  const Vec3& x) const;

  /// Copies the corners of a triangle and their normals into a SIMD lane.
  void put_corners(const Bodies& bodies, std::span<const Vec3> positions, Index triangle,
                   simd::TrianglePoints& points, std::size_t lane) const {
    for (std::size_t i = 0; i < 3; ++i) {
      points.corner[i].put(at(positions, at(bodies.triangles(), triangle)[i]), lane);
      points.corner_normal[i].put(at(group_normals_, at(corner_groups_, triangle)[i]), lane);
    }
  }
  /// Whether the interpolated normal of a lane can be used; near creases it cannot.
  [[nodiscard]] bool is_interpolated(Index triangle, const simd::TrianglePoints& points,
                                     std::size_t lane) const;

 private:
  void find_creases(const Bodies& bodies);
  void group_corners(const Bodies& bodies);
  template <class AreaOfGroup, class NormalOfGroup>
  [[nodiscard]] Vec3 interpolated(const Bodies& bodies, std::span<const Vec3> positions, Index triangle,
                                  const Vec3& x, const AreaOfGroup& area_of,
                                  const NormalOfGroup& normal_of) const;
  [[nodiscard]] double from_crease(Index triangle, const std::array<double, 3>& weights) const;

  /// Bits 0-2: the edge opposite corner i is a crease; bits 3-5: corner i is an end of a crease.
  std::vector<std::uint8_t> creases_;  ///< (n_triangles)
  std::vector<std::array<Index, 3>>
      across_;  ///< (n_triangles) the triangle across the smooth edge opposite corner i
  std::vector<std::array<Index, 3>> corner_groups_;  ///< (n_triangles) group of each corner
  Rows groups_of_point_;                             ///< (n_points) groups, which are numbered by point
  Rows triangles_of_group_;
  std::vector<Index> body_of_group_;
  std::vector<Vec3> areas_;          ///< (n_triangles) area vectors, twice the area long
  std::vector<Vec3> group_areas_;    ///< (n_groups) sum of area vectors
  std::vector<Vec3> group_normals_;  ///< (n_groups) unit, or zero
};

}  // namespace palpate
