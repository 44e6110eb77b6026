#include "view/pull_limits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

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

/// For each body, Young's modulus of the softest body whose box meets its own (including itself).
/// \param others  (n_bodies) 1: a body that counts for no other
std::vector<double> softest_around(const Bodies& bodies, std::span<const Material> materials,
                                   std::span<const std::uint8_t> others) {
  std::vector<Box> boxes(bodies.bodies().size());
  std::vector<double> softest(boxes.size());
  for (std::size_t b = 0; b < boxes.size(); ++b) boxes[b] = box_of(bodies, bodies.bodies()[b]);
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    double modulus = materials[b].young_modulus;
    for (std::size_t other = 0; other < boxes.size(); ++other) {
      const bool counts = others[other] == 0 && meet(boxes[b], boxes[other]);
      if (counts) modulus = std::min(modulus, materials[other].young_modulus);
    }
    softest[b] = modulus;
  }
  return softest;
}

/// (n_bodies) 1: rigid or absent.
std::vector<std::uint8_t> rigid_or_absent(const Model& model) {
  std::vector<std::uint8_t> flags(model.bodies.bodies().size(), 0);
  for (std::size_t b = 0; b < flags.size(); ++b) {
    const bool rigid = !model.obstacles.empty() && model.obstacles[b] != 0;
    const bool absent = !model.absent.empty() && model.absent[b] != 0;
    flags[b] = rigid || absent ? 1 : 0;
  }
  return flags;
}

const Material& material_of(const Model& model, Index tet) {
  const Index body = model.bodies.body_of(at(model.bodies.tets(), tet));
  return at(model.materials, model.material_of_tet.empty() ? body : at(model.material_of_tet, tet));
}

/// (n_points) Largest force by the tets at each point.
std::vector<double> tet_limits(const Model& model) {
  std::vector<double> forces(model.bodies.points_rest().size(), 0.0);
  const auto count = static_cast<Index>(model.bodies.tets().size());
  for (Index t = 0; t < count; ++t) {
    const Tet& tet = at(model.bodies.tets(), t);
    const double pressure = PullLimits::largest_strain * material_of(model, t).young_modulus / 3.0;
    for (std::size_t i = 0; i < 4; ++i) {
      const auto corner = [&](std::size_t k) { return at(model.bodies.points_rest(), tet[(i + k) % 4]); };
      at(forces, tet[i]) += pressure * 0.5 * length(cross(corner(2) - corner(1), corner(3) - corner(1)));
    }
  }
  return forces;
}

/// (n_points) Young's modulus of the softest tet at each point.
std::vector<double> softest_at_points(const Model& model) {
  std::vector<double> moduli(model.bodies.points_rest().size(), std::numeric_limits<double>::max());
  const auto count = static_cast<Index>(model.bodies.tets().size());
  for (Index t = 0; t < count; ++t) {
    const double modulus = material_of(model, t).young_modulus;
    for (const Index point : at(model.bodies.tets(), t)) {
      at(moduli, point) = std::min(at(moduli, point), modulus);
    }
  }
  return moduli;
}

/// (n_bodies) Whether a body is fixed, prescribed or tied.
std::vector<std::uint8_t> held_bodies(const Model& model) {
  const Bodies& bodies = model.bodies;
  std::vector<std::uint8_t> held(bodies.bodies().size(), 0);
  const auto hold = [&](Index point) { at(held, at(bodies.body_of_point(), point)) = 1; };
  const auto count = static_cast<Index>(bodies.points_rest().size());
  for (Index p = 0; p < count; ++p) {
    if (!model.fixed_points.empty() && at(model.fixed_points, p) != 0) hold(p);
    if (!model.motion_of_point.empty() && at(model.motion_of_point, p) >= 0) hold(p);
  }
  for (const Tie& tie : model.ties) {
    hold(tie.point);
    hold(at(bodies.tets(), tie.tet)[0]);
  }
  return held;
}

/// (n_points) A quarter of the mass of each tet at a point.
std::vector<double> point_masses(const Model& model) {
  std::vector<double> masses(model.bodies.points_rest().size(), 0.0);
  const auto count = static_cast<Index>(model.bodies.tets().size());
  for (Index t = 0; t < count; ++t) {
    const Tet& tet = at(model.bodies.tets(), t);
    const auto corner = [&](std::size_t i) { return at(model.bodies.points_rest(), tet[i]); };
    const double volume =
        dot(cross(corner(1) - corner(0), corner(2) - corner(0)), corner(3) - corner(0)) / 6.0;
    for (const Index point : tet) at(masses, point) += 0.25 * material_of(model, t).density * volume;
  }
  return masses;
}

}  // namespace

PullLimits::PullLimits(const Model& model, std::span<const Material> of_bodies, std::span<const double> edges,
                       double time_step)
    : masses_(point_masses(model)), forces_(masses_.size(), 0.0) {
  const Bodies& bodies = model.bodies;
  const std::vector<double> softest = softest_around(bodies, of_bodies, rigid_or_absent(model));
  const std::vector<std::uint8_t> held = held_bodies(model);
  const std::vector<double> of_tets = tet_limits(model);
  const std::vector<double> moduli = softest_at_points(model);
  for (Index b = 0; b < bodies.body_count(); ++b) {
    const Range points = at(bodies.bodies(), b).points;
    double surface = 0.0;
    const auto [begin, end] = at(bodies.bodies(), b).triangles;
    for (Index t = begin; t < end; ++t) {
      const Triangle& triangle = at(bodies.triangles(), t);
      const double area = area_of(bodies, triangle);
      for (const Index point : triangle)
        at(forces_, point) += largest_strain * at(moduli, point) * area / 3.0;
      surface += area;
    }
    double most = largest_squeeze * at(softest, b) * 0.25 * surface;
    if (at(held, b) == 0) {
      const double mass = std::accumulate(masses_.begin() + points.begin, masses_.begin() + points.end, 0.0);
      most = std::min(most, largest_leap * mass * at(edges, b) / (time_step * time_step));
    }
    for (Index p = points.begin; p < points.end; ++p) {
      at(forces_, p) = std::min({at(forces_, p), at(of_tets, p), most});
    }
  }
}

double limited_stiffness(const PullSpring& spring, const Vec3& point, const Vec3& velocity, double time_step,
                         const Vec3& target) {
  const Vec3 stretch = target - point;
  const double distance = std::max(length(stretch), length(stretch - time_step * velocity));
  // The root s of the stiffness: distance s^2 + 2 sqrt(mass) speed s = most.
  const double damped = std::sqrt(spring.mass) * length(velocity);
  const double root = spring.most / (damped + std::sqrt(damped * damped + distance * spring.most));
  return std::min(spring.stiffness, root * root);
}

}  // namespace palpate::view
