// Stages that a page watches. Oracle: the same stages led by hand, without a viewer.
#include <algorithm>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "scene/stage_run.hpp"
#include "view/frame.hpp"
#include "view/live.hpp"
#include "view/messages.hpp"
#include "view/scenes.hpp"

namespace palpate::view {
namespace {

/// A box falls onto a plate. The press comes in, moves to the side, and is released; then the box is removed.
Scene staged_scene() {
  return read_scene_text(R"({"name": "staged", "time_step": 0.01, "contact": {"friction": 0.3}, "bodies": [
    {"name": "plate", "box": {"cells": [2, 2, 1], "size": [0.2, 0.2, 0.02]}, "translate": [0, 0, -0.01], "obstacle": true},
    {"name": "box", "box": {"cells": [3, 3, 3], "size": [0.06, 0.06, 0.06]}, "translate": [0.003, 0.002, 0.0299],
     "material": {"young_modulus": 20000, "mass_damping": 1, "stiffness_damping": 0.002}},
    {"name": "press", "box": {"cells": [1, 1, 1], "size": [0.03, 0.03, 0.03]}, "translate": [0.07, 0, 0.05],
     "obstacle": true, "absent": true, "material": {"young_modulus": 50000}}],
    "stages": [
      {"name": "fall", "until": {"time": 0.05}},
      {"name": "enter", "insert": ["press"], "gravity": [0, 0, -5], "until": {"time": 0.1},
       "move": [{"body": "press", "motion": {"keyframes": [{"time": 0.1, "translate": [0.01, 0, 0]}]}}]},
      {"name": "free", "release": [{"body": "press"}], "until": {"time": 0.05}},
      {"name": "clear", "remove": ["box"], "until": {"time": 0.05}}]})",
                         "staged");
}

/// The numbers of the first steps of the stages.
constexpr int enter = 5;
constexpr int free_ = 15;
constexpr int clear = 20;
constexpr int end = 25;

LiveSource staged_source() {
  const Scene scene = staged_scene();
  return {scene, test::small_model(scene), 1};
}

Index vertex_of_body(const LiveSource& source, std::size_t body) {
  return Surface(source.bodies()).body_vertices()[body].begin;
}

Vec3 place_of_press(const LiveSource& source) {
  return at(source.positions(), source.bodies().bodies()[2].points.begin);
}

TEST(LiveStages, HaveTheBitsOfARunThatNobodyLooksAt) {
  const Scene scene = staged_scene();
  Simulation led(test::small_model(scene), scene.settings, 1);
  StageRun stages(scene, led);
  LiveSource source = staged_source();
  const Surface surface(source.bodies());
  const auto compare = [&] {
    stages.begin(led);
    for (int step = 0; step < end; ++step) {
      led.step();
      if (stages.ends(led)) stages.begin(led);
      source.advance();
      static_cast<void>(frame_message(source, surface, {true, true, true}, {}));
      ASSERT_EQ(source.simulation().state_hash(), led.state_hash()) << "step " << step;
    }
  };
  compare();
  source.reset();
  led = Simulation(test::small_model(scene), scene.settings, 1);
  stages = StageRun(scene, led);
  compare();
}

TEST(LiveStages, TellThePageWhatTheyAre) {
  LiveSource source = staged_source();
  EXPECT_EQ(source.stage().about["stages"], nlohmann::json({"fall", "enter", "free", "clear"}));
  const test::Read stage = test::read_message(stage_message(source, Surface(source.bodies())));
  EXPECT_EQ(stage.header["bodies"][2]["absent"], true);
  EXPECT_EQ(stage.header["bodies"][1]["absent"], false);
  const auto expect = [&](const char* name, int number, const std::vector<int>& absent,
                          const std::vector<int>& rigid) {
    const auto plan = source.counts()["plan"];
    EXPECT_EQ(plan["stage"], name);
    EXPECT_EQ(plan["number"], number);
    EXPECT_EQ(plan["absent"], nlohmann::json(absent)) << name;
    EXPECT_EQ(plan["rigid"], nlohmann::json(rigid)) << name;
    EXPECT_EQ(plan["done"], false);
  };
  expect("fall", 1, {2}, {0, 2});
  test::run(source, enter);
  expect("enter", 2, {}, {0, 2});
  test::run(source, free_ - enter);
  expect("free", 3, {}, {0});
  test::run(source, clear - free_);
  expect("clear", 4, {1}, {0});
  EXPECT_EQ(source.begun_stages(), 4U);
  test::run(source, end - clear);
  EXPECT_EQ(source.counts()["plan"]["done"], true);
  test::run(source, 3);
  EXPECT_EQ(source.counts()["step"], end + 3) << "it continues";
  EXPECT_FALSE(test::small_source()->counts().contains("plan")) << "a scene without stages";
}

TEST(LiveStages, PullsFollowThem) {
  LiveSource source = staged_source();
  const Index box = vertex_of_body(source, 1);
  const Index press = vertex_of_body(source, 2);
  EXPECT_THROW(source.apply(1, Pull{press, {}, 1.0}), Error) << "absent";
  test::run(source, enter);
  EXPECT_THROW(source.apply(1, Pull{press, {}, 1.0}), Error) << "moved";
  test::run(source, free_ - enter);
  const Vec3 place = place_of_press(source);
  source.apply(1, Pull{press, place - source.stage().origin + Vec3{0.1, 0, 0}, 1.0});
  source.apply(2, Pull{box, {}, 1.0});
  const double most = source.counts()["pulls"][0]["most"];
  const double mass = source.simulation().masses()[2];
  const double edge = mesh_statistics(source.bodies(), source.bodies().points_rest(), 2).edge_length.mean;
  EXPECT_LE(most, 0.2 * mass * edge / (0.01 * 0.01) * 1.001) << "it is free now, and must not be thrown";
  EXPECT_GT(most, 0.0);
  test::run(source, clear - free_);
  const auto pulls = source.counts()["pulls"];
  ASSERT_EQ(pulls.size(), 1U) << "that of the removed box has ended";
  EXPECT_EQ(pulls[0]["client"], 1);
  EXPECT_GT(place_of_press(source).x, place.x);
  EXPECT_NO_THROW(source.apply(2, MovePull{{1, 1, 1}}));
}

TEST(LiveStages, AHandMovesABodyAlongTheMotionOfItsStage) {
  LiveSource source = staged_source();
  EXPECT_EQ(source.stage().about["motions"][0]["body"], 2);
  EXPECT_EQ(source.counts()["driven"][0]["moves"], false);
  EXPECT_THROW(source.apply(1, DriveMotion{0, {}, Vec3{0, 0.01, 0}}), Error);
  test::run(source, enter);
  const auto driven = source.counts()["driven"][0];
  EXPECT_EQ(driven["moves"], true);
  EXPECT_NEAR(driven["begin"], 0.05, 1e-12);
  EXPECT_NEAR(driven["end"], 0.15, 1e-12);
  const Vec3 start = place_of_press(source);
  source.apply(1, DriveMotion{0, 0.1, Vec3{0, 0.01, 0}});
  test::run(source, free_ - enter - 1);
  EXPECT_NEAR(place_of_press(source).y - start.y, 0.01, 1e-12);
  EXPECT_NEAR(place_of_press(source).x - start.x, 0.005, 1e-12) << "half of its path";
  EXPECT_TRUE(source.counts()["driven"][0].contains("force"));
  EXPECT_TRUE(source.forces()[2].contains("held"));
  test::run(source, 1);
  EXPECT_EQ(source.counts()["driven"][0]["moves"], false) << "released";
  EXPECT_EQ(source.counts()["driven"][0]["held"], false);
  EXPECT_THROW(source.apply(1, DriveMotion{0, {}, Vec3{}}), Error);
  test::run(source, 1);
  EXPECT_FALSE(source.forces()[2].contains("held"));
}

TEST(LiveStages, GravityOfAPageLastsUntilAStageSetsAnother) {
  LiveSource source = staged_source();
  source.apply(1, Change{{{"gravity", {0, 0, -1}}}});
  test::run(source, enter);
  EXPECT_EQ(source.settings()["gravity"], nlohmann::json({0.0, 0.0, -5.0}));
  source.apply(1, Change{{{"gravity", {0, 0, -2}}}});
  test::run(source, clear - enter);
  EXPECT_EQ(source.settings()["gravity"], nlohmann::json({0.0, 0.0, -2.0})) << "later stages set none";
  source.reset();
  EXPECT_EQ(source.settings()["gravity"], nlohmann::json({0.0, 0.0, -1.0}));
}

}  // namespace
}  // namespace palpate::view
