// `palpate run` of scenes with stages and outcomes. Oracles: the run that was not interrupted, and numbers
// known.
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

class StagedRun : public CommandTest {
 protected:
  void SetUp() override {
    write("scene.json", staged("0.06"));
    output_of({"run", "scene.json", "--no-picture", "--out", "a"});
  }
  /// A falling box that is moved, released and comes to rest; `most` is the time limit for that.
  static std::string staged(const std::string& until, const std::string& most = "2") {
    return R"({"name": "staged", "time_step": 0.01, "output": {"every": 5}, "bodies": [
      {"name": "table", "box": {"cells": [2, 2, 1], "size": [0.3, 0.3, 0.04]}, "translate": [0, 0, -0.02], "obstacle": true},
      {"name": "block", "box": {"cells": [2, 2, 2], "size": [0.1, 0.1, 0.1]}, "translate": [0, 0, 0.06],
       "material": {"young_modulus": 1e5, "stiffness_damping": 0.01}}],
      "stages": [
        {"name": "move", "move": [{"body": "block", "motion": {"interpolation": "smooth",
          "keyframes": [{"time": 0.05, "translate": [0.05, 0, 0]}]}}], "until": {"time": )" +
           until + R"(}, "checkpoint": true},
        {"name": "rest", "release": [{"body": "block"}], "until": {"rest": true, "most": )" +
           most + R"(}}],
      "outcomes": [
        {"name": "shift", "displacement": {"body": "block", "along": [1, 0, 0]}},
        {"name": "weight", "force": {"body": "block", "along": [0, 0, 1]}}]})";
  }
  /// Runs, expects exit code 0; notes on stderr are allowed.
  void done(std::vector<std::string> arguments) const {
    const Finished run = palpate(std::move(arguments));
    EXPECT_EQ(run.exit_code, 0) << run.err;
  }
  [[nodiscard]] Json results(const std::string& folder) const {
    return Json::parse(read(folder + "/outcomes.json"));
  }
};

TEST_F(StagedRun, TellsItsOutcomesEverywhere) {
  const Json json = results("a");
  ASSERT_EQ(json["stages"].size(), 2U);
  EXPECT_EQ(json["stages"][0]["last_step"], 6);
  EXPECT_EQ(json["stages"][1]["reached"], true);
  const Json& shift = json["outcomes"][0];
  EXPECT_NEAR(shift["value"].get<double>(), 0.05, 1e-4);
  EXPECT_EQ(shift["unit"], "m");
  EXPECT_EQ(shift["stage"], "rest");
  EXPECT_EQ(shift["definition"]["displacement"]["body"], "block");
  EXPECT_NEAR(shift["stages"][0]["value"].get<double>(), 0.05, 1e-12);
  EXPECT_NEAR(json["outcomes"][1]["value"].get<double>(), 9.81, 0.01) << "1 kg";
  const auto lines = lines_of(read("a/metrics.csv"));
  const auto names = fields_of(lines.front());
  const auto column = std::ranges::find(names, "weight [N]") - names.begin();
  ASSERT_LT(column, std::ssize(names));
  EXPECT_EQ(std::stod(fields_of(lines.back()).at(static_cast<std::size_t>(column))),
            json["outcomes"][1]["value"].get<double>());
  const Json run = Json::parse(read("a/run.json"));
  EXPECT_EQ(run["stages"], json["stages"]);
  EXPECT_EQ(run["results"]["outcomes"], "outcomes.json");
  const std::string summary = output_of({"run", "scene.json", "--no-picture", "--out", "b"});
  for (const char* part : {"stage         move: 6 steps, until 0.06 s\n", "outcome       shift: 50 mm",
                           "outcome       weight: 9.80"})
    EXPECT_NE(summary.find(part), std::string::npos) << part << " is not in:\n" << summary;
}

TEST_F(StagedRun, FromTheEndOfAStageHasTheSameBits) {
  const Json whole = results("a");
  const std::string rows = read("a/forces.csv");
  EXPECT_TRUE(exists("a/stages/move.palpate"));
  done({"run", "scene.json", "--no-picture", "--from-stage", "move", "--from", "a", "--out", "c", "--threads",
        "1"});
  EXPECT_EQ(results("c"), whole) << "in another folder";
  EXPECT_EQ(read("c/forces.csv"), rows);
  done({"run", "scene.json", "--no-picture", "--from-stage", "move", "--out", "a"});
  EXPECT_EQ(results("a"), whole) << "in the same folder";
  EXPECT_EQ(read("a/forces.csv"), rows);
  EXPECT_EQ(Json::parse(read("a/run.json"))["from_stage"], "move");
  write("variant.json", staged("0.06", "0.02"));
  done({"run", "variant.json", "--no-picture", "--from-stage", "move", "--from", "a", "--out", "v"});
  EXPECT_EQ(results("v")["stages"][1]["last_step"], 8) << "another stage behind it";
}

TEST_F(StagedRun, GoesOnWhereItWasInterrupted) {
  const Json whole = results("a");
  for (const char* steps : {"3", "6", "20"}) {
    done({"run", "scene.json", "--no-picture", "--out", "d", "--steps", steps, "--checkpoint-every", "100",
          "--replace"});
    done({"run", "--resume", "d", "--steps", "1000", "--no-picture"});
    EXPECT_EQ(results("d"), whole) << "after step " << steps;
  }
}

TEST_F(StagedRun, SaysWhereAStageEndedByItsTime) {
  write("short.json", staged("0.06", "0.02"));
  const Finished run = palpate({"run", "short.json", "--no-picture", "--out", "s"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_NE(run.err.find("s: stage 'rest' ended after 0.02 s, not at rest"), std::string::npos) << run.err;
  EXPECT_NE(run.out.find("NOT REACHED"), std::string::npos);
  EXPECT_EQ(Json::parse(read("s/run.json"))["stages"][1]["reached"], false);
  EXPECT_EQ(palpate({"run", "short.json", "--no-picture", "--out", "s", "--strict"}).exit_code, 1);
}

TEST_F(StagedRun, RefusesWhatItCannotBeginFrom) {
  expect_error(2, {"run", "scene.json", "--from-stage", "rest", "--out", "a"},
               {"a/stages: found no saved state at the end of stage 'rest', expected one of move"});
  expect_error(2, {"run", "scene.json", "--from-stage", "rest", "--out", "nowhere"},
               {"found no saved state at the end of stage 'rest', expected the results of a run that saved "
                "one (\"checkpoint\": true in the stage)"});
  write("other.json", staged("0.07"));
  expect_error(2, {"run", "other.json", "--from-stage", "move", "--out", "a"},
               {"other.json: stages[0]: found a stage that differs from the one of the earlier run"});
  expect_error(2,
               {"run", "scene.json", "--set", "contact.friction=0.5", "--from-stage", "move", "--out", "a"},
               {"a/stages/move.palpate: settings: found values of another simulation"});
  expect_error(2, {"run", "scene.json", "--until-rest"}, {"--until-rest: found a scene with stages"});
  write("a/stages/move.palpate", "no state");
  expect_error(2, {"run", "scene.json", "--from-stage", "move", "--out", "a"}, {"a/stages/move.palpate"});
}

TEST_F(StagedRun, LeavesOtherResultsAloneWhereItIsRefused) {
  write("box.json", falling_box());
  done({"run", "box.json", "--steps", "3", "--no-picture", "--out", "done"});
  const std::string metrics = read("done/metrics.csv");
  const std::string forces = read("done/forces.csv");
  const auto refused = [&](int exit_code, const std::vector<std::string>& more, const std::string& why) {
    std::vector<std::string> words{"run",    "scene.json", "--from-stage", "move",
                                   "--from", "a",          "--out",        "done"};
    words.insert(words.end(), more.begin(), more.end());
    expect_error(exit_code, words, {why});
    EXPECT_EQ(read("done/metrics.csv"), metrics);
    EXPECT_EQ(read("done/forces.csv"), forces);
  };
  refused(2, {"--set", "contact.friction=0.5"}, "settings: found values of another simulation");
  std::filesystem::rename(folder_ / "a/forces.csv", folder_ / "a/away.csv");
  refused(2, {}, "a/forces.csv");
  std::filesystem::rename(folder_ / "a/away.csv", folder_ / "a/forces.csv");
  const int lock = ::open((folder_ / "done/.lock").c_str(), O_CREAT | O_RDWR, 0600);  // as another run has it
  ASSERT_EQ(::flock(lock, LOCK_EX), 0);
  refused(1, {}, "another run that is writing into this folder");
  ::close(lock);
}

TEST_F(StagedRun, WritesAPageOfItsOwn) {
  done({"run", "scene.json", "--out", "p", "--report", "--set", "output.picture.size=[160, 120]"});
  const std::string page = read("p/report.html");
  for (const char* part : {"<!DOCTYPE html>", "No warnings", "<td>shift</td>", "<td>9.80", "end of rest",
                           "data:image/png;base64,iVBORw0KGgo", "state hash", "<td>table</td>", "commit"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  EXPECT_EQ(page.find("http"), std::string::npos) << "nothing outside of it";
  EXPECT_TRUE(exists("p/stages/move.png"));
}

}  // namespace
}  // namespace palpate::test
