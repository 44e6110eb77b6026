// Oracle: the run that was not interrupted.
#include <algorithm>
#include <filesystem>
#include <functional>

#include "apps/workplace.hpp"
#include "support/file_size_limit.hpp"

namespace palpate::test {
namespace {

namespace fs = std::filesystem;

class CheckpointedRun : public CommandTest {
 protected:
  void SetUp() override { write("scene.json", falling_box()); }

  [[nodiscard]] std::vector<std::string> run_into(const std::string& out, const std::string& steps,
                                                  std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"run",     "scene.json", "--out",        out,
                                       "--steps", steps,        "--no-picture", "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  void expect_done(const Finished& done) const { EXPECT_EQ(done.exit_code, 0) << done.err; }

  /// Results that an interruption must not change: all except times, folder and date.
  [[nodiscard]] Json outcome(const std::string& out) const {
    Json report = Json::parse(read(out + "/run.json"));
    Json rows = Json::array();
    for (const std::string& line : lines_of(read(out + "/metrics.csv"))) {
      auto fields = fields_of(line);
      fields.erase(fields.begin() + 2, fields.begin() + 10);  // wall_*
      rows.push_back(fields);
    }
    for (const char* own : {"wall_seconds", "phases", "resumed_from", "results", "threads"})
      report.erase(own);
    report["resolved"].erase("structure_bytes");  // reserved memory
    return {{"report", report},
            {"rows", rows},
            {"frames", read(out + "/frames.pvd")},
            {"files", names_in(folder_ / out / "frames")}};
  }
  [[nodiscard]] std::vector<std::string> checkpoints(const std::string& out) const {
    auto names = names_in(folder_ / out / "checkpoints");
    std::ranges::sort(names);
    return names;
  }
  static std::string name_of(int step) {
    const std::string digits = std::to_string(step);
    return "step_" + std::string(9 - digits.size(), '0') + digits + ".palpate";
  }
  [[nodiscard]] fs::path path_of(const std::string& out, int step) const {
    return folder_ / out / "checkpoints" / name_of(step);
  }
};

TEST_F(CheckpointedRun, KeepsTheLastTwoAndGoesOnAsIfNothingHadHappened) {
  expect_done(palpate(run_into("whole", "50")));
  expect_done(palpate(run_into("part", "30", {"--checkpoint-every", "8"})));
  EXPECT_EQ(checkpoints("part"), (std::vector{name_of(24), name_of(30)}));
  // Step 30 is no multiple of the frame interval 4: the last frame of the first run must be removed.
  expect_done(palpate({"run", "--resume", "part", "--steps", "50", "--quiet", "--threads", "1"}));
  EXPECT_EQ(Json::parse(read("part/run.json"))["resumed_from"], 30);
  Json whole = outcome("whole");
  EXPECT_EQ(outcome("part"), whole);
  EXPECT_EQ(checkpoints("part"), (std::vector{name_of(48), name_of(50)}));
}

TEST_F(CheckpointedRun, AnInterruptedRunHasOneWithoutBeingAsked) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Process run(run_into("out", "2000"), folder_.path());
    wait_until([&] { return exists("out/metrics.csv") && lines_of(read("out/metrics.csv")).size() > 2; });
    run.send(signal);
    const Finished done = run.wait();
    EXPECT_EQ(done.exit_code, 1);
    EXPECT_NE(done.err.find("to resume: palpate run --resume out"), std::string::npos) << done.err;
    const int steps = Json::parse(read("out/run.json"))["steps"];
    EXPECT_EQ(checkpoints("out"), std::vector{name_of(steps)});
    const std::string end = std::to_string(steps + 20);
    expect_done(palpate({"run", "--resume", "out", "--steps", end, "--quiet"}));
    expect_done(palpate(run_into("whole", end)));
    EXPECT_EQ(outcome("out"), outcome("whole"));
    fs::remove_all(folder_ / "out");
  }
}

TEST_F(CheckpointedRun, ADamagedOneIsReportedAndTheOneBeforeUsed) {
  expect_done(palpate(run_into("whole", "24")));
  const std::vector<std::function<void(std::string&)>> damages{
      [](std::string& bytes) { bytes.resize(bytes.size() / 2); },
      [](std::string& bytes) { bytes[bytes.size() / 3] ^= 4; }, [](std::string& bytes) { bytes = "torn"; }};
  for (const auto& damage : damages) {
    expect_done(palpate(run_into("out", "24", {"--checkpoint-every", "10"})));
    std::string bytes = content_of(path_of("out", 24));
    damage(bytes);
    put(path_of("out", 24), bytes);
    const Finished done = palpate({"run", "--resume", "out", "--quiet"});
    expect_done(done);
    EXPECT_NE(done.err.find(name_of(24) + ": found"), std::string::npos) << done.err;
    EXPECT_NE(done.err.find("resumes from " + name_of(20)), std::string::npos) << done.err;
    EXPECT_EQ(outcome("out"), outcome("whole"));
  }
  put(path_of("out", 24), "torn");
  put(path_of("out", 20), "");
  expect_error(2, {"run", "--resume", "out"}, {name_of(24), "all 2 checkpoints of the folder are damaged"});
}

TEST_F(CheckpointedRun, WhatIsNotThereAnyMoreIsTold) {
  expect_error(2, {"run", "--resume", "nowhere"}, {"nowhere/checkpoints", "no checkpoint"});
  expect_error(2, {"run", "--resume", "out", "scene.json"}, {"SCENE", "--resume"});
  expect_error(2, {"run", "--resume", "out", "--out", "other"}, {"--out", "--resume"});
  expect_error(2, {"run", "scene.json", "--checkpoint-every", "0"}, {"--checkpoint-every", "'0'"});
  expect_done(palpate(run_into("out", "24", {"--checkpoint-every", "10"})));
  const std::string rows = read("out/metrics.csv");
  put(folder_ / "out/metrics.csv", "step\n");
  expect_error(1, {"run", "--resume", "out", "--quiet"}, {"out/metrics.csv", "5 bytes"});
  put(folder_ / "out/metrics.csv", rows);
}

TEST_F(CheckpointedRun, FramesThatAreGoneAreLeftOut) {
  expect_done(palpate(run_into("out", "24", {"--checkpoint-every", "10"})));
  const auto frames_listed = [&] {
    const std::string text = read("out/frames.pvd");
    std::size_t count = 0;
    for (std::size_t place = text.find("<DataSet"); place != std::string::npos;
         place = text.find("<DataSet", place + 1))
      ++count;
    return count;
  };
  const std::size_t before = frames_listed();
  ASSERT_GT(before, 3U);
  for (const char* name : {"frame_000001.vtu", "frame_000002.vtu"}) fs::remove(folder_ / "out/frames" / name);
  const Finished outcome = palpate({"run", "--resume", "out", "--steps", "24"});
  expect_done(outcome);
  EXPECT_NE(outcome.err.find("2 earlier frames"), std::string::npos) << outcome.err;
  EXPECT_EQ(frames_listed(), before - 2);
  EXPECT_EQ(read("out/frames.pvd").find("frame_000002"), std::string::npos);
}

TEST_F(CheckpointedRun, AChangedMeshIsRefused) {
  write("tet.mesh", one_tet({"0 0 0", "1 0 0", "0 1 0", "0 0 1"}));
  write("scene.json",
        R"({"time_step": 0.01, "duration": 0.1, "bodies": [{"mesh": "tet.mesh", "material": {}}]})");
  expect_done(palpate(run_into("out", "10", {"--checkpoint-every", "5"})));
  write("tet.mesh", one_tet({"0 0 0", "1 0 0", "0 1 0", "0 0 1.5"}));
  expect_error(2, {"run", "--resume", "out"}, {name_of(10), "bodies", "another simulation"});
  write("tet.mesh", one_tet({"0 0 0", "1 0 0", "0 1 0", "0 0 1"}));
  fs::remove(folder_ / "scene.json");  // the checkpoint has it
  expect_done(palpate({"run", "--resume", "out", "--steps", "12", "--quiet"}));
}

TEST_F(CheckpointedRun, OfAKilledRunAreNotLostUnasked) {
  expect_done(palpate(run_into("out", "20", {"--checkpoint-every", "5"})));
  fs::remove(folder_ / "out/run.json");  // a killed run does not write it
  const std::string rows = read("out/metrics.csv");
  expect_error(2, run_into("out", "30"), {"out: found checkpoints", "--resume out", "--replace"});
  EXPECT_EQ(checkpoints("out").size(), 2U);
  EXPECT_EQ(read("out/metrics.csv"), rows);
  expect_done(palpate(run_into("out", "3", {"--replace"})));
  EXPECT_TRUE(checkpoints("out").empty());
}

TEST_F(CheckpointedRun, OfAnInterruptedOrFailedRunAreNotLostUnasked) {
  expect_done(palpate(run_into("out", "20", {"--checkpoint-every", "5"})));
  const Json ended = Json::parse(read("out/run.json"));
  for (const auto& [key, value] : {std::pair("interrupted", Json(true)), {"error", Json("it blew up")}}) {
    Json report = ended;
    report[key] = value;
    write("out/run.json", report.dump());
    expect_error(2, run_into("out", "30"), {"out: found checkpoints", "--resume out", "--replace"});
    EXPECT_EQ(checkpoints("out").size(), 2U);
  }
  write("out/run.json", "no JSON");
  expect_error(2, run_into("out", "30"), {"--replace"});
  EXPECT_EQ(checkpoints("out").size(), 2U);
}

TEST_F(CheckpointedRun, ResumingWithNothingLeftToDoKeepsBoth) {
  expect_done(palpate(run_into("out", "20", {"--checkpoint-every", "15"})));
  const std::vector both{name_of(15), name_of(20)};
  ASSERT_EQ(checkpoints("out"), both);
  for (int time = 0; time < 2; ++time) {
    expect_done(palpate({"run", "--resume", "out", "--quiet"}));
    EXPECT_EQ(checkpoints("out"), both);
  }
}

TEST_F(CheckpointedRun, UnderAnotherNameIsNotTaken) {
  expect_done(palpate(run_into("out", "20", {"--checkpoint-every", "15"})));
  fs::copy_file(path_of("out", 15), path_of("out", 999));
  const Finished done = palpate({"run", "--resume", "out", "--steps", "21"});
  expect_done(done);
  EXPECT_NE(done.err.find(name_of(999) + ": found a checkpoint of step 15"), std::string::npos) << done.err;
  EXPECT_EQ(checkpoints("out"), (std::vector{name_of(20), name_of(21)}));
}

TEST_F(CheckpointedRun, ARefusedResumeChangesNothing) {
  expect_done(palpate(run_into("out", "22", {"--checkpoint-every", "10"})));
  const std::string report = read("out/run.json");
  const std::string frames = read("out/frames.pvd");
  const auto files = names_in(folder_ / "out/frames");
  fs::resize_file(folder_ / "out/metrics.csv", 300);
  expect_error(1, {"run", "--resume", "out", "--steps", "40", "--quiet"}, {"out/metrics.csv", "300 bytes"});
  expect_error(2, {"run", "--resume", "out", "--steps", "3"},
               {"--steps", "found 3", "22 or more", name_of(22)});
  EXPECT_EQ(read("out/run.json"), report);
  EXPECT_EQ(read("out/frames.pvd"), frames);
  EXPECT_EQ(names_in(folder_ / "out/frames"), files);
}

TEST_F(CheckpointedRun, ANewRunRemovesThemAll) {
  expect_done(palpate(run_into("out", "20", {"--checkpoint-every", "5"})));
  expect_done(palpate(run_into("out", "3")));
  EXPECT_TRUE(checkpoints("out").empty());
}

TEST_F(CheckpointedRun, AFullDiskEndsTheRunAndLeavesTheLastGoodState) {
  // Rows grow, those of forces.csv most.
  expect_done(palpate(run_into("whole", "400")));
  const auto full = static_cast<rlim_t>(read("whole/metrics.csv").size() / 2);
  ASSERT_GT(full, 40000U);
  Finished done;
  {
    const FileSizeLimit limit(full);
    done = palpate(run_into("out", "400", {"--checkpoint-every", "10"}));
  }
  EXPECT_EQ(done.exit_code, 1);
  EXPECT_EQ(lines_of(done.err).size(), 1U) << done.err;
  EXPECT_NE(done.err.find("out/forces.csv: writing: found 'File too large'"), std::string::npos) << done.err;
  EXPECT_NE(done.err.find("--resume out"), std::string::npos) << done.err;
  ASSERT_EQ(checkpoints("out").size(), 2U);
  expect_done(palpate({"run", "--resume", "out", "--quiet"}));
  EXPECT_EQ(outcome("out"), outcome("whole"));
  EXPECT_EQ(read("out/forces.csv"), read("whole/forces.csv"));
}

TEST_F(CheckpointedRun, AVanishedFolderEndsTheRun) {
  Process run(run_into("out", "100000000", {"--every", "100000000", "--checkpoint-every", "1"}),
              folder_.path());
  wait_until([&] { return exists("out/checkpoints") && checkpoints("out").size() > 1; });
  fs::rename(folder_ / "out", folder_ / "elsewhere");
  const Finished done = run.wait();
  EXPECT_EQ(done.exit_code, 1);
  // The rows, a frame or a checkpoint reach the limit first.
  EXPECT_TRUE(done.err.starts_with("palpate: error: out/")) << done.err;
  EXPECT_NE(done.err.find("found "), std::string::npos) << done.err;
  EXPECT_EQ(done.err.find("--resume"), std::string::npos) << "there is nothing left: " << done.err;
}

}  // namespace
}  // namespace palpate::test
