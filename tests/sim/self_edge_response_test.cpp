// Oracles: the same parts as two bodies; where bodies rest by hand; conservation of momentum; a run that was
// not interrupted.
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <utility>
#include <vector>

#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "sim/exact_runs.hpp"
#include "support/crossed_arms.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

SimulationSettings settings_for(bool self_collision) {
  SimulationSettings settings;
  settings.detection.edge_contacts = true;
  if (self_collision) settings.detection.self_collision = {1};
  settings.time_step = 0.005;
  settings.response.friction = 0.5;
  return settings;
}

/// Two bars that cross, as two bodies or as two parts of one; all points of the lower one are fixed.
Simulation crossed_bars(int cells, bool as_one, bool self_collision) {
  const Vec3 middle{0.003, 0.001, 0.03};
  const TetMesh lower = test::box_mesh({cells, 1, 1}, {-0.1, -0.01, -0.01}, {0.1, 0.01, 0.01});
  const TetMesh upper =
      test::box_mesh({1, cells, 1}, middle - Vec3{0.01, 0.1, 0.01}, middle + Vec3{0.01, 0.1, 0.01});
  Model model;
  const std::size_t fixed = lower.points.size();
  model.bodies.add("lower", as_one ? test::joined(lower, upper) : lower);
  if (!as_one) model.bodies.add("upper", upper);
  model.materials.assign(as_one ? 1 : 2, Material{.young_modulus = 1e7});
  model.fixed_points.assign(model.bodies.points_rest().size(), 0);
  std::fill_n(model.fixed_points.begin(), fixed, std::uint8_t{1});
  return {std::move(model), settings_for(self_collision), 2};
}

/// Mean of the points above the lower bar, which come last.
Vec3 middle_of_upper(const Simulation& simulation, int cells) {
  const std::size_t points = 4 * (static_cast<std::size_t>(cells) + 1);
  Vec3 sum;
  for (const Vec3& p : simulation.positions().last(points)) sum += p;
  return (1.0 / static_cast<double>(points)) * sum;
}

TEST(SelfEdgeResponse, PartsThatCrossEdgeOnEdgeRestLikeTwoBodies) {
  for (const int cells : {1, 3, 5}) {
    SCOPED_TRACE(cells);
    Simulation one = crossed_bars(cells, true, true);
    Simulation two = crossed_bars(cells, false, false);
    for (int step = 0; step < 200; ++step) {
      one.step();
      two.step();
    }
    EXPECT_EQ(one.detector().contacts().size(), 0U) << "no point is in the other part";
    EXPECT_GT(one.detector().edge_contacts().size(), 3U);
    EXPECT_EQ(one.metrics().deepest, std::ranges::max(one.detector().edge_contacts().depth));
    EXPECT_NEAR(middle_of_upper(one, cells).z, 0.02, 0.0005);
    EXPECT_LT(length(middle_of_upper(one, cells) - middle_of_upper(two, cells)), 1e-4);
    EXPECT_LT(one.metrics().largest_speed, 5e-3);
  }
}

/// Flush faces of one cell: all points are at rims.
TEST(SelfEdgeResponse, ABoxOnABoxOfTheSameBodyRests) {
  for (const double offset : {0.0, 1e-3, 5e-3}) {
    const TetMesh low = test::box_mesh({1, 1, 1}, {-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05});
    TetMesh high = low;
    for (Vec3& p : high.points) p += Vec3{offset, 0.5 * offset, 0.1005};
    Model model;
    model.bodies.add("both", test::joined(low, high));
    model.materials.assign(1, Material{.young_modulus = 1e7});
    model.fixed_points.assign(16, 0);
    std::fill_n(model.fixed_points.begin(), 8, std::uint8_t{1});
    Simulation simulation(std::move(model), settings_for(true), 2);
    for (int step = 0; step < 100; ++step) simulation.step();
    EXPECT_NEAR(middle_of_upper(simulation, 1).z, 0.1, 0.001) << offset;
    EXPECT_LT(simulation.metrics().largest_speed, 5e-3);
  }
}

TEST(SelfEdgeResponse, WithoutSelfCollisionAPartFallsThrough) {
  Simulation simulation = crossed_bars(1, true, false);
  for (int step = 0; step < 60; ++step) simulation.step();
  EXPECT_LT(middle_of_upper(simulation, 1).z, -0.1);
}

/// A soft bar whose upper arm sags onto the lower one, which is fixed.
Simulation sagging_arms(double gap, bool edge_contacts, int threads) {
  Model model;
  model.bodies.add("bar", test::crossed_arms(gap));
  model.materials.assign(1, Material{.young_modulus = 4e5, .mass_damping = 10.0});
  model.fixed_points.assign(model.bodies.points_rest().size(), 0);
  for (std::size_t p = 0; p < model.fixed_points.size(); ++p) {
    const Vec3& x = model.bodies.points_rest()[p];
    model.fixed_points[p] = x.y < 0.03 && std::abs(x.z) < 0.0101 ? 1 : 0;
  }
  SimulationSettings settings = settings_for(true);
  settings.detection.edge_contacts = edge_contacts;
  return {std::move(model), settings, threads};
}

/// Centre of the section of the upper arm at `y` at rest.
Vec3 section(const Simulation& simulation, double y) {
  Vec3 sum;
  int points = 0;
  for (std::size_t p = 0; p < simulation.positions().size(); ++p) {
    const Vec3& rest = simulation.bodies().points_rest()[p];
    if (std::abs(rest.y - y) > 0.001 || std::abs(rest.x) > 0.03 || simulation.free_points()[p] == 0) continue;
    sum += simulation.positions()[p];
    ++points;
  }
  EXPECT_EQ(points, 4);
  return (1.0 / points) * sum;
}

/// Height of the middle of the upper arm over the middle of the lower one.
double height_of_crossing(const Simulation& simulation) {
  const Vec3 a = section(simulation, 0.02);
  const Vec3 b = section(simulation, -0.03);
  return a.z + a.y / (a.y - b.y) * (b.z - a.z);
}

TEST(SelfEdgeResponse, AnArmThatSagsOntoTheOtherArmOfItsBarRests) {
  Simulation with = sagging_arms(0.002, true, 2);
  Simulation without = sagging_arms(0.002, false, 2);
  for (int step = 0; step < 200; ++step) {
    with.step();
    without.step();
  }
  EXPECT_NEAR(height_of_crossing(with), 0.021, 0.001) << "a little askew";
  EXPECT_GT(with.detector().edge_contacts().size(), 1U);
  EXPECT_LT(with.metrics().largest_speed, 5e-3);
  EXPECT_LT(height_of_crossing(without), 0.01) << "contacts of points alone do not hold it";
}

TEST(SelfEdgeResponse, ForcesAddUpToZeroAndPushTheArmsApart) {
  Model model;
  model.bodies.add("bar", test::crossed_arms(-0.0005));
  model.materials.assign(1, Material{.young_modulus = 1e6});
  SimulationSettings settings = settings_for(true);
  settings.gravity = {};
  Simulation simulation(std::move(model), settings, 1);
  simulation.step();
  const ContactForces forces = simulation.acting_contacts();
  ASSERT_GT(forces.size(), 0U);
  EXPECT_TRUE(std::ranges::all_of(forces.edge, [](Index edge) { return edge >= 0; }));
  double sum = 0.0;
  for (std::size_t c = 0; c < forces.size(); ++c) sum += length(forces.force(c));
  EXPECT_LT(length(simulation.contact_forces()[0]), 1e-12 * sum) << "forces within a body";
  for (int step = 0; step < 40; ++step) simulation.step();
  EXPECT_LT(simulation.metrics().deepest, 1e-4);
  Vec3 momentum;
  double largest = 0.0;
  for (std::size_t p = 0; p < simulation.positions().size(); ++p) {
    momentum += simulation.point_masses()[p] * simulation.velocities()[p];
    largest = std::max(largest, simulation.point_masses()[p] * length(simulation.velocities()[p]));
  }
  EXPECT_LT(length(momentum), 2e-2 * largest) << "the tolerance of the solver";
}

TEST(SelfEdgeResponse, ARunGoesOnFromASavedStateToTheBitWithAnyThreads) {
  Simulation whole = sagging_arms(0.0005, true, 1);
  for (int step = 0; step < 25; ++step) whole.step();
  EXPECT_GT(whole.acting_contacts().size(), 0U);
  const std::vector<std::byte> saved = whole.save();
  for (int step = 0; step < 30; ++step) whole.step();
  Simulation resumed = sagging_arms(0.0005, true, 3);
  resumed.restore(saved);
  for (int step = 0; step < 30; ++step) resumed.step();
  EXPECT_EQ(resumed.state_hash(), whole.state_hash());
}

}  // namespace
}  // namespace palpate
