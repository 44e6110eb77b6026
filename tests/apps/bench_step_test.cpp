// `palpate bench step` in a few steps of small scenes: rows agree with the steps of the scene, a failure is a
// row, missing scenes are reported. Times are not tested.
#include <gtest/gtest.h>

#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

class BenchStep : public CommandTest {
 protected:
  BenchStep() {
    std::filesystem::create_directory(folder_ / "rough");
    write("rough/box.json", falling_box());
  }
  /// A call with the scenes of ./rough.
  [[nodiscard]] static std::vector<std::string> call(const std::vector<std::string>& more) {
    std::vector<std::string> words{"bench", "step", "--rough", "rough", "--out", "out"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
};

TEST_F(BenchStep, RowsAreThoseOfTheScene) {
  const Json report = json_of(call({"--only", "box", "--steps", "12", "--json"}));
  EXPECT_EQ(Json::parse(read("out/step-scenes.json")), report);
  EXPECT_EQ(report["kind"], "step-scenes");
  EXPECT_EQ(report["complete"], true);
  ASSERT_EQ(report["rows"].size(), 1U);
  const Json& row = report["rows"][0];
  EXPECT_TRUE(row["error"].is_null()) << row;
  EXPECT_EQ(row["tets"], 5 * 9 + 5 * 4);
  EXPECT_EQ(row["steps"], 12);
  EXPECT_GE(row["solves"]["mean"].get<double>(), 1.0);
  EXPECT_GE(row["iterations"]["most"].get<double>(), row["iterations"]["mean"].get<double>());
  EXPECT_GT(row["work"].get<double>(), 0.0);
  EXPECT_GT(row["solver_share"].get<double>(), 0.0);
  EXPECT_LT(row["solver_share"].get<double>(), 1.0);
  EXPECT_EQ(row["inverted_tets"]["most"], 0);
  output_of({"run", "rough/box.json", "--steps", "12", "--no-picture", "--quiet", "--out", "run"});
  EXPECT_EQ(Json::parse(read("run/run.json"))["state_hash"], row["state_hash"]);
  // In um of a scene in m.
  EXPECT_NEAR(row["deepest_um"]["last"].get<double>(),
              1e6 * Json::parse(read("run/run.json"))["deepest"].get<double>(), 1e-6);
}

TEST_F(BenchStep, StepsThatDoNotConvergeAreCounted) {
  write("rough/hasty.json", falling_box(R"(, "solver": {"preconditioner": "jacobi", "max_iterations": 1})"));
  const Json report = json_of(call({"--only", "hasty", "--steps", "20", "--json"}));
  EXPECT_GT(report["rows"][0]["not_converged"].get<int>(), 0);
  EXPECT_GE(report["rows"][0]["divided"].get<int>(), report["rows"][0]["not_converged"].get<int>());
}

TEST_F(BenchStep, ReferencesTellHowFarOffPositionsAre) {
  const auto error_with = [&](const char* tolerance) {
    const Json report = json_of(call({"--only", "beam-1k-1MPa", "--steps", "5", "--preconditioner", "jacobi",
                                      "--tolerance", tolerance, "--reference", "1e-7", "--json"}));
    return report["rows"][0]["position_error"]["largest"].get<double>();
  };
  const double fine = error_with("1e-4");
  const double coarse = error_with("1e-1");
  EXPECT_GT(fine, 0.0);
  EXPECT_GT(coarse, 3.0 * fine);
}

TEST_F(BenchStep, AFailureIsARowAndOthersGoOn) {
  write("rough/a-fast-box.json", falling_box(R"(, "limits": {"max_speed": 0.05})"));
  const Finished done = palpate(call({"--only", "*box", "--steps", "12"}));
  EXPECT_EQ(done.exit_code, 1);
  EXPECT_NE(done.err.find("palpate: error: 1 scene failed: a-fast-box"), std::string::npos) << done.err;
  EXPECT_NE(done.out.find("FAILED: body box"), std::string::npos) << done.out;
  const Json rows = Json::parse(read("out/step-scenes.json"))["rows"];
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_LT(rows[0]["steps"].get<int>(), 12);
  EXPECT_EQ(rows[1]["steps"], 12) << "the one after it";
}

TEST_F(BenchStep, WhatIsLeftOutIsSaid) {
  const std::string text =
      output_of(call({"--only", "box", "--only", "beam-1k-*", "--steps", "1", "--most-tets", "500"}));
  EXPECT_NE(text.find("beam-1k-1MPa            left out: too many tets"), std::string::npos) << text;
  EXPECT_EQ(text.find("beam-10k"), std::string::npos) << text;
  expect_error(2, {"bench", "step", "--only", "eye-ct"}, {"--only", "eye-ct.json"});
  expect_error(2, {"bench", "step", "--only", "nothing"}, {"--only: found 'nothing'", "--list"});
  expect_error(2, call({"--preconditioner", "magic"}), {"--preconditioner: found 'magic'", "'auto'"});
  expect_error(2, {"bench", "step", "--rough", "nowhere"}, {"--rough", "nowhere"});
}

TEST_F(BenchStep, NamesAndHelp) {
  const std::string names = output_of(call({"--list"}));
  for (const char* name :
       {"box\n", "beam-1M-1MPa\n", "pile-slivers-5kPa\n", "stacking: no 'scenes/stacking.json'\n"})
    EXPECT_NE(names.find(name), std::string::npos) << name << " in " << names;
  EXPECT_FALSE(exists("out"));
  const std::string help = output_of({"bench", "step", "--help"});
  for (const char* part : {"Usage: palpate bench step", "Examples:", "--most-tets", "--rough"})
    EXPECT_NE(help.find(part), std::string::npos) << part << " in " << help;
}

}  // namespace
}  // namespace palpate::test
