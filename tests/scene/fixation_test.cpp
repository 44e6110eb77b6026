// Points that a scene fixes along axes, and those whose displacement it prescribes. Oracles: by hand.
#include <gtest/gtest.h>
#include <string>

#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "scene/error_check.hpp"
#include "scene/load.hpp"

namespace palpate {
namespace {

Scene box_scene(const std::string& body) {
  return read_scene_text(
      R"({"name": "s", "bodies": [{"material": {}, "box": {"cells": [2, 2, 2], "size": [2, 2, 2]}, )" + body +
          "}]}",
      "s.json", "/base");
}
std::string fixation_problem(const std::string& body) {
  return message_of([&] { load_model(box_scene(body), {}); });
}

TEST(Fixation, OfAxesAddsUpOverSelections) {
  const Model model = load_model(box_scene(R"("fixed": [
    {"box": {"lower": [-1, -1, -1], "upper": [-1, 1, 1]}, "axes": "x"},
    {"box": {"lower": [-1, -1, -1], "upper": [1, 1, -1]}, "axes": "zy"},
    {"box": {"lower": [1, -1, -1], "upper": [1, 1, 1]}}])"),
                                 {});
  const auto rest = model.bodies.points_rest();
  ASSERT_EQ(model.fixed_axes.size(), rest.size());
  for (std::size_t p = 0; p < rest.size(); ++p) {
    EXPECT_EQ(model.fixed_axes[p], (rest[p].x == -1 ? 1 : 0) + (rest[p].z == -1 ? 6 : 0)) << p;
    EXPECT_EQ(model.fixed_points[p], rest[p].x == 1 ? 1 : 0) << p;
  }
}

TEST(Fixation, WithoutAxesIsOfThePoint) {
  EXPECT_TRUE(load_model(box_scene(R"("fixed": [{"points": [0]}, {"points": [1], "axes": "zyx"}])"), {})
                  .fixed_axes.empty());
}

TEST(Fixation, IsWrittenAsItWasRead) {
  const std::string body = R"("fixed": [{"points": [0], "axes": "yz"}, {"points": [1]}],
    "prescribed": [{"points": [2], "motion": {"keyframes": [{"time": 0}, {"time": 1, "translate": [0, 0, 1]}]}}])";
  const Scene scene = box_scene(body);
  const std::string text = write_scene(scene);
  EXPECT_EQ(write_scene(read_scene_text(text, "t.json")), text);
  const Model model = load_model(read_scene_text(text, "t.json"), {});
  EXPECT_EQ(model.fixed_axes[0], 6);
  EXPECT_EQ(model.fixed_points[1], 1);
  EXPECT_EQ(model.motion_of_point[2], 0);
}

TEST(Fixation, RefusesOtherAxes) {
  for (const char* axes : {"w", "xx", "xyzx", "X", "x y"}) {
    EXPECT_EQ(fixation_problem(R"("fixed": [{"points": [0], "axes": ")" + std::string(axes) + "\"}]"),
              "s.json: bodies[0].fixed[0].axes: found '" + std::string(axes) +
                  "', expected one or more of the letters x, y and z, such as \"xz\"");
  }
}

TEST(Fixation, NeedsAnAxis) {
  EXPECT_EQ(fixation_problem(R"("fixed": [{"points": [0], "axes": ""}])"),
            "s.json: bodies[0].fixed[0].axes: found \"\", expected a text that is not empty");
}

TEST(DrivePrescribed, MovesAPartOfASurface) {
  const Scene scene = box_scene(R"("prescribed": [
    {"box": {"lower": [-1, -1, 1], "upper": [1, 1, 1]}, "motion": {"center": [0, 0, 1],
     "keyframes": [{"time": 0}, {"time": 0.1, "translate": [0, 0, 0.1], "rotate": {"angle": 90}}]}},
    {"box": {"lower": [-1, -1, -1], "upper": [1, 1, -1]}, "motion": {"keyframes": [{"time": 0}]}}])");
  Model model = load_model(scene, {});
  ASSERT_EQ(model.motions.size(), 2U);
  Simulation simulation(std::move(model), scene.settings, 1);
  simulation.record_reactions(true);
  for (int step = 0; step < 10; ++step) simulation.step();
  const auto rest = simulation.bodies().points_rest();
  for (std::size_t p = 0; p < rest.size(); ++p) {
    const Vec3& x = simulation.positions()[p];
    const Vec3 turned{-rest[p].y, rest[p].x, 1.1};
    EXPECT_LT(rest[p].z == 1.0 ? length(x - turned) : 0.0, 1e-14) << p;
    EXPECT_EQ(rest[p].z == -1.0 ? x : rest[p], rest[p]) << p;
  }
  EXPECT_GT(simulation.reaction_of_motion(0, {0, 0, 1}).torque.z, 0.0) << "it takes a torque to turn the top";
  // From code, frame by frame.
  simulation.move_to(0, {.time = 5.0, .translate = {0, 0, 0.2}});
  simulation.step();
  simulation.step();
  for (std::size_t p = 0; p < rest.size(); ++p) {
    const Vec3 off = simulation.positions()[p] - rest[p] - Vec3{0, 0, 0.2};
    EXPECT_LT(rest[p].z == 1.0 ? length(off) : 0.0, 1e-14) << p;
  }
  EXPECT_EQ(simulation.motion(0).center, (Vec3{0, 0, 1}));
  EXPECT_THROW(simulation.move_to(2, {}), Error);
  EXPECT_THROW(static_cast<void>(simulation.motion(-1)), Error);
  // A motion set by code is part of the state.
  const std::vector<std::byte> saved = simulation.save();
  Simulation other(load_model(scene, {}), scene.settings, 2);
  other.restore(saved);
  for (Simulation* both : {&simulation, &other}) both->step();
  EXPECT_EQ(other.state_hash(), simulation.state_hash());
}

TEST(DrivePrescribed, RefusesPointsThatAreHeldOtherwise) {
  const std::string motion = R"("motion": {"keyframes": [{"time": 0}]})";
  EXPECT_EQ(
      fixation_problem(R"("fixed": [{"points": [3]}], "prescribed": [{"points": [3], )" + motion + "}]"),
      "s.json: bodies[0].prescribed[0]: found point 3, which is fixed, expected points that are not "
      "fixed and follow no other motion");
  EXPECT_EQ(fixation_problem(R"("prescribed": [{"points": [3], )" + motion + R"(}, {"points": [3], )" +
                             motion + "}]"),
            "s.json: bodies[0].prescribed[1]: found point 3, which follows another motion, expected points "
            "that are not fixed and follow no other motion");
  EXPECT_NE(fixation_problem(R"("prescribed": [{"points": [3]}])").find("prescribed[0].motion"),
            std::string::npos);
  EXPECT_NE(fixation_problem(R"("obstacle": true, "prescribed": [{"points": [3], )" + motion + "}]")
                .find("rigid body"),
            std::string::npos);
}

}  // namespace
}  // namespace palpate
