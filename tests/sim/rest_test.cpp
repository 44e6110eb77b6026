// What lies still comes to rest: mats that hang over a post, and piles of soft balls, once trembled for as
// long as they were watched (20 s), by contacts that opened and closed alternately.
#include <gtest/gtest.h>
#include <string>

#include <palpate/simulation.hpp>

#include "support/meshes.hpp"
#include "support/random.hpp"

namespace palpate {
namespace {

constexpr double longest = 20.0;  // s, of the simulation

void add_obstacle(Model& model, const std::string& name, const Vec3& lower, const Vec3& upper) {
  model.bodies.add(name, test::box_mesh({2, 2, 2}, lower, upper));
  model.materials.emplace_back();
  model.obstacles.push_back(1);
}

void add_soft(Model& model, const std::string& name, TetMesh mesh, double young_modulus) {
  model.bodies.add(name, std::move(mesh));
  model.materials.push_back({.young_modulus = young_modulus, .poisson_ratio = 0.4});
  model.obstacles.push_back(0);
}

/// A mat of 20 cm is dropped on a post of 2 cm, `off` its centre, and sags to the floor or hangs.
Model mat(double young_modulus, double off) {
  Model model;
  add_obstacle(model, "post", {-0.01, -0.01, 0.0}, {0.01, 0.01, 0.1});
  add_obstacle(model, "floor", {-0.3, -0.3, -0.02}, {0.3, 0.3, 0.0});
  add_soft(
      model, "mat",
      test::box_mesh({16, 16, 2}, {-0.1 + off, -0.1 + 0.6 * off, 0.102}, {0.1 + off, 0.1 + 0.6 * off, 0.112}),
      young_modulus);
  return model;
}

/// Six balls fall between four walls.
Model pile(double young_modulus) {
  constexpr double radius = 0.04;
  Model model;
  add_obstacle(model, "floor", {-0.3, -0.3, -0.02}, {0.3, 0.3, 0.0});
  add_obstacle(model, "left", {-0.13, -0.13, 0.0}, {-0.11, 0.13, 0.3});
  add_obstacle(model, "right", {0.11, -0.13, 0.0}, {0.13, 0.13, 0.3});
  add_obstacle(model, "front", {-0.13, -0.13, 0.0}, {0.13, -0.11, 0.3});
  add_obstacle(model, "back", {-0.13, 0.11, 0.0}, {0.13, 0.13, 0.3});
  test::Random random(1);
  for (int i = 0; i < 6; ++i) {
    const double x = random.uniform(-0.05, 0.05);
    const Vec3 centre{x, random.uniform(-0.05, 0.05), radius + 0.01 + 2.05 * radius * i};
    add_soft(model, "ball " + std::to_string(i), test::ball_mesh(5, centre, radius), young_modulus);
  }
  return model;
}

void expect_rest(Model model, double time_step, const std::string& name) {
  SimulationSettings settings;
  settings.time_step = time_step;
  settings.response.friction = 0.3;
  Simulation simulation(std::move(model), settings, 2);
  int not_converged = 0;
  while (!simulation.at_rest() && simulation.metrics().time < longest)
    not_converged += simulation.step().solver_converged ? 0 : 1;
  EXPECT_TRUE(simulation.at_rest()) << name << ": " << simulation.metrics().fastest_body << " m/s";
  EXPECT_EQ(not_converged, 0) << name;
}

/// A solve that is cut off may leave everything where it is.
TEST(Rest, IsNotWhereStepsDoNotConverge) {
  const auto rests = [](const SolverSettings& solver) {
    Model model;
    model.bodies.add("beam", test::box_mesh({8, 2, 2}, {0, 0, 0}, {0.4, 0.1, 0.1}));
    model.materials.assign(1, {.young_modulus = 1e8});
    for (const Vec3& p : model.bodies.points_rest()) model.fixed_points.push_back(p.x == 0.0 ? 1 : 0);
    SimulationSettings settings;
    settings.time_step = 0.01;
    settings.rest = {.speed = 1e3, .time = 0.02};  // anything counts as slow
    settings.solver = solver;
    Simulation simulation(std::move(model), settings, 1);
    for (int step = 0; step < 10; ++step) simulation.step();
    EXPECT_EQ(simulation.metrics().solver_converged, solver.max_iterations > 1);
    return simulation.at_rest();
  };
  EXPECT_TRUE(rests({}));
  EXPECT_FALSE(rests({.tolerance = 1e-12, .max_iterations = 1, .max_substeps = 1}));
}

TEST(Rest, MatsOnAPostLieStill) {
  for (const double young_modulus : {3e3, 2e5})
    expect_rest(mat(young_modulus, 0.004), 0.01, "mat of " + std::to_string(young_modulus) + " Pa");
}

TEST(Rest, PilesOfSoftBallsLieStill) {
  expect_rest(pile(3e3), 0.01, "pile");
}

TEST(Rest, DISABLED_MatsAndPilesOfAnyStiffnessLieStill) {
  for (const double time_step : {0.002, 0.005, 0.01, 0.02}) {
    const std::string step = ", step of " + std::to_string(time_step) + " s";
    for (const double young_modulus : {3e3, 2e4, 2e5, 2e6}) {
      const std::string stiffness = std::to_string(young_modulus) + " Pa";
      for (const double off : {0.0, 0.004, 0.03})
        expect_rest(mat(young_modulus, off), time_step,
                    "mat of " + stiffness + " off by " + std::to_string(off) + step);
      expect_rest(pile(young_modulus), time_step, "pile of " + stiffness + step);
    }
  }
}

}  // namespace
}  // namespace palpate
