// Reactions at points that do not move freely. Oracles: Newton's laws, weights, levers.
#include <cmath>
#include <gtest/gtest.h>

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

/// A beam that is held at one end: the support carries its weight and the moment of it.
TEST(Reaction, OfFixedPointsIsTheWeightAndItsLever) {
  Model model;
  model.bodies.add("beam", test::box_mesh({8, 2, 2}, {0, 0, 0}, {0.2, 0.04, 0.04}));
  model.materials = {Material{.young_modulus = 1e6, .mass_damping = 5.0, .stiffness_damping = 2e-3}};
  for (const Vec3& p : model.bodies.points_rest()) model.fixed_points.push_back(p.x == 0.0 ? 1 : 0);
  SimulationSettings settings = exact_settings();
  settings.rest.speed = 1e-7;
  Simulation simulation(std::move(model), settings, 2);
  EXPECT_THROW(static_cast<void>(simulation.reactions()), Error);
  simulation.record_reactions(true);
  EXPECT_THROW(static_cast<void>(simulation.reactions()), Error);
  run_to_rest(simulation, 3000);
  const double weight = g * simulation.masses()[0];
  const Vec3 sum = sum_of(simulation.reactions());
  EXPECT_NEAR(sum.z, weight, 1e-5 * weight);
  EXPECT_NEAR(std::hypot(sum.x, sum.y), 0.0, 1e-5 * weight);
  const Vec3 root{0.0, 0.02, 0.02};
  const Vec3 center = simulation.center_of_mass(0);
  const Wrench held = simulation.reaction_of_body(0, root);
  EXPECT_LT(length(held.force - sum), 1e-12 * weight);
  // The moment of the weight about the root is (center - root) x (-W z); the support balances it.
  EXPECT_NEAR(held.torque.y, -weight * (center.x - root.x), 1e-4 * weight * 0.2);
  EXPECT_EQ(moved_to(held, center).about, center);
  EXPECT_NEAR(moved_to(held, center).torque.y, 0.0, 1e-4 * weight * 0.2);
}

/// With mass and stiffness damping, in motion: force on all points is the change of momentum, step by step.
TEST(Reaction, KeepsNewtonsLawInMotion) {
  Model model;
  model.bodies.add("beam", test::box_mesh({6, 2, 2}, {0, 0, 0}, {0.2, 0.04, 0.04}));
  model.materials = {Material{.young_modulus = 2e5, .stiffness_damping = 5e-3}};
  model.motions.push_back(
      {{}, {{0.0, {}, {1, 0, 0, 0}}, {0.3, {0.02, 0.05, 0.0}, {0.98, 0, 0.1, 0.1}}}, Interpolation::smooth});
  for (const Vec3& p : model.bodies.points_rest()) {
    model.motion_of_point.push_back(p.x == 0.0 ? 0 : -1);
  }
  SimulationSettings settings;
  settings.solver.tolerance = 1e-13;
  settings.solver.max_iterations = 20000;
  Simulation simulation(std::move(model), settings, 2);
  simulation.record_reactions(true);
  std::vector<double> mass(simulation.bodies().points_rest().size(), 0.0);
  for (const Tet& t : simulation.bodies().tets()) {
    const auto corner = [&](std::size_t i) { return at(simulation.bodies().points_rest(), t[i]); };
    const double six = dot(cross(corner(1) - corner(0), corner(2) - corner(0)), corner(3) - corner(0));
    for (const Index p : t) at(mass, p) += 1000.0 * six / 24.0;
  }
  const auto momentum = [&] {
    Vec3 sum;
    for (std::size_t p = 0; p < mass.size(); ++p) sum += mass[p] * simulation.velocities()[p];
    return sum;
  };
  for (int step = 0; step < 40; ++step) {
    const Vec3 before = momentum();
    simulation.step();
    const Vec3 change = 100.0 * (momentum() - before) + Vec3{0.0, 0.0, g * simulation.masses()[0]};
    const Wrench motor = simulation.reaction_of_motion(0, {});
    ASSERT_LT(length(motor.force - change), 1e-8 * length(change)) << "step " << step;
    ASSERT_EQ(sum_of(simulation.reactions()), motor.force) << "nothing else is held";
  }
}

/// A plate with a prescribed motion presses a block onto fixed points: reaction forces and torques balance.
TEST(Reaction, OfAPressingPlateAndOfTheSupportBalance) {
  Model model;
  model.bodies.add("block", test::box_mesh({5, 4, 3}, {-0.05, -0.05, 0.0}, {0.05, 0.05, 0.06}));
  model.bodies.add("plate", test::box_mesh({2, 2, 1}, {-0.02, -0.06, 0.0605}, {0.1, 0.06, 0.08}));
  model.materials = {Material{.young_modulus = 5e4, .mass_damping = 10.0, .stiffness_damping = 5e-3},
                     Material{.density = 500.0}};
  model.obstacles = {0, 1};
  model.motions.push_back({{0.04, 0, 0.07},
                           {{0.0, {}, {1, 0, 0, 0}}, {0.3, {0, 0, -0.006}, {0.999, 0, 0.02, 0}}},
                           Interpolation::smooth});
  for (std::size_t p = 0; p < model.bodies.points_rest().size(); ++p) {
    const bool block = model.bodies.body_of_point()[p] == 0;
    model.motion_of_point.push_back(block ? -1 : 0);
    model.fixed_points.push_back(block && model.bodies.points_rest()[p].z == 0.0 ? 1 : 0);
  }
  SimulationSettings settings = exact_settings();
  settings.response.friction = 0.5;
  settings.rest.speed = 1e-6;
  Simulation simulation(std::move(model), settings, 2);
  simulation.record_reactions(true);
  run_to_rest(simulation, 2000);
  const Vec3 about{0.01, 0.02, 0.03};
  const Wrench plate = simulation.contact_wrench(1, about);
  const Wrench support = simulation.reaction_of_body(0, about);
  const Wrench motor = simulation.reaction_of_motion(0, about);
  EXPECT_THROW(static_cast<void>(simulation.reaction_of_motion(0, {0.0, NAN, 0.0})), Error);
  const double block_weight = g * simulation.masses()[0];
  const double plate_weight = g * simulation.masses()[1];
  ASSERT_GT(plate.force.z, 5.0);
  const double size = length(plate.force);
  EXPECT_LT(length(support.force - Vec3{0, 0, block_weight} - plate.force), 1e-5 * size);
  EXPECT_LT(length(motor.force - Vec3{0, 0, plate_weight} + plate.force), 1e-5 * size);
  const auto moment = [&](Index body, double weight) {
    return cross(simulation.center_of_mass(body) - about, Vec3{0, 0, -weight});
  };
  EXPECT_GT(length(plate.torque), 0.05 * size * 0.03) << "it presses beside the middle";
  EXPECT_LT(length(support.torque + moment(0, block_weight) - plate.torque), 1e-4 * size * 0.05);
  EXPECT_LT(length(motor.torque + moment(1, plate_weight) + plate.torque), 1e-4 * size * 0.05);
}

/// Ties and grabs hold the bodies that hang on them.
TEST(Reaction, OfTiesAndGrabsIsTheWeightThatHangsOnThem) {
  Model model;
  model.bodies.add("upper", test::box_mesh({2, 2, 1}, {-0.05, -0.05, 0.001}, {0.05, 0.05, 0.041}));
  model.bodies.add("lower", test::box_mesh({2, 2, 1}, {-0.05, -0.05, -0.04}, {0.05, 0.05, 0.0}));
  const Material material{.young_modulus = 1e5, .mass_damping = 5.0, .stiffness_damping = 2e-3};
  model.materials = {material, material};
  const auto rest = model.bodies.points_rest();
  for (const Vec3& p : rest) model.fixed_points.push_back(p.z > 0.04 ? 1 : 0);
  const Range upper = model.bodies.bodies()[0].tets;
  for (Index p = model.bodies.bodies()[1].points.begin; p < model.bodies.bodies()[1].points.end; ++p) {
    if (at(rest, p).z != 0.0) continue;
    Index best = -1;
    double nearest = 1e9;
    for (Index t = upper.begin; t < upper.end; ++t) {
      Vec3 center;
      for (const Index c : at(model.bodies.tets(), t)) center += 0.25 * at(rest, c);
      if (length(center - at(rest, p)) < nearest) {
        nearest = length(center - at(rest, p));
        best = t;
      }
    }
    model.ties.push_back({p, best, 500.0});
  }
  SimulationSettings settings = exact_settings();
  settings.rest.speed = 1e-7;
  Simulation simulation(std::move(model), settings, 2);
  simulation.record_reactions(true);
  EXPECT_EQ(sum_of(simulation.tie_forces()), Vec3{});
  run_to_rest(simulation, 3000);
  const double lower = g * simulation.masses()[1];
  const double both = lower + g * simulation.masses()[0];
  ASSERT_EQ(simulation.tie_forces().size(), 9U);
  EXPECT_NEAR(sum_of(simulation.tie_forces()).z, lower, 1e-5 * lower);
  EXPECT_NEAR(sum_of(simulation.reactions()).z, both, 1e-5 * both);
  const Index corner = simulation.bodies().bodies()[1].points.begin;
  const Index grab = simulation.grab({corner, at(simulation.positions(), corner) + Vec3{0, 0, -0.02}, 10.0});
  for (int step = 0; step < 600; ++step) simulation.step();
  const Vec3 pull = simulation.grab_force(grab);
  EXPECT_LT(pull.z, -0.1);
  EXPECT_LT(length(sum_of(simulation.tie_forces()) + pull - Vec3{0, 0, lower}), 1e-4 * lower);
  EXPECT_LT(length(sum_of(simulation.reactions()) + pull - Vec3{0, 0, both}), 1e-4 * both);
}

}  // namespace
}  // namespace palpate
