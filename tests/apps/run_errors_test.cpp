#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

class RunErrors : public CommandTest {};

TEST_F(RunErrors, ScenesThatCannotBeRead) {
  expect_error(2, {"run", "missing.json"}, {"missing.json"});
  std::filesystem::create_directory(folder_ / "folder.json");
  expect_error(2, {"run", "folder.json"}, {"folder.json"});
  expect_error(2, {"run", "mesh.msh"}, {"mesh.msh", "a mesh file", "a scene file"});
}

TEST_F(RunErrors, ScenesThatAreWrong) {
  write("broken.json", "{\"name\": \"x\",\n  \"bodies\": [}");
  expect_error(2, {"run", "broken.json"}, {"broken.json: line 2, column"});
  write("key.json", falling_box(R"(, "gravty": [0, 0, 0])"));
  expect_error(2, {"run", "key.json"}, {"key.json: gravty", "'gravity'"});
  write("value.json", falling_box(R"(, "solver": {"max_iterations": 0})"));
  expect_error(2, {"run", "value.json"}, {"value.json: solver.max_iterations", "found 0"});
  write("empty.json", "");
  expect_error(2, {"run", "empty.json"}, {"empty.json"});
  write("nobody.json", R"({"bodies": []})");
  expect_error(2, {"run", "nobody.json"}, {"nobody.json: bodies"});
  write(
      "fixed.json",
      R"({"bodies": [{"box": {"size": [1, 1, 1], "cells": [1, 1, 1]}, "material": {}, "fixed": [{"points": [8]}]}]})");
  expect_error(2, {"run", "fixed.json"}, {"fixed.json: bodies[0].fixed[0].points[0]", "found 8"});
  EXPECT_FALSE(exists("results")) << "a refused scene leaves nothing";
}

TEST_F(RunErrors, AControlCharacterDoesNotBreakTheLine) {
  expect_error(2, {"run", "two\nlines\x1b[31m.json"}, {"two?lines?[31m.json"});
}

TEST_F(RunErrors, FoldersThatCannotBeWritten) {
  write("scene.json", falling_box());
  write("file", "not a folder");
  expect_error(1, {"run", "scene.json", "--out", "file"}, {"file", "folder"});
  expect_error(1, {"run", "scene.json", "--out", "/proc/palpate"}, {"/proc/palpate", "folder"});
  std::filesystem::create_directories(folder_ / "out/metrics.csv");
  expect_error(1, {"run", "scene.json", "--out", "out"}, {"out/metrics.csv", "Is a directory"});
  EXPECT_EQ(read("file"), "not a folder");
}

TEST_F(RunErrors, APictureThatCannotBeTakenLosesNothingElse) {
  // A camera at the centre of the bodies, which is what it looks at unless told: known only once they are
  // there.
  write("scene.json", R"({"time_step": 0.01, "duration": 0.1, "gravity": [0, 0, 0],
    "bodies": [{"box": {"cells": [1, 1, 1], "size": [1, 1, 1]}, "material": {}}],
    "output": {"picture": {"size": [160, 120], "camera": {"position": [0, 0, 0]}}}})");
  const Finished done = palpate({"run", "scene.json", "--out", "out", "--quiet"});
  EXPECT_EQ(done.exit_code, 1);
  EXPECT_TRUE(done.err.starts_with("palpate: error: picture: camera")) << done.err;
  const Json report = Json::parse(read("out/run.json"));
  EXPECT_EQ(report["steps"], 10);
  EXPECT_TRUE(report["results"]["picture"].is_null());
  EXPECT_TRUE(report["error"].get<std::string>().starts_with("picture: camera"));
  EXPECT_FALSE(exists("out/picture.png"));
}

TEST_F(RunErrors, ASimulationThatBlowsUpKeepsWhatItDid) {
  write("scene.json", falling_box(R"(, "gravity": [0, 0, -1e308])"));
  const Finished done = palpate({"run", "scene.json", "--out", "out", "--steps", "2000", "--quiet"});
  EXPECT_EQ(done.exit_code, 1);
  EXPECT_EQ(done.out, "");
  EXPECT_EQ(lines_of(done.err).size(), 1U) << done.err;
  EXPECT_TRUE(done.err.starts_with("palpate: error: ")) << done.err;
  const Json report = Json::parse(read("out/run.json"));
  EXPECT_EQ("palpate: error: " + report["error"].get<std::string>() + "\n", done.err);
  EXPECT_EQ(report["at_rest"], false);
  EXPECT_EQ(lines_of(read("out/metrics.csv")).size(), report["steps"].get<std::size_t>() + 2);
  EXPECT_TRUE(exists("out/frames/frame_000000.vtu"));
}

}  // namespace
}  // namespace palpate::test
