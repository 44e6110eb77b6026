#include "sim/tractions.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "contact/nearest_surface.hpp"
#include "fem/matrix.hpp"
#include "geometry/triangle.hpp"
#include "mesh/faces.hpp"

namespace palpate {
namespace {

/// Forces on the corners of a triangle whose sum is `force`, and whose torque equals the torque of `force`
/// acting at `place`.
std::array<Vec3, 3> on_corners(const std::array<Vec3, 3>& t, const Vec3& q, const Vec3& place,
                               const Vec3& force) {
  const std::array<double, 3> b = weights_in(t, area_vector(t), q);
  const Vec3 center = (1.0 / 3.0) * (t[0] + t[1] + t[2]);
  const Vec3 there = b[0] * t[0] + b[1] * t[1] + b[2] * t[2];
  fem::Matrix3 inertia;
  for (const Vec3& corner : t) {
    const Vec3 d = corner - center;
    for (int k = 0; k < 3; ++k) inertia(k, k) += squared_length(d);
    fem::add_outer(inertia, -1.0, d, d);
  }
  const Vec3 couple = fem::inverse(inertia) * cross(place - there, force);
  std::array<Vec3, 3> forces;
  for (std::size_t i = 0; i < 3; ++i) {
    forces[i] = b[i] * force;
    if (is_finite(couple)) forces[i] += cross(couple, t[i] - center);
  }
  return forces;
}

/// Distributes forces to the points of the surfaces.
class SurfaceForces {
 public:
  SurfaceForces(const Bodies& bodies, std::span<const Vec3> positions)
      : bodies_(bodies), positions_(positions), on_surface_(positions.size(), 0), sums_(positions.size()) {
    for (const Triangle& t : bodies.triangles()) {
      for (const Index corner : t) at(on_surface_, corner) = 1;
    }
  }

  void add(const ActedContact& contact, Index tet) {
    const Index point = contact.points[0];
    const Vec3& place = at(positions_, point);
    if (at(on_surface_, point) != 0) {
      at(sums_, point) += contact.force;
    } else {
      add_below(bodies_.point_tets()[point].front(), -1, place, contact.force, -contact.direction);
    }
    const bool self = contact.body_inside(bodies_) == contact.penetrated_body(bodies_);
    add_below(tet, self ? point : -1, place, -contact.force, contact.direction);
  }
  /// Adds the contact of an edge, whose points are on the surface.
  void add_edge(const ActedContact& contact) {
    for (std::size_t k = 0; k < 2; ++k)
      at(sums_, contact.points[k]) += contact.coefficients[k] * contact.force;
    const Triangle corners = penetrated_triangle(contact);
    const std::array<Vec3, 3> triangle = corners_of(positions_, corners);
    Vec3 there;
    for (std::size_t k = contact.own_points(); k < contact.all_points(); ++k)
      there -= contact.coefficients[k] * at(positions_, contact.points[k]);
    const std::array<Vec3, 3> forces =
        on_corners(triangle, there, place_of(contact, positions_), -contact.force);
    for (std::size_t k = 0; k < 3; ++k) at(sums_, corners[k]) += forces[k];
  }
  [[nodiscard]] std::vector<Vec3>& sums() { return sums_; }

 private:
  struct Face {
    std::array<Index, 3> corners{-1, -1, -1};
    Vec3 nearest{};
    double distance = std::numeric_limits<double>::infinity();
  };

  /// The triangle that an edge passes through; where it meets another edge, a triangle at that edge.
  [[nodiscard]] Triangle penetrated_triangle(const ActedContact& contact) const {
    const auto& [p, q, a, b, c] = contact.points;
    if (c >= 0) return {a, b, c};
    for (const Index edge : bodies_.point_edges()[a]) {
      const Edge& ends = at(bodies_.edges(), edge);
      if (ends[0] != b && ends[1] != b) continue;
      for (const Index triangle : at(bodies_.edge_triangles(), edge))
        if (triangle >= 0) return at(bodies_.triangles(), triangle);
    }
    return {a, b, a};
  }

  /// The nearest face whose normal is along `direction`; if there is none, the nearest face. The second
  /// search begins at the tet of the nearest face, since the position may have left its tet.
  [[nodiscard]] Face face_at(Index tet, Index without, const Vec3& place, const Vec3& direction) {
    constexpr double far = std::numeric_limits<double>::infinity();
    constexpr double about_as_near = 1.5;
    constexpr double along = 0.5;
    constexpr double rounding = 1e-9;  // the position is on the face itself
    const SurfacePoint nearest = search_.nearest(bodies_, positions_, tet, place, without, far, 0.0);
    Face any;
    Face facing;
    if (nearest.tet < 0) return any;
    const Tet& there = at(bodies_.tets(), nearest.tet);
    const double size = length(at(positions_, there[1]) - at(positions_, there[0]));
    const double radius = about_as_near * nearest.distance + rounding * size;
    search_.for_each_face(bodies_, positions_, nearest.tet, place, without, radius,
                          [&](Index at_tet, std::size_t opposite, const Vec3& q, double distance) {
                            const Tet& corners = at(bodies_.tets(), at_tet);
                            const auto& [i, j, k] = outward_face[opposite];
                            const Face face{{corners[i], corners[j], corners[k]}, q, distance};
                            if (distance < any.distance) any = face;
                            if (distance < facing.distance && dot(normal_of(face), direction) > along)
                              facing = face;
                          });
    return facing.corners[0] >= 0 ? facing : any;
  }
  [[nodiscard]] std::array<Vec3, 3> places(const Face& face) const {
    return corners_of(positions_, face.corners);
  }
  [[nodiscard]] Vec3 normal_of(const Face& face) const {
    return normalized(area_vector(positions_, face.corners));
  }
  void add_below(Index tet, Index without, const Vec3& place, const Vec3& force, const Vec3& direction) {
    Face face = face_at(tet, without, place, direction);
    if (face.corners[0] < 0) face = face_at(tet, -1, place, direction);  // all faces contain the point
    if (face.corners[0] < 0) {                                           // some positions are not finite
      at(sums_, at(bodies_.tets(), tet)[0]) += force;
      return;
    }
    const std::array<Vec3, 3> forces = on_corners(places(face), face.nearest, place, force);
    for (std::size_t i = 0; i < 3; ++i) at(sums_, face.corners[i]) += forces[i];
  }

  const Bodies& bodies_;
  std::span<const Vec3> positions_;
  std::vector<std::uint8_t> on_surface_;
  std::vector<Vec3> sums_;
  ExitSearch search_;
};

/// Sums over the triangles around a point.
struct Around {
  double area = 0.0;
  Vec3 normal{};  ///< outward, twice the area long
  int count = 0;
  /// Fraction of the point's force that a triangle of this area gets.
  [[nodiscard]] double part(double triangle) const {
    return area > 0.0 ? triangle / area : 1.0 / static_cast<double>(count);
  }
};

}  // namespace

SurfaceTractions tractions_of(std::span<const ActedContact> contacts, const Bodies& bodies,
                              std::span<const Vec3> positions) {
  SurfaceForces surface(bodies, positions);
  for (const ActedContact& contact : contacts) {
    if (contact.force == Vec3{}) continue;
    if (contact.of_edge) {
      surface.add_edge(contact);
    } else {
      surface.add(contact, tet_of(contact, bodies));
    }
  }
  const std::span<const Triangle> triangles = bodies.triangles();
  SurfaceTractions result;
  result.point_forces = std::move(surface.sums());
  result.corner_forces.resize(triangles.size());
  for (auto* numbers : {&result.area, &result.pressure}) numbers->resize(triangles.size());
  result.traction.resize(triangles.size());
  result.point_traction.resize(positions.size());
  result.point_pressure.resize(positions.size());
  std::vector<Around> around(positions.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    result.area[i] = 0.5 * length(area_vector(positions, triangles[i]));
    for (const Index corner : triangles[i]) {
      at(around, corner).area += result.area[i];
      at(around, corner).normal += area_vector(positions, triangles[i]);
      ++at(around, corner).count;
    }
  }
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const Triangle& t = triangles[i];
    const double area = result.area[i];
    Vec3 force;
    for (std::size_t k = 0; k < 3; ++k) {
      result.corner_forces[i][k] = at(around, t[k]).part(area) * at(result.point_forces, t[k]);
      force += result.corner_forces[i][k];
    }
    if (!(area > 0.0)) continue;
    result.traction[i] = (1.0 / area) * force;
    result.pressure[i] = -dot(result.traction[i], normalized(area_vector(positions, t)));
  }
  for (std::size_t p = 0; p < positions.size(); ++p) {
    if (!(around[p].area > 0.0)) continue;
    result.point_traction[p] = (3.0 / around[p].area) * result.point_forces[p];
    result.point_pressure[p] = -dot(result.point_traction[p], normalized(around[p].normal));
  }
  return result;
}

}  // namespace palpate
