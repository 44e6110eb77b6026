#include "view/pull_limits.hpp"

#include <algorithm>

#include "geometry/box.hpp"
#include "geometry/vector.hpp"

namespace palpate::view {
namespace {

Box box_of(const Bodies& bodies, const Body& body) {
  Box box;
  for (Index p = body.points.begin; p < body.points.end; ++p) box.extend(at(bodies.points_rest(), p));
  return box;
}

bool meet(const Box& a, const Box& b) {
  return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y &&
         b.lower.y <= a.upper.y && a.lower.z <= b.upper.z && b.lower.z <= a.upper.z;
}

double area_of(const Bodies& bodies, const Triangle& triangle) {
  const auto corner = [&](std::size_t i) { return at(bodies.points_rest(), triangle[i]); };
  return 0.5 * length(cross(corner(1) - corner(0), corner(2) - corner(0)));
}

/// Young's modulus of the softest body whose box meets that of each, itself included.
std::vector<double> softest_around(const Bodies& bodies, std::span<const Material> materials,
                                   std::span<const std::uint8_t> rigid) {
  std::vector<Box> boxes;
  std::vector<double> softest;
  boxes.reserve(bodies.bodies().size());
  softest.reserve(bodies.bodies().size());
  for (const Body& body : bodies.bodies()) boxes.push_back(box_of(bodies, body));
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    double modulus = materials[b].young_modulus;
    for (std::size_t other = 0; other < boxes.size(); ++other) {
      const bool counts = (rigid.empty() || rigid[other] == 0) && meet(boxes[b], boxes[other]);
      if (counts) modulus = std::min(modulus, materials[other].young_modulus);
    }
    softest.push_back(modulus);
  }
  return softest;
}

}  // namespace

PullLimits::PullLimits(const Bodies& bodies, std::span<const Material> materials,
                       std::span<const std::uint8_t> rigid)
    : forces_(bodies.points_rest().size(), 0.0) {
  const std::vector<double> softest = softest_around(bodies, materials, rigid);
  for (std::size_t b = 0; b < bodies.bodies().size(); ++b) {
    double surface = 0.0;
    const auto [begin, end] = bodies.bodies()[b].triangles;
    for (Index t = begin; t < end; ++t) {
      const Triangle& triangle = at(bodies.triangles(), t);
      const double area = area_of(bodies, triangle);
      const double force = largest_strain * materials[b].young_modulus * area / 3.0;
      for (const Index point : triangle) at(forces_, point) += force;
      surface += area;
    }
    const double most = largest_squeeze * softest[b] * 0.25 * surface;
    const Range points = bodies.bodies()[b].points;
    for (Index p = points.begin; p < points.end; ++p) at(forces_, p) = std::min(at(forces_, p), most);
  }
}

double limited_stiffness(const Vec3& point, const Vec3& target, double stiffness, double most) {
  const double force = stiffness * length(target - point);
  return force > most ? stiffness * (most / force) : stiffness;
}

}  // namespace palpate::view
