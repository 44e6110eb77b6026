#include "view/pull_limits.hpp"

#include "geometry/vector.hpp"

namespace palpate::view {

PullLimits::PullLimits(const Bodies& bodies, std::span<const Material> materials)
    : forces_(bodies.points_rest().size(), 0.0) {
  const std::span<const Vec3> rest = bodies.points_rest();
  for (const auto& [a, b, c] : bodies.triangles()) {
    const double area = 0.5 * length(cross(at(rest, b) - at(rest, a), at(rest, c) - at(rest, a)));
    const Material& material = at(materials, at(bodies.body_of_point(), a));
    const double force = largest_strain * material.young_modulus * area / 3.0;
    for (const Index point : {a, b, c}) at(forces_, point) += force;
  }
}

double limited_stiffness(const Vec3& point, const Vec3& target, double stiffness, double most) {
  const double force = stiffness * length(target - point);
  return force > most ? stiffness * (most / force) : stiffness;
}

}  // namespace palpate::view
