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

/// The same force, with its torque about another point. O(1).
[[nodiscard]] Wrench moved_to(const Wrench& wrench, const Vec3& about);

/// What a contact did in a step.
enum class ContactStatus : std::uint8_t {
  open,   ///< separated: no normal force
  stick,  ///< pushed, and friction held it
  slide   ///< pushed, and friction was at its bound (with friction 0 always)
};
/// Names of ContactStatus; index = enum value.
inline constexpr std::array<std::string_view, 3> contact_status_names{"open", "stick", "slide"};

/// The contacts that a step was solved with, and the force that each had. They are those at the start of the
/// step, sorted by (point, body), then those of edges (docs/edges.md), then the speculative ones, which have
/// a gap there: contacts that the step before has released but that are still near, and those that were found
/// at the predicted positions, by round and then by (point, body). The contacts of a detector are those at
/// the END of the step: a contact that is new there has no force yet.
///
/// The force acts on the point, or on the edge where it meets the surface; its reaction, on the penetrated
/// body, acts at the same place. So a sum over both bodies is zero to rounding, torques too. Structure of
/// arrays.
struct ContactForces {
  std::vector<Index> point;  ///< (n) the point that is inside; of an edge the end that is nearer
  std::vector<Index> edge;   ///< (n) of Bodies::edges(): the edge that passes through the body; -1: a point
  std::vector<Index> body;   ///< (n) the penetrated body
  std::vector<Index> tet;    ///< (n) the penetrated tet
  std::vector<std::array<double, 4>> weights;  ///< (n x 4) of the place in the tet, corner order
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

/// What two bodies did to each other through their contacts.
struct PairWrench {
  Index body_a = -1;    ///< the lower index; the same as body_b for a body that touches itself
  Index body_b = -1;    ///< the higher one
  Index contacts = 0;   ///< that are not open
  double normal = 0.0;  ///< sum of the normal forces, N: how hard they press, whatever the directions
  Wrench on_b{};        ///< of a on b, about the centre of mass of b; b does the reverse to a
};

/// The forces of contacts as loads on the surface triangles, at the positions that the step led to.
///
/// A force on a surface point goes to the triangles around it by their areas, as the load of the corner that
/// the point is. A force elsewhere (the reaction inside a penetrated tet, a point inside its body) goes to
/// the corners of the nearest surface triangle of the body first, such that force and torque stay. So the
/// corner loads have the wrench of the body to rounding. They are those of a traction that is linear in each
/// triangle; `traction` is its mean.
struct SurfaceTractions {
  std::vector<std::array<Vec3, 3>> corner_forces;  ///< (n_triangles x 3 x 3), N
  std::vector<double> area;                        ///< (n_triangles), m^2
  std::vector<Vec3> traction;                      ///< (n_triangles x 3) force over area, Pa; 0 without area
  std::vector<double> pressure;                    ///< (n_triangles) traction against the outward normal, Pa
  std::vector<Vec3> point_forces;  ///< (n_points x 3) sums of the corner forces at each point, N
  /// (n_points x 3) the force over a third of the area around, Pa: what a uniform traction gives.
  std::vector<Vec3> point_traction;
  std::vector<double> point_pressure;  ///< (n_points) the same against the mean outward normal, Pa
};

}  // namespace palpate
