// No body passes through another. Oracle: the inner parts of two bodies never cross, sampled densely in time.
#include <filesystem>
#include <gtest/gtest.h>
#include <optional>
#include <string>

#include <palpate/error.hpp>

#include "scene/load.hpp"
#include "scene/scene.hpp"
#include "sim/shots.hpp"
#include "sim/unseen_passes.hpp"
#include "support/mean.hpp"

namespace palpate {
namespace {

Simulation simulate(Scene scene, ContinuousDetection continuous, int threads = 2) {
  scene.settings.detection.continuous = continuous;
  Model model = load_model(scene, [](const std::filesystem::path& path) -> TetMesh {
    throw Error(path.string(), "", "a mesh file", "none");
  });
  return Simulation(std::move(model), scene.settings, threads);
}

double lowest(const Simulation& simulation, Index body) {
  double z = 1e300;
  const Range& points = at(simulation.bodies().bodies(), body).points;
  for (Index p = points.begin; p < points.end; ++p) z = std::min(z, at(simulation.positions(), p).z);
  return z;
}

constexpr const char* sheet_on_plate =
    R"({"time_step": 0.01, "duration": 0.4, "gravity": [0, 0, 0], "bodies": [
  {"name": "plate", "box": {"cells": [8, 8, 1], "size": [0.2, 0.2, 0.002]}, "translate": [0.003, 0.002, 0], "obstacle": true},
  {"name": "sheet", "box": {"cells": [6, 6, 1], "size": [0.1, 0.1, 0.002]}, "translate": [0, 0, 0.0218],
   "velocity": [0, 0, -0.6], "material": {}}]})";

TEST(Swept, ASheetAtThreeThicknessesAStepStopsAtAPlate) {
  const Scene scene = read_scene_text(sheet_on_plate, "sheet");
  Simulation off = simulate(scene, ContinuousDetection::off);
  while (off.metrics().time < 0.4 - 1e-9) off.step();
  EXPECT_LT(lowest(off, 1), -0.1) << "it must take a continuous detection";
  Simulation on = simulate(scene, ContinuousDetection::limited);
  std::int64_t stopped = 0;
  while (on.metrics().time < 0.4 - 1e-9) {
    const StepMetrics& m = on.step();
    stopped += m.stopped_passes;
    EXPECT_EQ(m.passes, 0);
    ASSERT_GT(lowest(on, 1), 0.001 - 0.1 * 0.002) << "step " << m.step;
  }
  EXPECT_GT(stopped, 0);
}

// All layers fall by their thickness in a step. The obstacle stops the first one, on which the second one
// must be stopped then, and so on. Once the limit of stops ended this: two lay in one place, at rest.
TEST(Swept, LayersThatFallByTheirThicknessInAStepStayApart) {
  constexpr double thick = 0.001;
  constexpr int layers = 4;
  std::string text = R"({"time_step": 0.01, "duration": 0.3, "bodies": [
  {"name": "floor", "box": {"cells": [5, 5, 1], "size": [0.15, 0.15, 0.02]}, "translate": [0, 0, -0.01], "obstacle": true})";
  for (int i = 0; i < layers; ++i) {
    const std::string z = std::to_string(thick * (1.005 * i + 0.5));
    text +=
        R"(, {"name": "layer)" + std::to_string(i) +
        R"(", "box": {"cells": [6, 6, 1], "size": [0.06, 0.06, 0.001]}, "material": {"young_modulus": 3e4},
      "translate": [)" +
        std::to_string(0.003 * (i % 2)) + ", " + std::to_string(0.002 * (i % 3)) + ", " + z + "]}";
  }
  Simulation simulation = simulate(read_scene_text(text + "]}", "layers"), ContinuousDetection::limited);
  while (simulation.metrics().time < 0.3 - 1e-9) {
    EXPECT_EQ(simulation.step().passes, 0) << "step " << simulation.metrics().step;
  }
  for (Index i = 0; i < layers; ++i) {
    const double z = test::mean_of_body(simulation.bodies(), 1 + i, simulation.positions()).z;
    EXPECT_NEAR(z / thick, i + 0.5, 0.1) << "layer " << i;
  }
}

// A load would move a block through the plate below it in one step, and there is a small gap at the start.
// Each step predicts that the block goes through. Its stops must hand it over to contacts: once they kept it
// at a distance for good, and threw it when it was pushed sideways. Oracles: the load, and Coulomb's law.
TEST(Swept, WhatALoadPressesRestsOnContactsAndSticks) {
  constexpr double load = 5e4;
  constexpr double weight = 9.81 * 1000.0 * 0.05 * 0.05 * 0.03;
  for (const double gap : {1e-5, 1e-3}) {
    SCOPED_TRACE("gap " + std::to_string(gap));
    const std::string text = R"({"time_step": 0.01, "duration": 0.6, "contact": {"friction": 0.5}, "bodies": [
  {"name": "plate", "box": {"cells": [4, 4, 2], "size": [0.16, 0.16, 0.03]}, "translate": [0, 0, -0.015], "obstacle": true},
  {"name": "block", "box": {"cells": [3, 3, 2], "size": [0.05, 0.05, 0.03]}, "translate": [0, 0, )" +
                             std::to_string(0.015 + gap) +
                             R"(], "material": {"young_modulus": 1e6, "poisson_ratio": 0.3},
   "loads": [
    {"box": {"lower": [-1, -1, 0.029], "upper": [1, 1, 1]}, "traction": [0, 0, -5e4]},
    {"box": {"lower": [-1, -1, -1], "upper": [1, 1, 0.002]}, "traction": [1e4, 0, 0],
     "ramp": {"times": [0.2, 0.3], "factors": [0, 1]}}]}]})";
    Simulation simulation = simulate(read_scene_text(text, "pressed"), ContinuousDetection::limited);
    const Vec3 start = test::mean_of_body(simulation.bodies(), 1, simulation.positions());
    while (simulation.metrics().time < 0.6 - 1e-9) {
      const StepMetrics& m = simulation.step();
      EXPECT_TRUE(m.solver_converged);
      EXPECT_TRUE(m.stopped_passes == 0 || m.time < 0.15) << "step " << m.step;
    }
    const Vec3 end = test::mean_of_body(simulation.bodies(), 1, simulation.positions());
    EXPECT_NEAR(end.x, start.x, 3e-4) << "sheared by 0.2 of the load";
    EXPECT_NEAR(lowest(simulation, 1), 0.0, 1e-4);
    const Vec3 force = simulation.contact_forces()[1];
    EXPECT_NEAR(force.z, load * 0.05 * 0.05 + weight, 0.1);
    EXPECT_NEAR(force.x, -0.2 * load * 0.05 * 0.05, 0.1);
    EXPECT_TRUE(simulation.at_rest());
  }
}

TEST(Swept, AThinSheetUnderALoadRestsOnAThickFloor) {
  const std::string text = R"({"time_step": 0.01, "duration": 1, "bodies": [
  {"name": "floor", "box": {"cells": [8, 8, 1], "size": [0.5, 0.5, 0.05]}, "translate": [0, 0, -0.025], "obstacle": true},
  {"name": "sheet", "box": {"cells": [6, 6, 1], "size": [0.06, 0.06, 0.001]}, "translate": [0.0031, 0.0017, 0.00051],
   "material": {"young_modulus": 1e6, "poisson_ratio": 0.3},
   "loads": [{"box": {"lower": [-1, -1, 0.0008], "upper": [1, 1, 1]}, "traction": [0, 0, -1e3]}]}]})";
  Simulation simulation = simulate(read_scene_text(text, "sheet"), ContinuousDetection::limited);
  while (simulation.metrics().time < 1.0 - 1e-9) simulation.step();
  EXPECT_NEAR(lowest(simulation, 1), 0.0, 1e-5) << "it was 1 mm above: 2 % of the floor's thickness";
  EXPECT_EQ(simulation.metrics().stopped_passes, 0);
  EXPECT_TRUE(simulation.at_rest());
}

// A step in which something passes is made with implicit Euler, the others with BDF2.
TEST(Swept, ASheetStopsAtAPlateWithBdf2Too) {
  Scene scene = read_scene_text(sheet_on_plate, "sheet");
  scene.settings.time_integration = TimeIntegration::bdf2;
  Simulation simulation = simulate(scene, ContinuousDetection::limited);
  std::int64_t stopped = 0;
  int second_order = 0;
  while (simulation.metrics().time < 0.4 - 1e-9) {
    const StepMetrics& m = simulation.step();
    stopped += m.stopped_passes;
    second_order += m.order == 2 ? 1 : 0;
    EXPECT_TRUE(m.stopped_passes == 0 || m.order == 1) << "step " << m.step;
    EXPECT_EQ(m.passes, 0);
    ASSERT_GT(lowest(simulation, 1), 0.001 - 0.1 * 0.002) << "step " << m.step;
  }
  EXPECT_GT(stopped, 0);
  EXPECT_GT(second_order, 0);
}

TEST(Swept, WithoutItPairsThatCouldPassAreCounted) {
  Simulation off = simulate(read_scene_text(sheet_on_plate, "sheet"), ContinuousDetection::off);
  std::int64_t pairs = 0;
  for (int i = 0; i < 10; ++i) {
    pairs += off.step().pairs_that_could_pass;
    EXPECT_EQ(off.metrics().stopped_passes, 0);
    if (off.metrics().pairs_that_could_pass == 0) continue;
    EXPECT_NEAR(off.metrics().thinnest, 0.002, 1e-9);
  }
  EXPECT_GT(pairs, 0);
}

// Two soft balls crush each other: hundreds of points pass in a step, more than a limited search stops.
// Solves with a fixed number of iterations do not converge, and keep their stops.
TEST(Swept, ALimitedSearchStopsMostPassesOfTwoCrushedBallsAndCountsTheOthers) {
  for (const std::optional<int> iterations : {std::optional<int>{}, std::optional{40}}) {
    Scene balls = read_scene_text(
        R"({"time_step": 0.01, "gravity": [0, 0, 0], "bodies": [
      {"name": "lower", "ball": {"radius": 0.05, "resolution": 6}, "material": {"young_modulus": 2e3}},
      {"name": "upper", "ball": {"radius": 0.05, "resolution": 6}, "translate": [0.01, 0.003, 0.12],
       "velocity": [0, 0, -3], "material": {"young_modulus": 2e3}}]})",
        "crushed balls");
    balls.settings.solver.fixed_iterations = iterations;
    Simulation simulation = simulate(std::move(balls), ContinuousDetection::limited);
    std::int64_t stopped = 0;
    std::int64_t passes = 0;
    for (int i = 0; i < 10; ++i) {
      const StepMetrics& m = simulation.step();
      stopped += m.stopped_passes;
      passes += m.passes;
      EXPECT_EQ(may_have_passed(m, ContinuousDetection::limited), m.passes > 0);
    }
    EXPECT_GT(passes, 0);
    EXPECT_GT(stopped, 5 * passes);
  }
}

// A box rests on a floor. Where contacts may be missing, it could sink in unseen, however slowly it moves.
TEST(Swept, WhereContactsMayBeMissingEveryMotionCounts) {
  const auto pairs = [](std::optional<int> cells_per_primitive, std::optional<int> tests) {
    Scene scene = read_scene_text(
        R"({"time_step": 0.01, "bodies": [
      {"name": "floor", "box": {"cells": [4, 4, 1], "size": [0.2, 0.2, 0.02]}, "obstacle": true},
      {"name": "far", "box": {"cells": [1, 1, 1], "size": [0.02, 0.02, 0.02]}, "translate": [1, 0, 1], "material": {}},
      {"name": "box", "box": {"cells": [4, 4, 4], "size": [0.1, 0.1, 0.1]}, "translate": [0.04, 0.04, 0.0601],
       "material": {"young_modulus": 1e5}}]})",
        "resting box");
    scene.settings.detection.cells_per_primitive = cells_per_primitive;
    if (tests) scene.settings.detection.budget = Budget{.tests = tests};
    Simulation simulation = simulate(std::move(scene), ContinuousDetection::limited);
    for (int i = 0; i < 10; ++i) simulation.step();
    EXPECT_EQ(may_have_passed(simulation.metrics(), ContinuousDetection::limited),
              simulation.metrics().pairs_that_could_pass > 0);
    return simulation.metrics().pairs_that_could_pass;
  };
  EXPECT_EQ(pairs({}, {}), 0);
  EXPECT_EQ(pairs(1, {}), 1) << "cells are left out";
  EXPECT_EQ(pairs({}, 1), 1) << "clusters are left out";
  EXPECT_EQ(pairs({}, 1000000), 0) << "nothing is left out";
}

TEST(Swept, StopsHaveTheSameBitsForEveryThreadCountAndAfterARestart) {
  const Scene scene = read_scene_text(sheet_on_plate, "sheet");
  const auto hash = [&](int threads, bool restarts) {
    Simulation simulation = simulate(scene, ContinuousDetection::limited, threads);
    std::int64_t stopped = 0;
    for (int i = 0; i < 12; ++i) {
      stopped += simulation.step().stopped_passes;
      if (!restarts) continue;
      const std::vector<std::byte> saved = simulation.save();
      simulation = simulate(scene, ContinuousDetection::limited, threads);
      simulation.restore(saved);
    }
    EXPECT_GT(stopped, 0);
    return simulation.state_hash();
  };
  const std::string one = hash(1, false);
  for (const int threads : {2, 3, 7}) EXPECT_EQ(hash(threads, false), one) << threads;
  EXPECT_EQ(hash(2, true), one);
}

// In these shots two edges touch so little at the end of a step that their contact has no law in the next
// step, in which they pass.
TEST(Swept, NoShotGoesThroughWhereEdgesJustTouched) {
  for (const std::uint64_t seed : {1000241U, 1001178U, 1001530U, 1001664U, 1002294U, 1002796U, 1003227U}) {
    const test::Shot shot = test::random_shot(seed);
    EXPECT_FALSE(test::shoot(shot, ContinuousDetection::full).went_through) << shot.name;
  }
}

// In these shots bodies overlap a little at the start of a step: a point leaves and enters again through the
// same triangle, or edges slide over each other until one body is inside the other.
TEST(Swept, NoShotGoesThroughWhereBodiesTouchAtTheStart) {
  for (const std::uint64_t seed : {1001220U, 1006531U, 2005677U, 2007091U}) {
    const test::Shot shot = test::random_shot(seed);
    EXPECT_FALSE(test::shoot(shot, ContinuousDetection::full).went_through) << shot.name;
  }
}

// In these shots bodies rotate so fast that the plane of a touch lies on another side at the end of the step.
TEST(Swept, NoShotGoesThroughOrBlowsUpWhereBodiesRotateFast) {
  for (const std::uint64_t seed : {2001265U, 2002003U, 2002078U, 2002757U, 2003276U, 2003290U, 2008445U}) {
    const test::Shot shot = test::random_shot(seed);
    const test::ShotResult result = test::shoot(shot, ContinuousDetection::full);
    EXPECT_FALSE(result.went_through) << shot.name;
    EXPECT_FALSE(result.blew_up) << shot.name;
  }
}

// In these shots about a hundred points and edges or more are stopped in a step, and a limited search ended
// too early: in some, the next searches found a few more; in others, the step did not converge.
TEST(Swept, NoShotGoesThroughALimitedSearchWhereMuchIsStopped) {
  for (const std::uint64_t seed :
       {1000442U, 1000794U, 1001136U, 1002442U, 1005109U, 1006122U, 1006126U, 1007913U, 1009152U, 1009157U}) {
    const test::Shot shot = test::random_shot(seed);
    const test::ShotResult result = test::shoot(shot, ContinuousDetection::limited);
    EXPECT_FALSE(result.went_through) << shot.name;
    EXPECT_GT(result.stopped, 10) << shot.name;
  }
}

// In this shot stops contradict each other: together they would give a point 160 times the speed of the shot.
TEST(Swept, AShotWhoseStopsContradictEachOtherDoesNotBlowUp) {
  const test::Shot shot = test::random_shot(1003880);
  const test::ShotResult result = test::shoot(shot, ContinuousDetection::full);
  EXPECT_FALSE(result.went_through);
  EXPECT_FALSE(result.blew_up);
}

TEST(Swept, NoShotGoesThrough) {
  const test::Shots shots = test::shoot_all(0, 300, ContinuousDetection::full);
  EXPECT_EQ(shots.through, 0);
  EXPECT_EQ(shots.creeps, 0);
  EXPECT_EQ(shots.blown_up, 0);
}

TEST(Swept, NoShotGoesThroughALimitedSearch) {
  const test::Shots shots = test::shoot_all(0, 300, ContinuousDetection::limited);
  EXPECT_EQ(shots.through, 0);
  EXPECT_EQ(shots.creeps, 0);
  EXPECT_EQ(shots.blown_up, 0);
}

}  // namespace
}  // namespace palpate
