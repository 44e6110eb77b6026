// Oracles: poses by hand.
#include "sim/prescribed_motions.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <string>

#include <palpate/error.hpp>
#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"

namespace palpate {
namespace {

const double half = std::sqrt(0.5);

/// A quarter turn about the axis through (1, 0, 0) along z, and up by 2, from time 1 to time 3.
Motion quarter_turn(Interpolation interpolation = Interpolation::linear) {
  return {{1, 0, 0}, {{1.0, {}, {1, 0, 0, 0}}, {3.0, {0, 0, 2}, {half, 0, 0, half}}}, interpolation};
}

Vec3 place(const Motion& motion, const Vec3& start, double time) {
  const std::vector<Index> motion_of_point{-1, 0};
  const std::vector<Vec3> points{{9, 9, 9}, start};
  PrescribedMotions prescribed({motion}, motion_of_point, points);
  EXPECT_EQ(prescribed.points().size(), 1U);
  EXPECT_EQ(prescribed.points()[0], 1);
  return prescribed.positions(parallel::Threads(2), time)[0];
}

void expect_near(const Vec3& found, const Vec3& expected) {
  EXPECT_LT(length(found - expected), 1e-15) << found.x << " " << found.y << " " << found.z;
}

TEST(PrescribedMotions, GoFromKeyframeToKeyframe) {
  const Vec3 p{2, 0, 0};
  expect_near(place(quarter_turn(), p, 0.0), p);
  expect_near(place(quarter_turn(), p, 1.0), p);
  expect_near(place(quarter_turn(), p, 2.0), {1 + half, half, 1});
  const double sixty = std::numbers::pi / 3;
  expect_near(place(quarter_turn(), p, 1.0 + 4.0 / 3.0), {1 + std::cos(sixty), std::sin(sixty), 4.0 / 3.0});
  expect_near(place(quarter_turn(), p, 3.0), {1, 1, 2});
  expect_near(place(quarter_turn(), p, 99.0), {1, 1, 2});
}

TEST(PrescribedMotions, MaySpeedUpAndSlowDown) {
  // A quarter of the time: s^2 (3 - 2 s) = 5/32.
  const double angle = std::numbers::pi / 2 * 5 / 32;
  expect_near(place(quarter_turn(Interpolation::smooth), {2, 0, 0}, 1.5),
              {1 + std::cos(angle), std::sin(angle), 2.0 * 5 / 32});
  expect_near(place(quarter_turn(Interpolation::smooth), {2, 0, 0}, 2.0), {1 + half, half, 1});
}

TEST(PrescribedMotions, TurnTheShorterWayRoundWhateverTheSignAndLengthOfQuaternions) {
  Motion motion = quarter_turn();
  for (double& q : motion.keyframes[1].quaternion) q *= -7.0;
  expect_near(place(motion, {2, 0, 0}, 2.0), {1 + half, half, 1});
}

TEST(PrescribedMotions, KeepDistancesDuringTheMotion) {
  const Vec3 a{0.3, -2, 1};
  const Vec3 b{-4, 0.1, 0.7};
  for (int i = 0; i <= 40; ++i) {
    const double time = 0.1 * i;
    EXPECT_NEAR(length(place(quarter_turn(), a, time) - place(quarter_turn(), b, time)), length(a - b),
                1e-14);
  }
}

TEST(PrescribedMotions, CountInTheSpeedsOfAStep) {
  Model model;
  model.bodies.add("tet", TetMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}});
  model.materials.resize(1);
  model.motions = {{.keyframes = {{.time = 0.0}, {.time = 1.0, .translate = {2.0, 0.0, 0.0}}}}};
  model.motion_of_point.assign(4, 0);
  SimulationSettings settings;
  settings.time_step = 0.01;
  Simulation simulation(std::move(model), settings, 1);
  simulation.step();
  EXPECT_NEAR(simulation.metrics().largest_speed, 2.0, 1e-9);
  EXPECT_NEAR(simulation.metrics().fastest_body, 2.0, 1e-9);
  EXPECT_EQ(simulation.metrics().kinetic_energy, 0.0) << "of points that are free to move";
}

TEST(PrescribedMotions, RefuseBadMotions) {
  const std::vector<Vec3> points(2);
  const auto message = [&](Motion motion, std::vector<Index> motion_of_point) -> std::string {
    try {
      PrescribedMotions({std::move(motion)}, motion_of_point, points);
    } catch (const Error& e) {
      return e.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message(quarter_turn(), {0, -1}), "accepted");
  EXPECT_EQ(message({}, {0, 0}), "motions: [0]: found no keyframe, expected one or more keyframes");
  EXPECT_EQ(message(quarter_turn(), {0, 1}),
            "motions: motion_of_point[1]: found 1, expected less than 1, or -1");
  EXPECT_EQ(message(quarter_turn(), {0}),
            "motions: motion_of_point: found 1 values, expected 2, one for each point");
  Motion late = quarter_turn();
  late.keyframes[1].time = 1.0;
  EXPECT_EQ(message(late, {0, 0}),
            "motions: [0].keyframes[1].time: found 1, expected more than the time before, 1");
  Motion zero = quarter_turn();
  zero.keyframes[0].quaternion = {0, 0, 0, 0};
  EXPECT_EQ(
      message(zero, {0, 0}),
      "motions: [0].keyframes[0]: found a number that is not finite, or a zero quaternion, expected finite "
      "numbers and a quaternion that is not zero");
}

}  // namespace
}  // namespace palpate
