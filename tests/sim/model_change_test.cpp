// Constraints of bodies change between steps. Oracles: the formulas of implicit Euler, Newton, and the run
// without a change.
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <string>

#include <palpate/error.hpp>
#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "sim/examples.hpp"
#include "support/mean.hpp"
#include "support/meshes.hpp"

namespace palpate::test {
namespace {

constexpr double h = 0.01;
constexpr double g = 9.81;

/// A table, and a block whose underside is at this height.
Model block_over_table(double height) {
  Model model;
  model.bodies.add("table", box_mesh({2, 2, 1}, {-0.1, -0.1, -0.02}, {0.1, 0.1, 0.0}));
  model.bodies.add("block", box_mesh({2, 2, 2}, {-0.05, -0.05, height}, {0.05, 0.05, height + 0.1}));
  model.materials = {{.young_modulus = 1e6}, {.young_modulus = 1e5, .stiffness_damping = 0.01}};
  model.obstacles = {1, 0};
  return model;
}

SimulationSettings settings_of(double gravity = -g) {
  SimulationSettings settings;
  settings.time_step = h;
  settings.gravity = {0.0, 0.0, gravity};
  return settings;
}

std::vector<Index> all_points(const Simulation& s, Index body) {
  const Range range = at(s.bodies().bodies(), body).points;
  std::vector<Index> points;
  for (Index p = range.begin; p < range.end; ++p) points.push_back(p);
  return points;
}

Vec3 mean(const Simulation& s, Index body) {
  return mean_of_body(s.bodies(), body, s.positions());
}

void steps(Simulation& s, int count) {
  for (int i = 0; i < count; ++i) s.step();
}

std::string error_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// x += h v with v -= h g in each of n steps.
double fall(int n, double v = 0.0) {
  return n * h * v - 0.5 * g * h * h * n * (n + 1);
}

TEST(ModelChange, OfNothingLeavesTheBits) {
  for (const char* name : {"everything", "tower", "plastic", "belt"}) {
    const Scene scene = example(name);
    Simulation whole = simulate(scene, 2);
    Simulation other = simulate(scene, 1);
    steps(whole, 40);
    steps(other, 40);
    other.change(ModelChange{});
    EXPECT_EQ(other.state_hash(), whole.state_hash());
    steps(whole, 30);
    steps(other, 30);
    EXPECT_EQ(other.state_hash(), whole.state_hash()) << name;
  }
}

TEST(ModelChange, AReleasedBodyKeepsItsVelocityAndFalls) {
  Model model = block_over_table(1.0);
  model.motions = {{.keyframes = {{.time = 0.0}, {.time = 0.1, .translate = {0.02, 0.0, 0.03}}}}};
  model.motion_of_point.assign(model.bodies.points_rest().size(), -1);
  for (Index p = model.bodies.bodies()[1].points.begin; p < model.bodies.bodies()[1].points.end; ++p)
    at(model.motion_of_point, p) = 0;
  for (const bool rigid : {false, true}) {
    Model one = model;
    if (rigid) one.obstacles = {1, 1};
    Simulation s(std::move(one), settings_of(), 2);
    steps(s, 5);
    const Vec3 before = mean(s, 1);
    s.change({.release_bodies = {1}});
    EXPECT_EQ(mean(s, 1), before);
    steps(s, 10);
    const Vec3 moved = mean(s, 1) - before;
    EXPECT_NEAR(moved.x, 10 * h * 0.2, 1e-7) << "it continues as it was moved";
    EXPECT_NEAR(moved.z, fall(10, 0.3), 1e-6);
    EXPECT_EQ(s.metrics().inverted_tets, 0);
  }
}

TEST(ModelChange, ARemovedTableHoldsNothingAndComesBack) {
  Simulation s(block_over_table(0.0), settings_of(), 2);
  for (int i = 0; i < 300 && !s.at_rest(); ++i) s.step();
  ASSERT_TRUE(s.at_rest());
  EXPECT_NEAR(s.contact_forces()[1].z, at(s.masses(), 1) * g, 1e-3 * at(s.masses(), 1) * g) << "its weight";
  const double high = mean(s, 1).z;
  s.change({.remove = {0}});
  EXPECT_FALSE(s.is_present(0));
  EXPECT_EQ(s.metrics().detection.contacts, 0U);
  steps(s, 3);
  EXPECT_NEAR(mean(s, 1).z - high, fall(3), 0.02 * std::abs(fall(3))) << "nothing holds it";
  EXPECT_EQ(s.contact_forces()[1], Vec3{});
  s.change({.insert = {0}});
  EXPECT_TRUE(s.is_present(0));
  EXPECT_GT(s.metrics().detection.contacts, 0U) << "it fell into where the table is";
  for (int i = 0; i < 400 && !s.at_rest(); ++i) s.step();
  EXPECT_TRUE(s.at_rest());
  EXPECT_NEAR(mean(s, 1).z, high, 1e-4);
}

TEST(ModelChange, ABodyThatIsAbsentAtFirstTouchesNothing) {
  Model model = block_over_table(-0.01);  // overlaps
  model.absent = {1, 0};
  Simulation s(std::move(model), settings_of(), 2);
  EXPECT_EQ(s.metrics().detection.contacts, 0U);
  steps(s, 5);
  EXPECT_NEAR(mean(s, 1).z, 0.04 + fall(5), 1e-9);
  s.change({.insert = {0}});
  EXPECT_GT(s.metrics().detection.contacts, 0U);
}

/// Stresses of Maxwell elements stay with their bodies when another one comes between them.
TEST(ModelChange, ViscousTissueGoesOnAsItWas) {
  Model model;
  for (const double x : {0.0, 1.0, 2.0})
    model.bodies.add("block", box_mesh({2, 2, 2}, {x, 0.0, 0.0}, {x + 0.1, 0.1, 0.1}));
  Material tissue{.young_modulus = 1e4, .viscosity = {.fractions = {0.5}, .times = {0.1}}};
  model.materials.assign(3, tissue);
  model.materials[2].elements = ElementKind::smoothed;
  for (const Vec3& p : model.bodies.points_rest()) model.velocities.push_back({p.y, 0.0, 2.0 * p.z});
  model.absent = {0, 1, 0};
  SimulationSettings settings = settings_of(0.0);
  settings.solver.tolerance = 1e-9;
  Simulation alone(Model(model), settings, 1);
  Simulation joined(std::move(model), settings, 1);
  steps(alone, 5);
  steps(joined, 5);
  joined.change({.insert = {1}});
  steps(alone, 5);
  steps(joined, 5);
  double moved = 0.0;
  for (const Index body : {0, 2}) {
    for (const Index p : all_points(alone, body)) {
      EXPECT_LT(length(at(alone.positions(), p) - at(joined.positions(), p)), 1e-9) << body;
      moved = std::max(moved, length(at(alone.velocities(), p)));
    }
  }
  EXPECT_GT(moved, 0.01);
}

TEST(ModelChange, FixedPointsStayToTheBit) {
  Simulation s(block_over_table(0.5), settings_of(), 2);
  steps(s, 5);
  s.record_reactions(true);
  s.change({.fix = all_points(s, 1)});
  const std::vector<Vec3> before(s.positions().begin(), s.positions().end());
  steps(s, 5);
  EXPECT_TRUE(std::ranges::equal(s.positions(), before));
  EXPECT_NEAR(s.reaction_of_body(1, {}).force.z, at(s.masses(), 1) * g, 1e-6) << "what holds its weight";
}

TEST(ModelChange, MovedPointsGoFromWhereTheyAre) {
  Simulation s(block_over_table(0.5), settings_of(), 2);
  steps(s, 5);
  const Vec3 before = mean(s, 1);
  const double now = s.metrics().time;
  s.change({.moves = {{all_points(s, 1), {.keyframes = {{.time = now}, {now + 0.1, {0.1, 0.0, 0.0}}}}}}});
  EXPECT_EQ(s.motion_count(), 1);
  EXPECT_EQ(s.motion_of_points().back(), 0);
  steps(s, 10);
  EXPECT_LT(length(mean(s, 1) - before - Vec3{0.1, 0.0, 0.0}), 1e-12);
}

TEST(ModelChange, TiesHoldAWeightUntilTheyAreCut) {
  Model model = block_over_table(0.02);
  model.obstacles = {0, 0};
  model.fixed_points.assign(model.bodies.points_rest().size(), 0);
  for (Index p = 0; p < model.bodies.bodies()[0].points.end; ++p) at(model.fixed_points, p) = 1;
  Simulation s(std::move(model), settings_of(g), 2);  // away from the table
  ModelChange change;
  for (const Index p : all_points(s, 1))
    if (at(s.positions(), p).z < 0.021) change.ties.push_back({.point = p, .tet = 0, .stiffness = 1e4});
  ASSERT_EQ(change.ties.size(), 9U);
  s.change(change);
  EXPECT_EQ(s.ties().size(), 9U);
  steps(s, 300);
  Vec3 sum;
  for (const Vec3& force : s.tie_forces()) sum += force;
  const double weight = at(s.masses(), 1) * g;
  EXPECT_NEAR(sum.z, -weight, 1e-3 * weight);
  const double high = mean(s, 1).z;
  s.change({.untie = {0, 1, 2, 3, 4, 5, 6, 7, 8}});
  EXPECT_TRUE(s.ties().empty());
  steps(s, 5);
  EXPECT_NEAR(mean(s, 1).z - high, -fall(5), 0.05 * std::abs(fall(5)));
}

TEST(ModelChange, LoadsTakeThePlaceOfThoseOfTheBody) {
  Model model = block_over_table(1.0);
  Simulation s(std::move(model), settings_of(0.0), 2);
  const std::vector<Index> points = all_points(s, 1);
  s.set_forces(points, std::vector<Vec3>(points.size(), {0.0, 1.0, 0.0}));
  s.change({.loads = {{.body = 1, .points = {{.points = points, .force = {at(s.masses(), 1), 0.0, 0.0}}}}}});
  steps(s, 10);
  s.change({.loads = {{.body = 1}}});
  steps(s, 5);
  const double v = 10 * h;  // the centre of mass follows Newton
  EXPECT_NEAR(s.center_of_mass(1).x, 0.5 * h * h * 10 * 11 + 5 * h * v, 1e-4);
  EXPECT_NEAR(s.center_of_mass(1).y, 0.0, 1e-6);
}

/// Steps with all kinds of changes among them.
void run_changes(Simulation& s, int from, int to) {
  const std::vector<Index> points = all_points(s, 1);
  for (int i = from; i < to; ++i) {
    if (i == 10) s.change({.moves = {{points, {.keyframes = {{.time = 0.1}, {0.2, {0.0, 0.0, -0.01}}}}}}});
    if (i == 25) s.change({.release_bodies = {0, 1}, .fix = {0, 1, 2, 3, 4, 5, 6, 7, 8}});
    if (i == 40) s.change({.ties = {{.point = points.front(), .tet = 3}}, .loads = {{.body = 0}}});
    s.step();
  }
}

TEST(ModelChange, IsInASavedState) {
  for (const int at_step : {0, 10, 12, 30, 41}) {
    Simulation whole(block_over_table(0.004), settings_of(), 2);
    run_changes(whole, 0, at_step);
    const auto saved = whole.save();
    run_changes(whole, at_step, 60);
    Simulation resumed(block_over_table(0.004), settings_of(), 1);
    resumed.restore(saved);
    EXPECT_EQ(resumed.save(), saved);
    run_changes(resumed, at_step, 60);
    EXPECT_EQ(resumed.save(), whole.save()) << "saved at " << at_step;
    Simulation back(block_over_table(0.004), settings_of(), 1);
    const auto start = back.save();
    run_changes(back, 0, 45);
    back.restore(start);
    EXPECT_EQ(back.save(), start) << "held as at the start again";
    run_changes(back, 0, 60);
    EXPECT_EQ(back.save(), whole.save());
  }
}

TEST(ModelChange, IsRefusedWhereThereIsNothingToChange) {
  Simulation s(block_over_table(0.004), settings_of(), 2);
  steps(s, 3);
  const auto before = s.save();
  const auto refused = [&](const ModelChange& change) { return error_of([&] { s.change(change); }); };
  EXPECT_EQ(refused({.insert = {0}}),
            "model change: insert: found 'table', which is in the simulation already, expected a body that "
            "was removed, or absent at the start");
  EXPECT_EQ(refused({.remove = {0, 0}}),
            "model change: remove: found 'table', which is not in the simulation now, expected a body "
            "that is in it");
  EXPECT_EQ(refused({.release_bodies = {7}}),
            "model change: release_bodies: found 7, expected an index below 2");
  EXPECT_EQ(refused({.release_points = {0}}),
            "model change: release_points: found a point of the rigid body 'table', expected the whole body, "
            "or points of one that deforms");
  EXPECT_EQ(refused({.moves = {{{}, {.keyframes = {{}}}}}}),
            "model change: moves: found no point, expected one or more points");
  EXPECT_EQ(refused({.moves = {{{1}, {}}}}),
            "motions: [0]: found no keyframe, expected one or more keyframes");
  EXPECT_EQ(refused({.untie = {0}}), "model change: untie: found 0, expected an index below 0");
  EXPECT_NE(refused({.ties = {{.point = 0, .tet = 0}}}), "");
  EXPECT_EQ(
      refused({.loads = {{.body = 1, .points = {{.points = {0}, .force = {}}}}}}),
      "model change: loads: found a load without points of 'block', expected one or more of its points");
  EXPECT_EQ(s.save(), before);
}

}  // namespace
}  // namespace palpate::test
