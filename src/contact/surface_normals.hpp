#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/mesh.hpp>

#include "contact/surface_joints.hpp"
#include "contact/wanted_items.hpp"
#include "geometry/vector.hpp"
#include "parallel/parallel.hpp"
#include "simd/triangle_normals.hpp"

namespace palpate {

/// A normal field on the surfaces of bodies that is continuous along the surface, and equal to the triangle's
/// normal where the surface is flat or hollow.
///
/// The corners of a triangle have the area-weighted normal of the triangles around the point that are joined
/// by smooth edges (normals of both triangles at most 60 degrees apart at rest); between corners it is
/// interpolated. At a crease the normal rotates within a band on both sides, so it is continuous there too.
/// The band is as wide as the distance from which the normal is asked for, and at most 5 % of the triangle's
/// height: a shallow contact beside a sharp edge is pushed straight out of the flat face, and however near to
/// the edge it is, direction times depth is continuous.
///
/// At a hollow point (the surface bends inwards on all sides, as in a cup) all bent edges are creases: the
/// distance of a point behind such a surface has a continuous gradient, which is the triangle's normal.
/// Interpolated normals differ from it, and lean with the diagonals of the mesh: their forces are not those
/// of an energy, and frictionless bodies drove themselves around in cups and tubes. Where a surface is not
/// hollow, the gradient jumps at each edge, and bodies would tremble without interpolation.
///
/// Normals are prepared only where they are needed.
class SurfaceNormals {
 public:
  using Weights = std::array<double, 3>;
  /// O(n log n) in triangles. `bodies` must not change afterwards.
  explicit SurfaceNormals(const Bodies& bodies);

  /// Prepares the triangles of crossings, and no others. O(triangles prepared before + crossings + fans /
  /// 8), parallel.
  void prepare(const parallel::Threads& threads, std::span<const Vec3> positions,
               std::span<const Crossing> crossings);
  /// Asks for one more triangle. Any threads may call this at the same time.
  void want(Index triangle);
  /// Prepares the triangles asked for. O(those + fans / 8), parallel.
  void prepare_wanted(const parallel::Threads& threads, std::span<const Vec3> positions);

  /// Unit normal at x, a point of a prepared triangle; zero where the triangle and all around it have no
  /// area.
  /// \param distance  from which it is asked for, m: limits the bands at creases
  [[nodiscard]] Vec3 at_point(std::span<const Vec3> positions, Index triangle, const Vec3& x,
                              double distance) const {
    return at_weights(positions, triangle, weights(positions, triangle, x), distance);
  }
  /// at_point() of the point with these weights_in() the triangle.
  [[nodiscard]] Vec3 at_weights(std::span<const Vec3> positions, Index triangle, const Weights& w,
                                double distance) const;
  /// at_point() for many points, with the same bits.
  /// \param scratch  (n_points)
  void at_points(std::span<const Vec3> positions, std::span<const simd::PointOfTriangle> points,
                 std::span<Vec3> normals, std::span<simd::Doubtful> scratch) const;
  /// at_point() of a triangle that need not be prepared, with the same bits. O(triangles at the corners).
  [[nodiscard]] Vec3 at_point_now(std::span<const Vec3> positions, Index triangle, const Vec3& x,
                                  double distance) const;
  /// A distance at which bands have their full width.
  static constexpr double far = std::numeric_limits<double>::infinity();

  /// For the interpolation in prepared triangles.
  [[nodiscard]] simd::SmoothTriangles smooth(std::span<const Vec3> positions) const {
    return {positions, triangles_, units_, band};
  }

 private:
  /// Largest fraction of the triangle's height over which the normal rotates at a crease.
  static constexpr double band = 0.05;

  struct Fan;
  void find_fans(const Bodies& bodies, const SurfaceJoints& joints);
  void number_fans(std::vector<Fan>& fans, std::span<const Index> corners);
  [[nodiscard]] Vec3 area_of_fan(std::span<const Vec3> positions, Index fan) const;
  template <class AreaOfFan, class UnitOfFan>
  [[nodiscard]] Vec3 interpolated(std::span<const Vec3> positions, Index triangle, const Weights& w,
                                  double distance, const AreaOfFan& area_of, const UnitOfFan& unit_of) const;
  [[nodiscard]] Weights weights(std::span<const Vec3> positions, Index triangle, const Vec3& x) const;
  [[nodiscard]] double from_crease(std::span<const Vec3> positions, Index triangle, const Weights& w,
                                   double distance, unsigned first_bit) const;

  std::vector<simd::SmoothTriangle> triangles_;  ///< (n_triangles)
  /// Fans: the triangles around a point that have one normal there. Those of a body are in the order of their
  /// length. A group of fans is connected over edges that are no sharp creases; at a point that is not
  /// hollow, each fan is a group.
  Rows fans_of_point_;                   ///< (n_points) in the order of their first triangles
  std::vector<Index> group_of_fan_;      ///< (n_fans)
  std::vector<Index> fan_begin_;         ///< (n_fans + 1) into fan_triangles_
  std::vector<Triangle> fan_triangles_;  ///< their corners
  WantedItems wanted_;                   ///< fans; those listed are prepared
  std::vector<Vec3> areas_;              ///< (n_fans) sums of area vectors
  std::vector<Vec3> units_;              ///< (n_fans) unit vectors of the sums
};

}  // namespace palpate
