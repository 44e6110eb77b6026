// Forces of contacts, and reactions at held points. Oracles: Newton's laws, weights, levers, Coulomb's law.
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <string>

#include <palpate/error.hpp>
#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "sim/exact_runs.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

using test::exact_settings;
using test::g;
using test::run_to_rest;
using test::sum_of;

/// A plate (body 0, fixed), a soft block on it (1), and a ball that falls on the block, off its middle (2).
Simulation pile(int threads = 2) {
  Model model;
  model.bodies.add("plate", test::box_mesh({3, 3, 1}, {-0.2, -0.2, -0.05}, {0.2, 0.2, 0}));
  model.bodies.add("block", test::box_mesh({4, 4, 3}, {-0.06, -0.06, -1e-4}, {0.06, 0.06, 0.0799}));
  model.bodies.add("ball", test::ball_mesh(4, {0.02, 0.01, 0.105}, 0.03));
  model.materials = {Material{},
                     Material{.young_modulus = 2e4, .mass_damping = 3.0, .stiffness_damping = 2e-3},
                     Material{.young_modulus = 5e4, .mass_damping = 3.0, .stiffness_damping = 2e-3}};
  model.obstacles = {1, 0, 0};
  SimulationSettings settings = exact_settings();
  settings.response.friction = 0.4;
  return Simulation(std::move(model), settings, threads);
}

TEST(Wrench, OfAllPairsIsZeroToRoundingAtEveryStep) {
  Simulation simulation = pile();
  double largest = 0.0;
  for (int step = 0; step < 120; ++step) {
    simulation.step();
    Vec3 force;
    Vec3 torque;
    double size = 0.0;
    for (Index b = 0; b < 3; ++b) {
      const Wrench w = simulation.contact_wrench(b, {0.1, -0.2, 0.3});
      force += w.force;
      torque += w.torque;
      size += length(w.force);
      EXPECT_LE(length(w.force - at(simulation.contact_forces(), b)), 1e-13 * (size + 1e-300));
    }
    ASSERT_LE(length(force), 1e-13 * size + 1e-300);
    ASSERT_LE(length(torque), 1e-13 * size + 1e-300);
    largest = std::max(largest, size);
    // The pairs are the same forces, body by body.
    std::array<Vec3, 3> of_pairs{};
    for (const PairWrench& pair : simulation.pair_wrenches()) {
      EXPECT_LT(pair.body_a, pair.body_b);
      at(of_pairs, pair.body_b) += pair.on_b.force;
      at(of_pairs, pair.body_a) -= pair.on_b.force;
      EXPECT_GE(pair.normal, length(pair.on_b.force) * 0.3);
    }
    for (Index b = 0; b < 3; ++b)
      EXPECT_LE(length(at(of_pairs, b) - at(simulation.contact_forces(), b)), 1e-12 * (size + 1e-300));
  }
  EXPECT_GT(largest, 1.0);
}

/// M' = M + (a - b) x F, and what the pairs of a body add up to is its wrench.
TEST(WrenchOfPairs, AboutAPointIsTransported) {
  Simulation simulation = pile();
  for (int step = 0; step < 60; ++step) simulation.step();
  const Vec3 about{0.4, -0.3, 0.2};
  const std::vector<PairWrench> centered = simulation.pair_wrenches();
  const std::vector<PairWrench> pairs = simulation.pair_wrenches(about);
  ASSERT_EQ(pairs.size(), 2U) << "the plate and the block, the block and the ball";
  Wrench on_block{.force = {}, .torque = {}, .about = about};
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Wrench& a = centered[i].on_b;
    const Wrench& b = pairs[i].on_b;
    EXPECT_EQ(centered[i].body_b, pairs[i].body_b);
    EXPECT_EQ(a.about, simulation.center_of_mass(pairs[i].body_b));
    EXPECT_EQ(b.about, about);
    EXPECT_EQ(b.force, a.force);
    ASSERT_GT(length(b.force), 0.1);
    const Vec3 arm = a.about - about;
    const Vec3 moved{a.torque.x + arm.y * a.force.z - arm.z * a.force.y,
                     a.torque.y + arm.z * a.force.x - arm.x * a.force.z,
                     a.torque.z + arm.x * a.force.y - arm.y * a.force.x};
    EXPECT_LT(length(b.torque - moved), 1e-12 * length(b.force));
    ASSERT_GT(length(b.torque - a.torque), 0.01 * length(b.force)) << "the point matters";
    const double sign = pairs[i].body_b == 1 ? 1.0 : -1.0;
    on_block.force += sign * b.force;
    on_block.torque += sign * b.torque;
  }
  const Wrench expected = simulation.contact_wrench(1, about);
  EXPECT_LT(length(on_block.force - expected.force), 1e-12 * length(expected.force) + 1e-13);
  EXPECT_LT(length(on_block.torque - expected.torque), 1e-12);
}

TEST(Wrench, RefusesPointsThatAreNotFinite) {
  Simulation simulation = pile(1);
  simulation.record_reactions(true);
  simulation.step();
  const Wrench wrench = simulation.contact_wrench(1);
  for (const Vec3& about : {Vec3{NAN, 0, 0}, Vec3{0, INFINITY, 0}, Vec3{0, 0, -INFINITY}}) {
    const auto message = [](auto&& call) -> std::string {
      try {
        static_cast<void>(call());
      } catch (const Error& error) {
        return error.what();
      }
      return "accepted";
    };
    const std::string refused =
        "wrench: about: found a number that is not finite, expected three finite numbers";
    EXPECT_EQ(message([&] { return simulation.contact_wrench(1, about); }), refused);
    EXPECT_EQ(message([&] { return simulation.pair_wrenches(about); }), refused);
    EXPECT_EQ(message([&] { return simulation.reaction_of_body(0, about); }), refused);
    EXPECT_EQ(message([&] { return moved_to(wrench, about); }), refused);
  }
}

TEST(Wrench, ListsEachContactWithItsForce) {
  Simulation simulation = pile();
  EXPECT_EQ(simulation.acting_contacts().size(), 0U) << "before the first step nothing has acted";
  bool met = false;
  std::size_t sticks = 0;
  for (int step = 0; step < 120; ++step) {
    simulation.step();
    const ContactForces c = simulation.acting_contacts();
    Vec3 on_ball;
    for (std::size_t i = 0; i < c.size(); ++i) {
      const Index inside = at(simulation.bodies().body_of_point(), c.point[i]);
      ASSERT_EQ(simulation.bodies().body_of(at(simulation.bodies().tets(), c.tet[i])), c.body[i]);
      ASSERT_NEAR(c.weights[i][0] + c.weights[i][1] + c.weights[i][2] + c.weights[i][3], 1.0, 1e-12);
      ASSERT_NEAR(length(c.direction[i]), 1.0, 1e-12);
      ASSERT_NEAR(dot(c.friction[i], c.direction[i]), 0.0, 1e-12 * (1.0 + length(c.friction[i])));
      if (c.speculative[i] == 0) {
        ASSERT_GE(c.depth[i], 0.0);
      }
      if (c.status[i] == ContactStatus::open) {
        ASSERT_EQ(c.force(i), Vec3{});
      }
      if (inside == 2) on_ball += c.force(i);
      if (c.body[i] == 2) on_ball -= c.force(i);
      met = met || c.speculative[i] != 0;
      sticks += c.status[i] == ContactStatus::stick ? 1 : 0;
    }
    ASSERT_LT(length(on_ball - simulation.contact_forces()[2]), 1e-12 * (1.0 + length(on_ball)));
  }
  EXPECT_TRUE(met) << "the ball fell on the block";
  EXPECT_GT(sticks, 100U);
}

/// Tilts gravity instead of the plate.
void expect_incline(double degrees, double friction, bool slides) {
  Model model;
  model.bodies.add("plate", test::box_mesh({3, 3, 1}, {-0.5, -0.5, -0.1}, {0.5, 0.5, 0}));
  model.bodies.add("block", test::box_mesh({4, 4, 2}, {-0.05, -0.05, -1e-4}, {0.05, 0.05, 0.0399}));
  model.materials = {Material{}, Material{.young_modulus = 2e5, .stiffness_damping = 2e-3}};
  model.obstacles = {1, 0};
  SimulationSettings settings = exact_settings();
  settings.response.friction = friction;
  const double angle = degrees * std::numbers::pi / 180.0;
  settings.gravity = {g * std::sin(angle), 0.0, -g * std::cos(angle)};
  Simulation simulation(std::move(model), settings, 2);
  for (int step = 0; step < (slides ? 40 : 200); ++step) simulation.step();
  const ContactForces c = simulation.acting_contacts();
  double normal = 0.0;
  Vec3 tangent;
  double friction_sum = 0.0;
  for (std::size_t i = 0; i < c.size(); ++i) {
    if (c.status[i] == ContactStatus::open) continue;
    normal += c.normal[i];
    tangent += c.friction[i];
    friction_sum += length(c.friction[i]);
    if (slides) {
      EXPECT_EQ(c.status[i], ContactStatus::slide);
    }
    if (!slides) {
      EXPECT_LE(length(c.friction[i]), friction * c.normal[i] * 1.02);
    }
  }
  const double weight = g * simulation.masses()[1];
  EXPECT_NEAR(normal, weight * std::cos(angle), 0.01 * weight);
  EXPECT_NEAR(-tangent.x, slides ? friction * normal : weight * std::sin(angle), 0.01 * weight);
  EXPECT_NEAR(simulation.contact_wrench(1).force.z, weight * std::cos(angle), 0.01 * weight);
}
TEST(WrenchOnAnIncline, HasTheFrictionThatHolds) {
  expect_incline(15.0, 0.5, false);
}
TEST(WrenchOnAnIncline, HasCoulombsFrictionWhereItSlides) {
  expect_incline(25.0, 0.2, true);
}

/// Over a fall, a hit and rest: the impulse of contacts and gravity is the change of momentum.
TEST(WrenchImpulse, IsTheChangeOfMomentum) {
  Model model;
  model.bodies.add("plate", test::box_mesh({3, 3, 1}, {-0.2, -0.2, -0.05}, {0.2, 0.2, 0}));
  model.bodies.add("ball", test::ball_mesh(4, {0.0, 0.0, 0.034}, 0.03));
  model.materials = {Material{}, Material{.young_modulus = 2e4, .stiffness_damping = 5e-3}};
  model.obstacles = {1, 0};
  SimulationSettings settings;
  settings.response.friction = 0.3;
  settings.solver.tolerance = 1e-13;
  settings.solver.max_iterations = 20000;
  Simulation simulation(std::move(model), settings, 2);
  std::vector<double> mass(simulation.bodies().points_rest().size(), 0.0);
  for (const Tet& t : simulation.bodies().tets()) {
    const auto corner = [&](std::size_t i) { return at(simulation.bodies().points_rest(), t[i]); };
    const double six = dot(cross(corner(1) - corner(0), corner(2) - corner(0)), corner(3) - corner(0));
    for (const Index p : t) at(mass, p) += 1000.0 * six / 24.0;
  }
  const Range ball = simulation.bodies().bodies()[1].points;
  const auto momentum = [&] {
    Vec3 sum;
    for (Index p = ball.begin; p < ball.end; ++p) sum += at(mass, p) * at(simulation.velocities(), p);
    return sum;
  };
  const Vec3 before = momentum();
  Vec3 impulse;
  double size = 0.0;
  for (int step = 0; step < 100; ++step) {
    simulation.step();
    const Vec3 force = simulation.contact_wrench(1).force + Vec3{0.0, 0.0, -g * simulation.masses()[1]};
    impulse += 0.01 * force;
    size += 0.01 * length(force);
    ASSERT_LT(length(momentum() - before - impulse), 1e-9 * size) << "step " << step;
  }
  EXPECT_GT(simulation.contact_wrench(1).force.z, 0.9 * g * simulation.masses()[1]);
}

/// A ball between two plates, beside their centres: the torque is force times lever.
TEST(WrenchTorque, OfABallBesideTheMiddleIsForceTimesLever) {
  constexpr double off = 0.03;
  Model model;
  model.bodies.add("lower", test::box_mesh({2, 2, 1}, {-0.06, -0.06, -0.07}, {0.06, 0.06, -0.05}));
  model.bodies.add("upper", test::box_mesh({2, 2, 1}, {-0.06, -0.06, 0.05}, {0.06, 0.06, 0.07}));
  model.bodies.add("ball", test::ball_mesh(6, {off, 0.0, 0.0}, 0.05));
  model.materials = {
      Material{}, Material{},
      Material{.young_modulus = 1e5, .poisson_ratio = 0.3, .mass_damping = 5.0, .stiffness_damping = 0.01}};
  model.obstacles = {1, 1, 0};
  model.motions.push_back(
      {{}, {{0.0, {}, {1, 0, 0, 0}}, {0.3, {0, 0, -0.01}, {1, 0, 0, 0}}}, Interpolation::smooth});
  model.motion_of_point.assign(model.bodies.points_rest().size(), -1);
  const Range upper = model.bodies.bodies()[1].points;
  for (Index p = upper.begin; p < upper.end; ++p) at(model.motion_of_point, p) = 0;
  SimulationSettings settings = exact_settings();
  settings.gravity = {};
  settings.rest.speed = 1e-6;
  Simulation simulation(std::move(model), settings, 2);
  run_to_rest(simulation, 2000);
  const Wrench on_upper = simulation.contact_wrench(1, {0.0, 0.0, 0.05});
  ASSERT_GT(on_upper.force.z, 1.0);
  EXPECT_NEAR(on_upper.torque.y, -off * on_upper.force.z, 1e-3 * off * on_upper.force.z);
  EXPECT_NEAR(on_upper.torque.x, 0.0, 1e-3 * off * on_upper.force.z);
  EXPECT_NEAR(moved_to(on_upper, {off, 0.0, 0.05}).torque.y, 0.0, 1e-3 * off * on_upper.force.z);
}

/// The loads on the triangles of a body add up to its wrench.
TEST(Traction, AddsUpToTheWrenchOfEachBody) {
  Simulation simulation = pile();
  for (int step = 0; step < 100; ++step) simulation.step();
  const SurfaceTractions surface = simulation.tractions();
  const Bodies& bodies = simulation.bodies();
  const auto positions = simulation.positions();
  const Vec3 about{0.3, 0.2, -0.1};
  for (Index b = 0; b < 3; ++b) {
    Vec3 force;
    Vec3 torque;
    Vec3 by_traction;
    double size = 0.0;
    const Range range = at(bodies.bodies(), b).triangles;
    for (Index t = range.begin; t < range.end; ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& f = at(surface.corner_forces, t)[k];
        force += f;
        torque += cross(at(positions, at(bodies.triangles(), t)[k]) - about, f);
        size += length(f);
      }
      by_traction += at(surface.area, t) * at(surface.traction, t);
    }
    const Wrench expected = simulation.contact_wrench(b, about);
    ASSERT_GT(length(expected.force), 0.1);
    EXPECT_LT(length(force - expected.force), 1e-12 * size);
    EXPECT_LT(length(by_traction - expected.force), 1e-12 * size);
    EXPECT_LT(length(torque - expected.torque), 1e-12 * size) << at(bodies.bodies(), b).name;
  }
}

/// A wide block pressed evenly: pressure is force over area in the middle of the face. Friction holds it
/// there: its mesh is not symmetric, so the loaded face tilts a little, and the load would push it to the
/// side.
TEST(Pressure, UnderAPressedBlockIsForceOverArea) {
  Model model;
  model.bodies.add("plate", test::box_mesh({6, 6, 1}, {-0.1, -0.1, -0.05}, {0.1, 0.1, 0}));
  model.bodies.add("block", test::box_mesh({8, 8, 2}, {-0.05, -0.05, -1e-4}, {0.05, 0.05, 0.0249}));
  model.materials = {
      Material{},
      Material{.young_modulus = 1e5, .poisson_ratio = 0.0, .mass_damping = 5.0, .stiffness_damping = 2e-3}};
  model.obstacles = {1, 0};
  // The top is loaded evenly, twenty times the weight.
  SurfaceLoad load{.triangles = {}, .pressure = 5000.0};
  const Range range = model.bodies.bodies()[1].triangles;
  for (Index t = range.begin; t < range.end; ++t) {
    bool top = true;
    for (const Index p : at(model.bodies.triangles(), t))
      top = top && at(model.bodies.points_rest(), p).z > 0.02;
    if (top) load.triangles.push_back(t);
  }
  ASSERT_EQ(load.triangles.size(), 128U);
  model.surface_loads.push_back(load);
  SimulationSettings settings = exact_settings();
  settings.rest.speed = 1e-6;
  settings.response.friction = 0.1;
  Simulation simulation(std::move(model), settings, 2);
  run_to_rest(simulation, 2000);
  const double weight = g * simulation.masses()[1];
  EXPECT_NEAR(simulation.contact_wrench(1).force.z, weight + 5000.0 * 0.01, 5e-4 * 50.0)
      << "the sides give way a little, and the top is that much smaller";
  const double expected = 5000.0 + weight / 0.01;
  const SurfaceTractions surface = simulation.tractions();
  std::size_t inner = 0;
  for (Index t = range.begin; t < range.end; ++t) {
    const Triangle& corners = at(simulation.bodies().triangles(), t);
    bool middle = true;
    for (const Index p : corners) {
      const Vec3& rest = at(simulation.bodies().points_rest(), p);
      middle = middle && rest.z < 0.0 && std::abs(rest.x) < 0.03 && std::abs(rest.y) < 0.03;
    }
    if (!middle) continue;
    ++inner;
    EXPECT_NEAR(at(surface.pressure, t), expected, 0.1 * expected);
  }
  EXPECT_EQ(inner, 32U);
}

/// A saved state contains the forces of its last step.
TEST(Wrench, IsPartOfASavedState) {
  Simulation simulation = pile(1);
  simulation.record_reactions(true);
  for (int step = 0; step < 60; ++step) simulation.step();
  Simulation other = pile(1);
  other.restore(simulation.save());
  const ContactForces a = simulation.acting_contacts();
  const ContactForces b = other.acting_contacts();
  ASSERT_GT(a.size(), 10U);
  EXPECT_EQ(a.point, b.point);
  EXPECT_EQ(a.tet, b.tet);
  EXPECT_EQ(a.friction, b.friction);
  EXPECT_EQ(a.normal, b.normal);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(sum_of(simulation.reactions()), sum_of(other.reactions()));
  EXPECT_EQ(simulation.contact_wrench(2).torque, other.contact_wrench(2).torque);
  simulation.step();
  other.step();
  EXPECT_EQ(sum_of(simulation.reactions()), sum_of(other.reactions())) << "it continues to record them";
}

TEST(Wrench, RefusesBodiesThatAreNotThere) {
  const Simulation simulation = pile(1);
  EXPECT_THROW(static_cast<void>(simulation.contact_wrench(3)), Error);
  EXPECT_THROW(static_cast<void>(simulation.contact_wrench(-1, {})), Error);
  EXPECT_THROW(static_cast<void>(simulation.center_of_mass(7)), Error);
}

}  // namespace
}  // namespace palpate
