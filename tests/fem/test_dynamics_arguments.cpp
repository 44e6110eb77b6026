#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <string>

#include <palpate/error.hpp>

#include "fem/meshes.hpp"

namespace palpate::fem::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

void expect_error(const std::function<void()>& action, const std::string& message) {
  try {
    action();
    FAIL() << "no error, expected: " << message;
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()), message);
  }
}

Dynamics small_dynamics(const Bodies& bodies) {
  return Scene{}.dynamics(bodies);
}

TEST(DynamicsArguments, BadMaterialsAreRefusedByBodyAndKey) {
  Bodies bodies;
  bodies.add("liver", unit_tet_mesh());
  bodies.add("plate", unit_tet_mesh());
  const auto with = [&](const Material& material) {
    return [&bodies, material] {
      Dynamics(bodies, {Material{}, material}, std::vector<std::uint8_t>(8, 0), {0, 0}, parallel::Threads(1));
    };
  };
  Material bad;
  bad.young_modulus = 0.0;
  expect_error(with(bad), "body plate: young_modulus: found 0, expected a number > 0 (Pa)");
  bad = {};
  bad.poisson_ratio = 0.5;
  expect_error(with(bad), "body plate: poisson_ratio: found 0.5, expected a number > -1 and < 0.5");
  bad.poisson_ratio = -1.0;
  expect_error(with(bad), "body plate: poisson_ratio: found -1, expected a number > -1 and < 0.5");
  bad = {};
  bad.density = -3.5;
  expect_error(with(bad), "body plate: density: found -3.5, expected a number > 0 (kg/m^3)");
  bad = {};
  bad.mass_damping = -1e-9;
  expect_error(with(bad), "body plate: mass_damping: found -1e-09, expected a number >= 0 (1/s)");
  bad = {};
  bad.stiffness_damping = nan;
  expect_error(with(bad), "body plate: stiffness_damping: found nan, expected a number >= 0 (s)");
  bad = {};
  bad.young_modulus = infinity;
  expect_error(with(bad), "body plate: young_modulus: found inf, expected a number > 0 (Pa)");
}

TEST(DynamicsArguments, ArraysOfAnotherLengthAreRefused) {
  const Bodies bodies = single_body(unit_tet_mesh());
  const auto make = [&](std::size_t materials, std::size_t points, std::size_t obstacles) {
    return [&bodies, materials, points, obstacles] {
      Dynamics(bodies, std::vector<Material>(materials), std::vector<std::uint8_t>(points),
               std::vector<std::uint8_t>(obstacles), parallel::Threads(1));
    };
  };
  expect_error(make(2, 4, 1), "dynamics: materials: found 2 values, expected 1 values, one per body");
  expect_error(make(1, 3, 1), "dynamics: fixed_points: found 3 values, expected 4 values, one per point");
  expect_error(make(1, 4, 0), "dynamics: obstacle_bodies: found 0 values, expected 1 values, one per body");
  Dynamics dynamics = small_dynamics(bodies);
  const std::vector<Vec3> five(5);
  expect_error([&] { dynamics.set_positions(five); },
               "dynamics: positions: found 5 values, expected 4 values, one per point");
  expect_error([&] { dynamics.step(0.01, {}, five, {}, 1e-6, 10); },
               "dynamics: external_forces: found 5 values, expected 4 values, one per point");
}

TEST(DynamicsArguments, BadStepsAreRefusedAndChangeNothing) {
  const Bodies bodies = single_body(unit_tet_mesh());
  Dynamics dynamics = small_dynamics(bodies);
  const std::vector<Vec3> before = random_vectors(4, 1.0, 61);
  dynamics.set_velocities(before);
  const std::vector<Vec3> bad(4, {0.0, nan, 0.0});
  for (const double time_step : {0.0, -0.01, nan, infinity}) {
    EXPECT_THROW(dynamics.step(time_step, {}, {}, {}, 1e-6, 10), Error);
  }
  EXPECT_THROW(dynamics.step(0.01, {0.0, 0.0, nan}, {}, {}, 1e-6, 10), Error);
  EXPECT_THROW(dynamics.step(0.01, {}, {}, {}, -1e-6, 10), Error);
  EXPECT_THROW(dynamics.step(0.01, {}, {}, {}, nan, 10), Error);
  EXPECT_THROW(dynamics.step(0.01, {}, {}, {}, 1e-6, -1), Error);
  EXPECT_THROW(dynamics.step(0.01, {}, bad, {}, 1e-6, 10), Error);
  EXPECT_THROW(dynamics.set_positions(bad), Error);
  EXPECT_THROW(dynamics.set_velocities(bad), Error);
  EXPECT_THROW(dynamics.set_velocity_changes(bad), Error);
  EXPECT_TRUE(std::ranges::equal(dynamics.positions(), bodies.points_rest()));
  EXPECT_TRUE(std::ranges::equal(dynamics.velocities(), before));
}

TEST(DynamicsArguments, ReachingTheCapIsReported) {
  const Bodies bodies = single_body(irregular_box_mesh({3, 3, 3}, {0.3, 0.3, 0.3}, 0.2));
  Dynamics dynamics = small_dynamics(bodies);
  dynamics.set_positions(noisy(bodies, 0.02, 62));
  const Dynamics::Report report = dynamics.step(0.01, {}, {}, {}, 1e-12, 2);
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.iterations, 2);
  EXPECT_GT(report.relative_residual, 1e-12);
  EXPECT_GT(largest(dynamics.velocities()), 0.0);
}

/// State, velocity changes included, carried to a second Dynamics continues in the same bits.
TEST(DynamicsArguments, TheStateIsAllThatAStepDependsOn) {
  const Bodies bodies = single_body(irregular_box_mesh({3, 3, 3}, {0.3, 0.3, 0.3}, 0.2));
  Dynamics first = small_dynamics(bodies);
  first.set_positions(noisy(bodies, 0.02, 63));
  for (int i = 0; i < 5; ++i) first.step(0.01, {0.0, 0.0, -9.81}, {}, {}, 1e-4, 50);
  Dynamics second = small_dynamics(bodies);
  second.set_positions(first.positions());
  second.set_velocities(first.velocities());
  second.set_velocity_changes(first.velocity_changes());
  for (int i = 0; i < 5; ++i) {
    first.step(0.01, {0.0, 0.0, -9.81}, {}, {}, 1e-4, 50);
    second.step(0.01, {0.0, 0.0, -9.81}, {}, {}, 1e-4, 50);
  }
  EXPECT_TRUE(std::ranges::equal(first.positions(), second.positions()));
  EXPECT_TRUE(std::ranges::equal(first.velocities(), second.velocities()));
}

}  // namespace
}  // namespace palpate::fem::test
