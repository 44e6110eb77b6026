#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <palpate/error.hpp>
#include <palpate/outcomes.hpp>

#include "contact/nearest_surface.hpp"
#include "fem/rotation.hpp"
#include "geometry/box_tree.hpp"
#include "geometry/triangle.hpp"
#include "geometry/trigonometry.hpp"
#include "number_text.hpp"
#include "sim/checked_body.hpp"
#include "sim/wrench.hpp"

// Positions, rotations, distances and areas.
namespace palpate {
namespace {

/// Barycentric weights of a position in a tet.
std::array<double, 4> weights_in_tet(const Vec3& p, const Tet& tet, std::span<const Vec3> positions) {
  const auto corner = [&](std::size_t i) { return at(positions, tet[i]); };
  const auto six_volumes = [](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return dot(cross(b - a, c - a), d - a);
  };
  const double whole = six_volumes(corner(0), corner(1), corner(2), corner(3));
  const double w1 = six_volumes(corner(0), p, corner(2), corner(3)) / whole;
  const double w2 = six_volumes(corner(0), corner(1), p, corner(3)) / whole;
  const double w3 = six_volumes(corner(0), corner(1), corner(2), p) / whole;
  return {1.0 - w1 - w2 - w3, w1, w2, w3};
}

double distance_to_surface(const Bodies& bodies, const Body& body, const Vec3& p) {
  double least = std::numeric_limits<double>::infinity();
  for (Index t = body.triangles.begin; t < body.triangles.end; ++t) {
    const Vec3 foot = nearest_on_triangle(p, corners_of(bodies.points_rest(), at(bodies.triangles(), t)));
    least = std::min(least, length(foot - p));
  }
  return least;
}

/// Distance of two segments (Ericson, "Real-time collision detection", 2005, 5.1.9).
double distance_of_segments(const Vec3& p, const Vec3& p_end, const Vec3& q, const Vec3& q_end) {
  const Vec3 u = p_end - p;
  const Vec3 v = q_end - q;
  const Vec3 r = p - q;
  const double a = squared_length(u);
  const double e = squared_length(v);
  const double b = dot(u, v);
  const double c = dot(u, r);
  const double f = dot(v, r);
  const double apart = a * e - b * b;
  double s = apart > 0.0 ? std::clamp((b * f - c * e) / apart, 0.0, 1.0) : 0.0;
  double t = e > 0.0 ? (b * s + f) / e : 0.0;
  if (t < 0.0 || t > 1.0) {
    t = std::clamp(t, 0.0, 1.0);
    s = a > 0.0 ? std::clamp((b * t - c) / a, 0.0, 1.0) : 0.0;
  }
  return length(r + s * u - t * v);
}

double distance_of_triangles(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    least = std::min(least, length(nearest_on_triangle(a[i], b) - a[i]));
    least = std::min(least, length(nearest_on_triangle(b[i], a) - b[i]));
    for (std::size_t j = 0; j < 3; ++j)
      least = std::min(least, distance_of_segments(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]));
  }
  return least;
}

std::vector<std::array<Vec3, 3>> triangles_of(const Bodies& bodies, Index body,
                                              std::span<const Vec3> positions) {
  const Range range = checked_body(bodies, body).triangles;
  std::vector<std::array<Vec3, 3>> triangles;
  for (Index t = range.begin; t < range.end; ++t)
    triangles.push_back(corners_of(positions, at(bodies.triangles(), t)));
  return triangles;
}

Box box_of_triangle(const std::array<Vec3, 3>& triangle) {
  Box box;
  for (const Vec3& corner : triangle) box.extend(corner);
  return box;
}

/// Forces on the surface points of a body by contacts with another body, N.
struct Pushes {
  std::vector<Vec3> on_point;  ///< by index in the body
  std::size_t count = 0;
};

Pushes pushes_on(const ContactForces& contacts, const Bodies& bodies, Index body, Index by) {
  const Range points = at(bodies.bodies(), body).points;
  Pushes pushes{std::vector<Vec3>(static_cast<std::size_t>(points.size())), 0};
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Index p = contacts.point[c];
    const bool counts = contacts.edge[c] < 0 && contacts.body[c] == by && contacts.normal[c] > 0.0;
    if (!counts || at(bodies.body_of_point(), p) != body) continue;
    Vec3& push = at(pushes.on_point, p - points.begin);
    if (push == Vec3{}) ++pushes.count;
    push += contacts.normal[c] * contacts.direction[c];
  }
  return pushes;
}

/// Loaded area: a third of each triangle at a loaded point whose normal is within 60 degrees of the force.
double pushed_area(const Pushes& pushes, const Bodies& bodies, Index body, std::span<const Vec3> positions) {
  constexpr double facing = 0.5;
  const Body& of = at(bodies.bodies(), body);
  double sum = 0.0;
  for (Index t = of.triangles.begin; t < of.triangles.end; ++t) {
    const Triangle& corners = at(bodies.triangles(), t);
    const Vec3 area = area_vector(positions, corners);
    for (const Index p : corners) {
      const Vec3& push = at(pushes.on_point, p - of.points.begin);
      if (-dot(push, area) > facing * length(push) * length(area)) sum += length(area) / 6.0;
    }
  }
  return sum;
}

}  // namespace

Landmark landmark(const Bodies& bodies, Index body, const Vec3& place) {
  const Body& of = checked_body(bodies, body);
  constexpr double rounding = 1e-9;
  for (Index t = of.tets.begin; t < of.tets.end; ++t) {
    const auto weights = weights_in_tet(place, at(bodies.tets(), t), bodies.points_rest());
    if (std::ranges::min(weights) >= -rounding) return {t, weights};
  }
  throw Error(
      "landmark", "",
      "a position " + number_text(distance_to_surface(bodies, of, place)) + " outside of '" + of.name + "'",
      "a position in the body at rest");
}

Vec3 place_of(const Bodies& bodies, const Landmark& landmark, std::span<const Vec3> positions) {
  const Tet& tet = at(bodies.tets(), landmark.tet);
  Vec3 place;
  for (std::size_t i = 0; i < 4; ++i) place += landmark.weights[i] * at(positions, tet[i]);
  return place;
}

Vec3 rotation_of(const Bodies& bodies, Index body, std::span<const Vec3> positions,
                 std::span<const double> masses) {
  const Body& of = checked_body(bodies, body);
  const auto rest = bodies.points_rest();
  const Vec3 center = center_of_mass(of, masses, positions);
  const Vec3 center_rest = center_of_mass(of, masses, rest);
  fem::Matrix3 f;
  for (Index p = of.points.begin; p < of.points.end; ++p) {
    const Vec3 x = at(masses, p) * (at(positions, p) - center);
    const Vec3 r = at(rest, p) - center_rest;
    const std::array<double, 3> a{x.x, x.y, x.z};
    const std::array<double, 3> b{r.x, r.y, r.z};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) f.values[3 * i + j] += a[i] * b[j];
  }
  const fem::Matrix3 r = fem::nearest_rotation(f);
  const auto& m = r.values;
  // Axis times twice the sine of the angle; near 180 degrees it is too small to give the axis.
  const Vec3 twice{m[7] - m[5], m[2] - m[6], m[3] - m[1]};
  const double angle = arc_tangent(length(twice), m[0] + m[4] + m[8] - 1.0);
  if (length(twice) > 1e-6) return (angle / length(twice)) * twice;
  if (angle < 1.0) return 0.5 * twice;
  const std::array<Vec3, 3> columns{
      {{m[0] + 1.0, m[3], m[6]}, {m[1], m[4] + 1.0, m[7]}, {m[2], m[5], m[8] + 1.0}}};  // 2 a a^T
  const Vec3& axis = *std::ranges::max_element(columns, {}, [](const Vec3& c) { return squared_length(c); });
  return angle * normalized(axis);
}

double distance_of(const Bodies& bodies, Index a, Index b, std::span<const Vec3> positions) {
  const auto of_a = triangles_of(bodies, a, positions);
  const auto of_b = triangles_of(bodies, b, positions);
  std::vector<Box> boxes;
  Box all_b;
  for (const auto& triangle : of_b) {
    boxes.push_back(box_of_triangle(triangle));
    all_b.extend(boxes.back());
  }
  const BoxTree tree(std::move(boxes));
  // Start with the nearest, so that most others need no search.
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t t = 0; t < of_a.size(); ++t)
    order.emplace_back(squared_distance(box_of_triangle(of_a[t]), all_b), t);
  std::ranges::sort(order);
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [nearest, t] : order) {
    if (nearest > least * least) break;
    tree.for_each_within(
        box_of_triangle(of_a[t]), [&] { return least; },
        [&](std::size_t other) { least = std::min(least, distance_of_triangles(of_a[t], of_b[other])); });
  }
  return least;
}

double contact_area(const Simulation& simulation, Index a, Index b) {
  const Bodies& bodies = simulation.bodies();
  checked_body(bodies, a);
  checked_body(bodies, b);
  const ContactForces contacts = simulation.acting_contacts();
  const Pushes on_a = pushes_on(contacts, bodies, a, b);
  const Pushes on_b = pushes_on(contacts, bodies, b, a);
  const double area_a = pushed_area(on_a, bodies, a, simulation.positions());
  const double area_b = pushed_area(on_b, bodies, b, simulation.positions());
  if (on_a.count == on_b.count) return std::min(area_a, area_b);
  return on_a.count > on_b.count ? area_a : area_b;
}

}  // namespace palpate
