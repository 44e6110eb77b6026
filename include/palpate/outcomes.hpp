#pragma once

#include <array>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>
#include <palpate/simulation.hpp>
#include <palpate/types.hpp>

namespace palpate {

/// The half-space on one side of a plane, to which the normal points.
struct HalfSpace {
  Vec3 point{};                ///< on the plane, m
  Vec3 normal{0.0, 0.0, 1.0};  ///< outward from the plane into it, of any length but zero
};

/// Volume of the part of a body that is in all of these half-spaces, m^3: each tet is cut by the planes, so
/// it is exact. An inverted tet counts as negative.
/// \param positions  (n_points x 3)
///
/// Throws Error on a body out of range and a normal that is zero or not finite. O(tets of the body x planes).
[[nodiscard]] double volume_in(const Bodies& bodies, Index body, std::span<const Vec3> positions,
                               std::span<const HalfSpace> spaces);
/// volume_in() for the part that is also in another body: tets are cut by the tets of the other body. If
/// tets of a body overlap, their common part counts for each. O(tets log tets + tets that meet).
[[nodiscard]] double volume_within(const Bodies& bodies, Index body, Index other,
                                   std::span<const Vec3> positions, std::span<const HalfSpace> spaces);

/// A cavity: a part of the surface of a body, its walls, and the openings that the part leaves.
struct Cavity {
  std::vector<Index> walls;                                 ///< surface triangles
  std::vector<std::vector<std::array<Index, 2>>> openings;  ///< border edges of each opening
  double sign = 1.0;  ///< -1: the outward normals of the walls point into the cavity
};
/// The cavity that these surface triangles enclose, for volume_of(). Border edges that are connected are one
/// opening. Throws Error if a triangle is out of range or there twice, or if the bodies at rest enclose no
/// volume there. O(n log n).
[[nodiscard]] Cavity cavity(const Bodies& bodies, std::span<const Index> walls);
/// The volume between the walls of a cavity and the lids of its openings, m^3; positive at rest. A lid has a
/// triangle from each border edge to the centroid of the border, so it is flat if the border is. O(walls).
/// \param positions  (n_points x 3)
[[nodiscard]] double volume_of(const Cavity& cavity, const Bodies& bodies, std::span<const Vec3> positions);

/// A material point of a body; it moves with a tet.
struct Landmark {
  Index tet = -1;                   ///< that contains it
  std::array<double, 4> weights{};  ///< in the order of the corners
};
/// The landmark at a position in a body at rest. Throws Error if no tet of the body contains it (closed tets,
/// to 1e-9 of their size), with the distance of the nearest one. O(tets of the body).
[[nodiscard]] Landmark landmark(const Bodies& bodies, Index body, const Vec3& place);
/// The current position of a landmark.
[[nodiscard]] Vec3 place_of(const Bodies& bodies, const Landmark& landmark, std::span<const Vec3> positions);

/// Rotation of a body from its shape at rest: axis times angle, rad, 0 to pi. It is the rotation R that
/// minimises the sum of m |x - c - R (X - C)|^2 over its points (Horn 1987), c and C the centres of mass.
/// \param masses  (n_points), kg. O(points of the body).
[[nodiscard]] Vec3 rotation_of(const Bodies& bodies, Index body, std::span<const Vec3> positions,
                               std::span<const double> masses);

/// The minimum distance of the surfaces of two bodies, m: between points, edges and triangles. It does not
/// detect penetration, so bodies must not overlap. O(triangles log triangles).
[[nodiscard]] double distance_of(const Bodies& bodies, Index a, Index b, std::span<const Vec3> positions);

/// Contact area of two bodies in the last step, m^2: for each point of one body with a force by the other, a
/// third of each surface triangle at the point that faces the force. It is computed on the body with more
/// such points, which has the finer mesh there; with equal numbers, the smaller area is used. O(contacts +
/// triangles).
[[nodiscard]] double contact_area(const Simulation& simulation, Index a, Index b);

}  // namespace palpate
