#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include <palpate/types.hpp>

namespace palpate {

/// A force, and its torque about a point.
struct Wrench {
  Vec3 force{};   ///< N
  Vec3 torque{};  ///< N m, about `about`
  Vec3 about{};   ///< m
};

/// The same force, with its torque about another point. Throws Error on a point that is not finite. O(1).
[[nodiscard]] Wrench moved_to(const Wrench& wrench, const Vec3& about);

/// What a contact did in a step.
enum class ContactStatus : std::uint8_t {
  open,   ///< separated: no normal force
  stick,  ///< pushed, and friction held it
  slide   ///< pushed, and friction was at its bound (with friction 0 always)
};
/// Names of ContactStatus; index = enum value.
inline constexpr std::array<std::string_view, 3> contact_status_names{"open", "stick", "slide"};

/// The contacts in the last solve of a step, with their forces. The order is: contacts at the start of the
/// step, sorted by (point, body); those of edges (docs/edges.md); speculative ones, which have a gap at the
/// start. Speculative are contacts that ended in the step before but are still near, and contacts found at
/// the predicted positions, by round and then by (point, body). The contacts of a detector are those at the
/// END of the step: a new contact there has no force yet.
///
/// The force acts on the point, or on the edge where it meets the surface; its reaction, on the penetrated
/// body, acts at the same position. So forces and torques on both bodies add up to zero, up to rounding.
/// Structure of arrays.
struct ContactForces {
  std::vector<Index> point;  ///< (n) the point that is inside; for an edge, the nearer end
  std::vector<Index> edge;   ///< (n) of Bodies::edges(): the edge that passes through the body; -1: a point
  std::vector<Index> body;   ///< (n) the penetrated body
  std::vector<Index> tet;    ///< (n) the penetrated tet
  std::vector<std::array<double, 4>> weights;  ///< (n x 4) barycentric weights in the tet, corner order
  std::vector<double> depth;  ///< (n) at the start of the step, m; negative: the gap of a speculative contact
  std::vector<Vec3> direction;            ///< (n x 3) unit vector out of the penetrated body
  std::vector<double> normal;             ///< (n) force on the point along the direction, N
  std::vector<Vec3> friction;             ///< (n x 3) force on the point across the direction, N
  std::vector<ContactStatus> status;      ///< (n)
  std::vector<std::uint8_t> speculative;  ///< (n) 1: not yet in contact at the start of the step
  [[nodiscard]] std::size_t size() const { return point.size(); }  ///< number of contacts n
  /// Force on the point, N.
  [[nodiscard]] Vec3 force(std::size_t contact) const {
    const double n = normal[contact];
    const Vec3& r = direction[contact];
    const Vec3& f = friction[contact];
    return {n * r.x + f.x, n * r.y + f.y, n * r.z + f.z};
  }
};

/// The wrench between two bodies by their contacts.
struct PairWrench {
  Index body_a = -1;    ///< the lower index; equal to body_b for self-contact
  Index body_b = -1;    ///< the higher one
  Index contacts = 0;   ///< number of contacts that are not open
  double normal = 0.0;  ///< sum of the normal forces regardless of direction, N
  /// Of a on b, about the centre of mass of b or the point that was given; on a it is the opposite.
  Wrench on_b{};
};

/// The forces of contacts as loads on the surface triangles, at the positions after the step.
///
/// A force on a surface point is distributed to the triangles around it by area, as a load on their corner at
/// the point. A force elsewhere (the reaction inside a penetrated tet, an inner point) is first distributed
/// to the corners of the nearest surface triangle, so that force and torque stay. So the corner loads have
/// the wrench of the body up to rounding. They belong to a traction that is linear in each triangle;
/// `traction` is its mean.
struct SurfaceTractions {
  std::vector<std::array<Vec3, 3>> corner_forces;  ///< (n_triangles x 3 x 3), N
  std::vector<double> area;                        ///< (n_triangles), m^2
  std::vector<Vec3> traction;                      ///< (n_triangles x 3) force over area, Pa; 0 without area
  std::vector<double> pressure;                    ///< (n_triangles) traction against the outward normal, Pa
  std::vector<Vec3> point_forces;  ///< (n_points x 3) sums of the corner forces at each point, N
  /// (n_points x 3) the force over a third of the area of the triangles around, Pa; equal to the traction if
  /// that is uniform.
  std::vector<Vec3> point_traction;
  std::vector<double> point_pressure;  ///< (n_points) the same against the mean outward normal, Pa
};

}  // namespace palpate
