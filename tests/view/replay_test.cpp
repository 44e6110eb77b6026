// Stored results. Oracle: the run that wrote them (its metrics.csv, its simulation).
#include "view/replay.hpp"

#include <algorithm>
#include <gtest/gtest.h>

#include <palpate/error.hpp>

#include "apps/workplace.hpp"
#include "view/scenes.hpp"

namespace palpate::test {
namespace {

class Replay : public CommandTest {
 protected:
  void SetUp() override {
    write("scene.json", falling_box());
    output_of({"run", "scene.json", "--out", "out", "--every", "5", "--no-picture", "--threads", "1"});
  }
  view::ReplaySource open() const { return view::ReplaySource(folder_ / "out", 1); }
  void expect_refused(const std::string& part) const {
    try {
      open();
      ADD_FAILURE() << "not refused: " << part;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  }
  void replace(const std::string& file, const std::string& old, const std::string& with) const {
    std::string text = read(file);
    const std::size_t place = text.find(old);
    ASSERT_NE(place, std::string::npos) << old;
    write(file, text.replace(place, old.size(), with));
  }
};

TEST_F(Replay, ShowsWhatTheRunFound) {
  view::ReplaySource source = open();
  const Scene scene = read_scene(folder_ / "scene.json");
  Simulation simulation(small_model(scene), scene.settings, 1);
  EXPECT_EQ(source.stage().about["frames"], 3);
  EXPECT_EQ(source.stage().about["bodies"][1]["name"], "box");
  EXPECT_EQ(source.stage().about["bodies"][0]["rigid"], true);
  EXPECT_EQ(source.bodies().tets().size(), simulation.bodies().tets().size());
  const std::vector<std::string> rows = lines_of(read("out/metrics.csv"));
  for (int frame = 0; frame < 3; ++frame) {
    ASSERT_EQ(source.counts()["frame"], frame);
    ASSERT_EQ(source.positions().size(), simulation.positions().size());
    for (std::size_t p = 0; p < source.positions().size(); ++p) {
      EXPECT_EQ(source.positions()[p], simulation.positions()[p]);
    }
    EXPECT_EQ(source.detector().contacts().size(), simulation.detector().contacts().size());
    EXPECT_EQ(source.detector().contacts().depth, simulation.detector().contacts().depth);
    EXPECT_EQ(source.time(), simulation.metrics().time);
    if (frame == 2) break;
    EXPECT_NEAR(source.interval().value(), 0.05, 1e-12);
    double solver = 0.0;
    for (int step = 0; step < 5; ++step) {
      simulation.step();
      solver += std::stod(fields_of(rows[static_cast<std::size_t>(5 * frame + step + 2)])[8]);
    }
    source.advance();
    EXPECT_NEAR(source.seconds()[6], solver / 5, 1e-3 * solver) << "the mean over the steps of the frame";
  }
  EXPECT_EQ(source.interval(), std::nullopt) << "the end";
  EXPECT_GT(source.detector().contacts().size(), 0U);
}

/// A lid in the box is absent at first, then comes in, and the box is removed: contacts are those of the run.
TEST_F(Replay, HasTheBodiesOfEachStage) {
  write("staged.json", R"({"name": "staged", "time_step": 0.01, "bodies": [
    {"name": "plate", "box": {"cells": [2, 2, 1], "size": [0.2, 0.2, 0.02]}, "translate": [0, 0, -0.01], "obstacle": true},
    {"name": "box", "box": {"cells": [3, 3, 3], "size": [0.06, 0.06, 0.06]}, "translate": [0.003, 0.002, 0.029],
     "material": {"young_modulus": 20000, "mass_damping": 1, "stiffness_damping": 0.002}},
    {"name": "lid", "box": {"cells": [1, 1, 1], "size": [0.08, 0.08, 0.02]}, "translate": [0, 0, 0.0685],
     "obstacle": true, "absent": true}], "output": {"every": 1},
    "stages": [{"name": "settle", "until": {"time": 0.02}}, {"name": "lid", "insert": ["lid"], "until": {"time": 0.02}},
               {"name": "clear", "remove": ["box"], "until": {"time": 0.02}}]})");
  output_of({"run", "staged.json", "--out", "staged", "--no-picture", "--threads", "1"});
  const std::vector<std::string> rows = lines_of(read("staged/metrics.csv"));
  const auto header = fields_of(rows[0]);
  const auto column = static_cast<std::size_t>(std::ranges::find(header, "contacts") - header.begin());
  ASSERT_LT(column, header.size());
  view::ReplaySource source(folder_ / "staged", 1);
  EXPECT_EQ(source.stage().about["stages"], nlohmann::json({"settle", "lid", "clear"}));
  const std::vector<int> stages{1, 1, 1, 2, 2, 3, 3};
  const std::vector<std::vector<int>> absent{{}, {2}, {}, {1}};
  std::size_t most = 0;
  for (std::size_t frame = 0; frame < 7; ++frame) {
    const auto plan = source.counts()["plan"];
    const int stage = stages[frame];
    EXPECT_EQ(plan["number"], stage) << frame;
    EXPECT_EQ(plan["absent"], nlohmann::json(absent[static_cast<std::size_t>(stage)])) << frame;
    EXPECT_EQ(plan["done"], frame == 6);
    const std::size_t contacts = source.detector().contacts().size();
    EXPECT_EQ(contacts, std::stoul(fields_of(rows[frame + 1])[column])) << frame;
    most = std::max(most, contacts);
    if (frame == 6) break;
    source.advance();
  }
  EXPECT_GT(most, 0U);
  EXPECT_EQ(source.detector().contacts().size(), 0U) << "lid and plate are rigid, and the box is gone";
}

TEST_F(Replay, SeeksAndRefusesWhatOnlyARunCan) {
  view::ReplaySource source = open();
  source.apply(1, view::Seek{2});
  EXPECT_NEAR(source.time(), 0.1, 1e-12);
  EXPECT_THROW(source.apply(1, view::Seek{3}), Error);
  EXPECT_NEAR(source.time(), 0.1, 1e-12);
  source.reset();
  EXPECT_EQ(source.time(), 0.0);
  EXPECT_THROW(source.apply(1, view::Pull{}), Error);
  EXPECT_THROW(source.apply(1, view::Change{}), Error);
  EXPECT_THROW(source.apply(1, view::DriveMotion{}), Error);
}

TEST_F(Replay, GoesWithoutTimesThatAreNotThere) {
  std::filesystem::remove(folder_ / "out/metrics.csv");
  view::ReplaySource source = open();
  source.advance();
  EXPECT_EQ(source.seconds().back(), 0.0);
  write("out/metrics.csv", "step,time [s]\n0,0\n");
  EXPECT_NO_THROW(static_cast<void>(open()));
}

TEST_F(Replay, RefusesFoldersThatAreNotWhole) {
  replace("out/frames.pvd", "frames/frame_000001.vtu", "../secret.vtu");
  expect_refused("below the folder");
  replace("out/frames.pvd", "../secret.vtu", "/etc/passwd");
  expect_refused("below the folder");
  replace("out/frames.pvd", "/etc/passwd", "frames/frame_000001.vtu");
  replace("out/run.json", "\"points\": 32", "\"points\": 31");
  expect_refused("run.json");
  replace("out/run.json", "\"points\": 31", "\"points\": -1");
  expect_refused("run.json");
  replace("out/run.json", "\"points\": -1", "\"dots\": 32");
  expect_refused("run.json");
  write("out/run.json", "{}");
  expect_refused("run.json: found other content (key 'scene' not found), expected what 'palpate run' writes");
  std::filesystem::remove(folder_ / "out/run.json");
  expect_refused("run.json");
}

TEST_F(Replay, RefusesAFrameOfAnotherMesh) {
  view::ReplaySource source = open();
  write("other.json", falling_box(R"(, "gravity": [0, 0, 0])"));
  replace("other.json", "[3, 3, 1]", "[3, 3, 2]");
  output_of({"run", "other.json", "--out", "other", "--steps", "1", "--no-picture"});
  std::filesystem::copy_file(folder_ / "other/frames/frame_000001.vtu",
                             folder_ / "out/frames/frame_000001.vtu",
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_THROW(source.advance(), Error);
  EXPECT_EQ(source.counts()["frame"], 0) << "what is shown stays";
}

}  // namespace
}  // namespace palpate::test
