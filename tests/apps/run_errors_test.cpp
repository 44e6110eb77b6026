#include <sys/stat.h>

#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

class RunErrors : public CommandTest {
 protected:
  static std::string frame_name(std::int64_t index) {
    return "frames/frame_00000" + std::to_string(index) + ".vtu";
  }
  /// The results of a run that blew up after `steps` steps of 0.01 s, with a frame every 4.
  void expect_results_until(const Finished& done, std::int64_t steps, const std::string& message) const {
    EXPECT_EQ(done.exit_code, 1);
    EXPECT_EQ(done.out, "");
    ASSERT_EQ(lines_of(done.err).size(), 1U) << done.err;
    EXPECT_TRUE(done.err.starts_with("palpate: error: " + message)) << done.err;
    const std::string step = ", step " + std::to_string(steps + 1) + ": found ";
    EXPECT_NE(done.err.find(step), std::string::npos) << done.err;
    const Json report = Json::parse(read("out/run.json"));
    EXPECT_EQ("palpate: error: " + report["error"].get<std::string>() + "\n", done.err);
    EXPECT_EQ(report["steps"], steps);
    EXPECT_EQ(report["at_rest"], false);
    EXPECT_NEAR(report["simulated_time"], 0.01 * static_cast<double>(steps), 1e-12);
    EXPECT_TRUE(report["results"]["picture"].is_null());
    const auto rows = lines_of(read("out/metrics.csv"));
    ASSERT_EQ(static_cast<std::int64_t>(rows.size()), steps + 2);
    EXPECT_EQ(fields_of(rows.back()).size(), fields_of(rows.front()).size());
    // The last frame is that of the last good step, also between two that are due.
    const std::int64_t frames = steps / 4 + 1 + (steps % 4 == 0 ? 0 : 1);
    EXPECT_EQ(report["results"]["frames"], frames);
    const std::string series = read("out/frames.pvd");
    EXPECT_TRUE(series.ends_with("</VTKFile>\n")) << series;
    for (std::int64_t f = 0; f < frames; ++f) {
      const std::string name = frame_name(f);
      EXPECT_NE(series.find(name), std::string::npos) << name;
      EXPECT_TRUE(exists("out/" + name)) << name;
    }
    EXPECT_FALSE(exists("out/" + frame_name(frames)));
  }
};

TEST_F(RunErrors, ScenesThatCannotBeRead) {
  expect_error(2, {"run", "missing.json"}, {"missing.json"});
  std::filesystem::create_directory(folder_ / "folder.json");
  expect_error(2, {"run", "folder.json"}, {"folder.json"});
  expect_error(2, {"run", "mesh.msh"}, {"mesh.msh", "a mesh file", "a scene file"});
  ASSERT_EQ(::mkfifo((folder_ / "pipe.json").c_str(), 0600), 0);
  std::filesystem::create_symlink("/dev/zero", folder_ / "zero.json");
  for (const char* command : {"run", "info", "detect"}) {
    for (const char* name : {"pipe.json", "zero.json"})
      expect_error(2, {command, name}, {name, "not a regular file"});
  }
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
  write("nul.json", falling_box() + std::string(1, '\0') + " behind {{{");
  expect_error(2, {"run", "nul.json"}, {"nul.json: line ", "a NUL byte"});
  write("path.json", R"({"bodies": [{"mesh": "ok.msh\u0000x", "material": {}}]})");
  expect_error(2, {"run", "path.json"}, {"path.json: bodies[0].mesh", "NUL", "expected"});
  write("test.json", falling_box(R"(, "contact": {"budget": {"test": 5}})"));
  expect_error(2, {"run", "test.json"}, {"test.json: contact.budget.test", "unknown key", "'tests'"});
  write("cell.json", falling_box(R"(, "contact": {"cell_size": 1e308, "structure": "uniform"})"));
  expect_error(2, {"run", "cell.json"}, {"cell_size: found 1e+308", "1e150"});
  write("far.json", R"({"bodies": [{"ball": {"radius": 1, "resolution": 2}, "material": {},
    "translate": [1e308, 0, 0]}]})");
  expect_error(2, {"run", "far.json"}, {"far.json: bodies[0]", "point ", "1e100"});
  write("tiny.json", R"({"bodies": [{"box": {"cells": [1, 1, 1], "size": [1e-200, 1e-200, 1e-200]},
    "material": {}}]})");
  for (const char* command : {"run", "info", "detect"}) {
    expect_error(2, {command, "tiny.json"},
                 {"tiny.json: bodies[0]", "tets: found a size of at most 1e-200, expected 1e-150 or more"});
  }
  write("nobody.json", R"({"bodies": []})");
  expect_error(2, {"run", "nobody.json"}, {"nobody.json: bodies"});
  write(
      "fixed.json",
      R"({"bodies": [{"box": {"size": [1, 1, 1], "cells": [1, 1, 1]}, "material": {}, "fixed": [{"points": [8]}]}]})");
  expect_error(2, {"run", "fixed.json"}, {"fixed.json: bodies[0].fixed[0].points[0]", "found 8"});
  EXPECT_FALSE(exists("results")) << "a refused scene leaves nothing";
}

TEST_F(RunErrors, MessagesNameWhatTheUserWrote) {
  write("budget.json", falling_box(R"(, "contact": {"budget": {"tests": 1}})"));
  expect_error(2, {"run", "budget.json", "--structure", "hash"},
               {"--structure: found 'hash'", "contact.budget"});
  expect_error(2, {"run", "budget.json", "--cells-per-primitive", "4"},
               {"--cells-per-primitive: found '4'", "contact.budget"});
  write("many.json",
        R"({"bodies": [{"box": {"cells": [1024, 1024, 1024], "size": [1, 1, 1]}, "material": {}}]})");
  expect_error(2, {"run", "many.json"},
               {"many.json: bodies[0].box.cells: found 5368709120 tets, expected at most 536870911"});
  write("flat.json",
        R"({"bodies": [{"box": {"cells": [1, 1, 1], "size": [1e-110, 1e-110, 1e-110]}, "material": {}}]})");
  const Finished flat = palpate({"run", "flat.json"});
  EXPECT_EQ(flat.exit_code, 2);
  EXPECT_EQ(flat.err.find("body body"), std::string::npos) << flat.err;
  EXPECT_NE(flat.err.find("body 0"), std::string::npos) << flat.err;
  EXPECT_EQ(flat.err.find("0.000000"), std::string::npos) << flat.err;
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

TEST_F(RunErrors, ClosedStreamsLeadNowhere) {
  write("scene.json", falling_box());
  Process run({"run", "scene.json", "--out", "out", "--no-picture"}, folder_.path(), closed_streams);
  EXPECT_EQ(run.wait().exit_code, 0);
  const auto rows = lines_of(read("out/metrics.csv"));
  ASSERT_EQ(rows.size(), 12U);
  for (const std::string& row : rows) EXPECT_EQ(fields_of(row).size(), fields_of(rows[0]).size()) << row;
}

TEST_F(RunErrors, OnlyOneRunWritesIntoAFolder) {
  write("scene.json", falling_box());
  const std::vector<std::string> into_out{"run", "scene.json", "--out", "out", "--checkpoint-every",
                                          "1",   "--steps"};
  const auto of_steps = [&](const std::string& steps) {
    auto arguments = into_out;
    arguments.push_back(steps);
    return arguments;
  };
  Process first(of_steps("100000000"), folder_.path());
  wait_until([&] { return exists("out/checkpoints") && names_in(folder_ / "out/checkpoints").size() > 1; });
  expect_error(1, of_steps("3"), {"out: found another run"});
  expect_error(1, {"run", "--resume", "out", "--quiet"}, {"out: found another run"});
  EXPECT_TRUE(first.running());
  first.send(SIGKILL);
  first.wait();
  EXPECT_TRUE(exists("out/.lock")) << "of no use: the lock ended with the process";
  auto again = of_steps("3");
  again.push_back("--replace");
  output_of(again);
  EXPECT_FALSE(exists("out/.lock"));
}

TEST_F(RunErrors, TheSummarySaysWhatABudgetLeftOut) {
  write("small.json", falling_box(R"(, "contact": {"budget": {"tests": 1}})"));
  const std::string small = output_of({"run", "small.json", "--no-picture", "--out", "small"});
  const auto late = Json::parse(read("small/run.json"))["budget"]["late_steps"].get<int>();
  ASSERT_GT(late, 1);
  EXPECT_NE(
      small.find("budget        too small in " + std::to_string(late) + " steps: contacts may be missing; "),
      std::string::npos)
      << small;
  EXPECT_NE(small.find("; at the end in plate, box\n"), std::string::npos) << small;
  write("large.json", falling_box(R"(, "contact": {"budget": {"tests": 1000000}})"));
  const std::string large = output_of({"run", "large.json", "--no-picture", "--out", "large"});
  EXPECT_EQ(large.find("budget"), std::string::npos) << large;
}

TEST_F(RunErrors, APictureThatCannotBeTakenLosesNothingElse) {
  // A camera at the centre of the bodies, which is its default target: an error found only after loading.
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
  expect_results_until(done, 0, "body box: tet ");
}

TEST_F(RunErrors, ARunThatBreaksALimitEndsAtTheLastGoodStep) {
  // Upwards, damped by 1/s: v_n = (v_(n-1) + 0.0981) / 1.01 is 0.0971, 0.1933, 0.2885 m/s.
  write("scene.json", falling_box(R"(, "gravity": [0, 0, 9.81], "limits": {"max_speed": 0.25})"));
  const Finished done = palpate({"run", "scene.json", "--out", "out", "--steps", "200", "--quiet"});
  expect_results_until(done, 2, "body box: tet ");
  EXPECT_TRUE(done.err.ends_with(", expected at most 0.25 (limits.max_speed)\n")) << done.err;
}

}  // namespace
}  // namespace palpate::test
