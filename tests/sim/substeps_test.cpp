// Steps that do not converge are divided into substeps.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include <palpate/error.hpp>
#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "sim/shots.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

constexpr double step_length = 0.01;  // s

Simulation shot_simulation(std::uint64_t seed, int max_substeps, int threads = 1) {
  SimulationSettings settings;
  settings.time_step = step_length;
  settings.gravity = {};
  settings.detection.continuous = ContinuousDetection::full;
  settings.solver.max_substeps = max_substeps;
  return {test::random_shot(seed).model, settings, threads};
}

/// A body that forces rotate by 15 degrees in a step, which takes more than one solve.
Simulation turning_ball(double time_step, int max_substeps, int max_solves, double max_speed = 1e3) {
  Model model;
  model.bodies.add("ball", test::ball_mesh(3, {}, 0.03));
  model.materials = {{.young_modulus = 1e7}};
  model.materials[0].viscosity = {.fractions = {0.3}, .times = {0.02}};
  SimulationSettings settings;
  settings.time_step = time_step;
  settings.gravity = {};
  settings.solver.tolerance = 1e-9;
  settings.solver.max_iterations = 3000;
  settings.solver.max_solves = max_solves;
  settings.solver.max_substeps = max_substeps;
  settings.limits.max_speed = max_speed;
  return {std::move(model), settings, 1};
}

void turn(Simulation& simulation, double angular_acceleration) {
  const auto points = static_cast<Index>(simulation.positions().size());
  for (Index p = 0; p < points; ++p) {
    const Vec3 acceleration = cross(Vec3{0, 0, angular_acceleration}, at(simulation.positions(), p));
    simulation.set_force(p, (simulation.masses()[0] / points) * acceleration);
  }
}

/// Counts the steps of a shot that do not converge if they are not divided.
int failed_whole_steps(std::uint64_t seed) {
  Simulation whole = shot_simulation(seed, 1);
  const int steps = test::random_shot(seed).steps;
  int failed = 0;
  for (int i = 0; i < steps; ++i) {
    failed += whole.step().solver_converged ? 0 : 1;
    EXPECT_EQ(whole.metrics().substeps, 1);
  }
  return failed;
}

/// In some shots a small body hits another one and rotates by more than a radian in a step. The first of them
/// are searched, since a change of the solver changes which they are.
TEST(Substeps, ShotsConvergeThatDoNotInWholeSteps) {
  constexpr int wanted = 3;
  int found = 0;
  for (std::uint64_t seed = 1; seed < 3000 && found < wanted; ++seed) {
    if (failed_whole_steps(seed) == 0) continue;
    ++found;
    Simulation divided = shot_simulation(seed, 4);
    const int steps = test::random_shot(seed).steps;
    int most = 0;
    for (int i = 0; i < steps; ++i) {
      const StepMetrics& m = divided.step();
      EXPECT_TRUE(m.solver_converged) << "seed " << seed << ", step " << m.step;
      EXPECT_DOUBLE_EQ(m.time, step_length * static_cast<double>(m.step));
      most = std::max(most, m.substeps);
    }
    EXPECT_GT(most, 1) << "seed " << seed;
    EXPECT_LE(most, 4) << "seed " << seed;
  }
  EXPECT_EQ(found, wanted);
}

/// A body that rotates by more than half a turn is not taken for one that rotates by what is left of whole
/// turns. A needle that a hit had set spinning so reached eight times the speed of the shot.
TEST(Substeps, StepsWithWholeTurnsAreDivided) {
  for (const double angle : {6.3, 7.1}) {
    Model model;
    model.bodies.add("needle", test::box_mesh({6, 1, 1}, {-0.03, -0.001, -0.001}, {0.03, 0.001, 0.001}));
    for (const Vec3& p : model.bodies.points_rest())
      model.velocities.push_back(cross(Vec3{angle / step_length, 0.0, 0.0}, p));
    model.materials = {{.young_modulus = 1e7}};
    SimulationSettings settings;
    settings.time_step = step_length;
    settings.gravity = {};
    Simulation needle(model, settings, 1);
    const double start = needle.metrics().kinetic_energy;
    for (int i = 0; i < 20; ++i) {
      const StepMetrics& m = needle.step();
      EXPECT_EQ(m.substeps, 4);
      EXPECT_TRUE(m.solver_converged);
      EXPECT_LT(m.kinetic_energy + m.elastic_energy, 1.01 * start) << angle << " rad, step " << i;
    }
    EXPECT_GT(needle.metrics().kinetic_energy, 0.9 * start) << angle;
  }
  EXPECT_FALSE(test::shoot(test::random_shot_of_any_tissue(2002003), ContinuousDetection::full).blew_up);
}

/// The halves of a divided step are the two steps of a simulation with half the time step.
TEST(Substeps, HalvesAreStepsOfHalfTheLength) {
  Simulation divided = turning_ball(step_length, 2, 1);
  Simulation whole = turning_ball(step_length, 1, 1);
  Simulation halves = turning_ball(0.5 * step_length, 1, 1);
  for (Simulation* simulation : {&divided, &whole, &halves}) turn(*simulation, 2500.0);
  EXPECT_FALSE(whole.step().solver_converged);
  EXPECT_TRUE(divided.step().solver_converged);
  EXPECT_EQ(divided.metrics().substeps, 2);
  EXPECT_GT(divided.metrics().solves, 2) << "the solve that failed counts, too";
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(halves.step().solver_converged);
  double largest = 0.0;
  for (std::size_t p = 0; p < halves.positions().size(); ++p)
    largest = std::max(largest, length(divided.positions()[p] - halves.positions()[p]));
  EXPECT_LT(largest, 1e-8 * 0.03);
  EXPECT_NEAR(divided.metrics().kinetic_energy, halves.metrics().kinetic_energy,
              1e-6 * halves.metrics().kinetic_energy);
}

TEST(Substeps, HaveTheSameBitsForEveryThreadCountAndAfterARestart) {
  std::uint64_t seed = 1;
  while (seed < 3000 && failed_whole_steps(seed) == 0) ++seed;
  const int steps = test::random_shot(seed).steps;
  const auto hash = [&](int threads, bool restarts) {
    Simulation simulation = shot_simulation(seed, 4, threads);
    int most = 0;
    for (int i = 0; i < steps; ++i) {
      most = std::max(most, simulation.step().substeps);
      if (!restarts) continue;
      const std::vector<std::byte> saved = simulation.save();
      simulation = shot_simulation(seed, 4, threads);
      simulation.restore(saved);
    }
    EXPECT_GT(most, 1);
    return simulation.state_hash();
  };
  const std::string one = hash(1, false);
  EXPECT_EQ(hash(2, false), one);
  EXPECT_EQ(hash(7, false), one);
  EXPECT_EQ(hash(1, true), one);
}

/// The body is too fast only at the end of the last substep, when others are done.
TEST(Substeps, AFailureInALaterSubstepLeavesTheStateBeforeTheStep) {
  constexpr double speed = 2500.0 * step_length * 0.03;  // of the surface after a step
  Simulation fails = turning_ball(step_length, 4, 40, 0.9 * speed);
  Simulation never_failed = turning_ball(step_length, 4, 40, 0.9 * speed);
  turn(fails, 2500.0);
  const std::string before = fails.state_hash();
  EXPECT_THROW(fails.step(), Error);
  EXPECT_EQ(fails.state_hash(), before);
  EXPECT_EQ(fails.metrics().step, 0);
  EXPECT_EQ(fails.metrics().substeps, 1);
  for (Simulation* simulation : {&fails, &never_failed}) {
    turn(*simulation, 100.0);
    for (int i = 0; i < 3; ++i) simulation->step();
  }
  // Not the same bits: what was learned about preconditioners in the failed step is kept.
  for (std::size_t p = 0; p < fails.positions().size(); ++p)
    EXPECT_LT(length(fails.positions()[p] - never_failed.positions()[p]), 1e-8 * 0.03);
}

/// With so few iterations a stiff box hardly moves in the whole step, and more in its parts. If only these
/// are too fast, the step is solved as a whole again.
TEST(Substeps, AStepWhosePartsFailIsAWholeOneThatDidNotConverge) {
  const auto pushed_box = [](int max_substeps, double max_speed) {
    Model model;
    model.bodies.add("box", test::box_mesh({2, 2, 2}, {-0.02, -0.02, -0.02}, {0.02, 0.02, 0.02}));
    model.materials = {{.young_modulus = 1e6}};
    SimulationSettings settings;
    settings.time_step = step_length;
    settings.gravity = {};
    settings.solver.preconditioner = Preconditioner::jacobi;
    settings.solver.max_iterations = 1;
    settings.solver.max_substeps = max_substeps;
    settings.limits.max_speed = max_speed;
    Simulation simulation(std::move(model), settings, 1);
    simulation.set_force(0, {1.0, 2.0, 3.0});
    return simulation;
  };
  Simulation whole = pushed_box(1, 1e3);
  Simulation divided = pushed_box(4, 1e3);
  whole.step();
  divided.step();
  ASSERT_FALSE(whole.metrics().solver_converged);
  ASSERT_EQ(divided.metrics().substeps, 4);
  ASSERT_LT(1.1 * whole.metrics().largest_speed, divided.metrics().largest_speed);
  const double limit = 0.5 * (whole.metrics().largest_speed + divided.metrics().largest_speed);
  Simulation limited = pushed_box(4, limit);
  EXPECT_FALSE(limited.step().solver_converged);
  EXPECT_EQ(limited.metrics().step, 1);
  EXPECT_EQ(limited.metrics().substeps, 1);
  EXPECT_GT(limited.metrics().solves, whole.metrics().solves) << "with the work of the parts";
  EXPECT_EQ(limited.state_hash(), whole.state_hash());
}

/// A motion turns one end of a bar: substeps begin and end where the motion is at their times.
TEST(Substeps, AMotionIsFollowedWithinTheStep) {
  const auto bar = [](double time_step, int max_substeps, int max_solves) {
    Model model;
    model.bodies.add("bar", test::box_mesh({6, 1, 1}, {-0.06, -0.01, -0.01}, {0.06, 0.01, 0.01}));
    model.materials = {{.young_modulus = 1e5}};
    model.materials[0].model = MaterialModel::stable_neo_hookean;
    model.motions.resize(1);
    Keyframe turned;  // by 80 degrees
    turned.time = 0.04;
    turned.quaternion = {std::cos(0.6981317), 0.0, 0.0, std::sin(0.6981317)};
    model.motions[0].keyframes = {Keyframe{}, turned};
    for (const Vec3& p : model.bodies.points_rest()) model.motion_of_point.push_back(p.x < -0.059 ? 0 : -1);
    SimulationSettings settings;
    settings.time_step = time_step;
    settings.gravity = {};
    settings.solver.tolerance = 1e-9;
    settings.solver.max_iterations = 3000;
    settings.solver.max_solves = max_solves;
    settings.solver.max_substeps = max_substeps;
    return Simulation(std::move(model), settings, 1);
  };
  // A step may make fewer solves than it needs; its halves need fewer.
  const int solves = bar(step_length, 1, 40).step().solves - 1;
  Simulation whole = bar(step_length, 1, solves);
  Simulation divided = bar(step_length, 4, solves);
  EXPECT_FALSE(whole.step().solver_converged);
  EXPECT_TRUE(divided.step().solver_converged);
  const int parts = divided.metrics().substeps;
  ASSERT_TRUE(parts == 2 || parts == 4) << "of the same length";
  Simulation shorter = bar(step_length / parts, 1, solves);
  for (int i = 0; i < parts; ++i) ASSERT_TRUE(shorter.step().solver_converged);
  for (std::size_t p = 0; p < divided.positions().size(); ++p)
    EXPECT_LT(length(divided.positions()[p] - shorter.positions()[p]), 1e-7 * 0.12) << p;
}

/// No part is shorter than a third of the step.
TEST(Substeps, NoneIsShorterThanTheSettingAllows) {
  Simulation thirds = turning_ball(step_length, 3, 1);
  turn(thirds, 20000.0);
  EXPECT_EQ(thirds.step().substeps, 2);
  EXPECT_FALSE(thirds.metrics().solver_converged);
}

/// A block slides on a plate, with so few iterations that each step is divided. A state that was saved after
/// one continues with the same bits, also where the slip of friction depends on the length of the last
/// substep.
TEST(Substeps, AStateAfterOneContinuesWithTheSameFriction) {
  const auto sliding_block = [] {
    Model model;
    model.bodies.add("plate", test::box_mesh({8, 8, 1}, {-0.1, -0.1, -0.02}, {0.1, 0.1, 0.0}));
    model.bodies.add("block", test::box_mesh({3, 3, 2}, {-0.031, -0.032, -1e-4}, {0.029, 0.028, 0.04}));
    model.materials = {{.young_modulus = 1e5}, {.young_modulus = 1e5}};
    model.obstacles = {1, 0};
    model.velocities.resize(model.bodies.points_rest().size());
    const Range block = model.bodies.bodies()[1].points;
    for (Index p = block.begin; p < block.end; ++p) at(model.velocities, p) = {0.05, 0.0, 0.0};
    SimulationSettings settings;
    settings.time_step = step_length;
    settings.response.friction = 0.5;
    settings.solver.preconditioner = Preconditioner::jacobi;
    settings.solver.max_iterations = 3;
    return Simulation(std::move(model), settings, 1);
  };
  Simulation simulation = sliding_block();
  Simulation restarted = sliding_block();
  int divided = 0;
  for (int i = 0; i < 8; ++i) {
    const StepMetrics& m = simulation.step();
    restarted.step();
    EXPECT_EQ(restarted.state_hash(), simulation.state_hash()) << "step " << m.step;
    EXPECT_GT(m.detection.contacts, 8U);
    divided += m.substeps > 1 ? 1 : 0;
    const std::vector<std::byte> saved = restarted.save();
    restarted = sliding_block();
    restarted.restore(saved);
  }
  EXPECT_GT(divided, 4);
}

}  // namespace
}  // namespace palpate
