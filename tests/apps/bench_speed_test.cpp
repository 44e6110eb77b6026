// `palpate bench speed` in two frames of the smallest scenes: every part runs, has the same results as the
// library it is compared with (else it exits with 1), and writes the rows that it prints. Times are not
// tested.
#include <csignal>
#include <gtest/gtest.h>

#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

class BenchSpeed : public CommandTest {
 protected:
  BenchSpeed() { write("stacking.json", falling_box()); }
  [[nodiscard]] static std::vector<std::string> call(const std::string& part,
                                                     const std::string& most_tets = "10000") {
    return {"bench",   "speed", "--only", part,       "--frames", "2",     "--most-tets",
            most_tets, "--out", "out",    "--scenes", ".",        "--json"};
  }
  /// Runs a part, checks head and file, and returns its rows.
  [[nodiscard]] Json measured(const std::string& part, const std::string& most_tets = "10000") const {
    const Json report = json_of(call(part, most_tets));
    EXPECT_EQ(report["kind"], "speed");
    for (const char* key : {"memcpy_GB_per_s", "sort_ms", "multiply_add_ms"})
      EXPECT_GT(report["references"][key].get<double>(), 0.0) << key;
    for (const char* key : {"cpu", "compiler", "commit"}) EXPECT_TRUE(report["machine"].contains(key)) << key;
    const Json file = Json::parse(read("out/" + part + ".json"));
    EXPECT_EQ(file["part"], part);
    EXPECT_EQ(file["table"], report["rows"]);
    EXPECT_EQ(file["references"], report["references"]);
    for (const Json& row : report["rows"]) {
      EXPECT_GT(row["ours"].get<double>(), 0.0) << row;
      EXPECT_GT(row["other"].get<double>(), 0.0) << row;
      const bool at_most = row["at_most"];
      const bool reached = at_most ? row["ratio"] <= row["must"] : row["ratio"] >= row["must"];
      EXPECT_EQ(reached, row["verdict"] != "missed") << row;
    }
    return report;
  }
};

TEST_F(BenchSpeed, QueryFindsWhatEmbreeFinds) {
  const Json report = measured("query");
  EXPECT_GE(report["rows"].size(), 4U);
  EXPECT_EQ(report["rows"][0]["table"], "detection");
  EXPECT_EQ(report["rows"][0]["work"], "contacts, stacking 10000");
}

TEST_F(BenchSpeed, AnInterruptKeepsTheCasesThatAreDone) {
  std::vector<std::string> words = call("threads");
  words[5] = "100";  // frames
  Process bench(words, folder_.path());
  wait_until([&] { return bench.handles(SIGTERM); });
  bench.send(SIGTERM);
  const Finished finished = bench.wait();
  EXPECT_EQ(finished.exit_code, 1);
  EXPECT_NE(finished.err.find("palpate: error: interrupted; out/threads.json has the cases that are done\n"),
            std::string::npos)
      << finished.err;
  EXPECT_EQ(Json::parse(read("out/threads.json"))["cases"].size(), 1U);
  EXPECT_EQ(names_in(folder_ / "out"), std::vector<std::string>{"threads.json"});
}

TEST_F(BenchSpeed, HandlingHasEdgesAndTheWhole) {
  EXPECT_EQ(measured("handling")["rows"].size(), 4U) << "edges; all, of points alone, at rest";
}

TEST_F(BenchSpeed, ThreadsHaveTheSameResults) {
  const Json report = measured("threads");
  EXPECT_EQ(report["rows"].size(), 3U);
  const Json file = Json::parse(read("out/threads.json"));
  ASSERT_EQ(file["cases"].size(), 2U)
      << "the detection and the falling stack; the scene of the eye is not there";
  for (const Json& c : file["cases"]) {
    ASSERT_GE(c["times"].size(), 2U) << c;
    int threads = 1;
    for (const Json& times : c["times"]) {
      EXPECT_EQ(times["threads"], threads) << c;
      EXPECT_GT(times["all"]["ms"].get<double>(), times["depth"]["ms"].get<double>()) << c;
      EXPECT_GT(times["all"]["faster"].get<double>(), 0.0) << c;
      if (threads == 1) {
        EXPECT_EQ(times["all"]["faster"], 1.0) << c;
      }
      threads *= 2;
    }
  }
}

TEST_F(BenchSpeed, MoversAreSorted) {
  EXPECT_EQ(measured("movers")["rows"].size(), 2U);
}

TEST_F(BenchSpeed, DynamicsReachTheError) {
#ifndef NDEBUG
  GTEST_SKIP() << "takes minutes where Eigen is not optimised";
#endif
  const Json report = measured("dynamics");
  EXPECT_EQ(report["rows"].size(), 3U) << "the stack alone";
  const Json file = Json::parse(read("out/dynamics.json"));
  for (const auto& [name, run] : file["cases"][0]["solve"].items())
    EXPECT_LE(run["largest_error"].get<double>(), 2e-3) << name;
}

TEST_F(BenchSpeed, StepsAreThoseOfTheScene) {
  const Json report = measured("step");
  EXPECT_EQ(report["rows"].size(), 2U);
  EXPECT_EQ(report["rows"][0]["table"], "whole");
  EXPECT_EQ(Json::parse(read("out/step.json"))["cases"][0]["tets"], 5 * 9 + 5 * 4);
}

TEST_F(BenchSpeed, TissueOfTwoLawsIsCompared) {
  const Json report = measured("tissue", "30000");
  ASSERT_EQ(report["rows"].size(), 1U) << "the scene of the eye is not there";
  EXPECT_EQ(report["rows"][0]["work"], "stable neo-Hookean over corotational: element pass");
  EXPECT_EQ(Json::parse(read("out/tissue.json"))["cases"][0]["tets"], 5 * 16 * 16 * 16);
}

TEST_F(BenchSpeed, InstructionsAreThoseOfAsMuchWork) {
  const std::vector<std::string> words = call("instructions", "400");
  const Finished done = palpate(words);
  if (done.exit_code == 2) {
    expect_error(2, words, {"--only: found 'instructions, but there is no"});
    GTEST_SKIP() << done.err;
  }
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const Json counts = Json::parse(done.out)["instructions"];
  ASSERT_EQ(counts.size(), 12U);
  for (const Json& kernel : counts) {
    EXPECT_EQ(kernel.at("cells"), 2) << kernel;
    EXPECT_GT(kernel["per_unit"].get<double>(), 10.0) << kernel;
    const bool is_step = kernel["name"] == "step of the falling stack";
    EXPECT_LT(kernel["per_unit"].get<double>(), is_step ? 1e7 : 1e5) << kernel;
    // 20 membranes of 2 x 2 x 1 cells of 5 tets, two frames; one step.
    const int frames = kernel["frames"];
    EXPECT_EQ(frames, is_step ? 1 : 2);
    if (kernel["unit"] == "tet") {
      EXPECT_EQ(kernel["units"], frames * 20 * 4 * 5) << kernel;
    } else if (kernel["unit"] == "point") {
      EXPECT_EQ(kernel["units"], frames * 20 * 18) << kernel;
    }
    const Json& parallel = kernel["parallel"];
    EXPECT_GE(parallel["speed_up"]["2"].get<double>(), 1.0) << kernel;
    EXPECT_LE(parallel["speed_up"]["32"].get<double>(), 1.0 / (1.0 - parallel["share"].get<double>()) + 1e-9);
  }
}

TEST_F(BenchSpeed, WithoutJsonItIsATable) {
  const std::string text = output_of({"bench", "speed", "--only", "movers", "--frames", "2"});
  for (const char* part : {"memcpy of 64 MiB", "GB/s", "must", "aim", "against std::sort", "≤ 6×", "commit"})
    EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;
  EXPECT_TRUE(exists("results/bench-speed/movers.json"));
}

TEST_F(BenchSpeed, HelpTeachesByExamples) {
  const std::string help = output_of({"bench", "speed", "--help"});
  for (const char* part : {"Usage: palpate bench speed", "Examples:", "\n  palpate bench speed ",
                           "--only query", "--skull", "'must'"})
    EXPECT_NE(help.find(part), std::string::npos) << part << " in " << help;
}

TEST_F(BenchSpeed, RefusesWhatIsNotThere) {
  expect_error(2, {"bench", "speed", "--only", "everything"},
               {"--only: found 'everything'",
                "'query', 'handling', 'threads', 'movers', 'dynamics', 'step', 'tissue', 'instructions'"});
  expect_error(2, {"bench", "speed", "--frames", "0"}, {"--frames: found '0'"});
  expect_error(2, {"bench", "speed", "--skull", "nowhere"}, {"--skull", "nowhere/hq_skull.mesh"});
  expect_error(2, {"bench", "speed", "--scenes", "nowhere"}, {"--scenes", "nowhere/stacking.json"});
  expect_error(2, {"bench", "speed", "--only", "query", "--most-tets", "100"}, {"--most-tets: found '100'"});
  expect_error(2, {"bench", "speed", "--fast"}, {"--fast"});
  expect_error(2, {"bench", "sped"}, {"'sped'", "expected 'speed'"});
}

}  // namespace
}  // namespace palpate::test
