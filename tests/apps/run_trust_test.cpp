// Warnings of `palpate run` about unreliable results: steps that did not converge, inverted tets.
#include <algorithm>
#include <gtest/gtest.h>

#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

class RunTrust : public CommandTest {
 protected:
  /// Values of a column of metrics.csv, row by row.
  [[nodiscard]] std::vector<std::string> column(const std::string& file, const std::string& name) const {
    const std::vector<std::string> lines = lines_of(read(file));
    const std::vector<std::string> names = fields_of(lines[0]);
    const auto place = static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
    std::vector<std::string> values;
    for (std::size_t i = 1; i < lines.size(); ++i) values.push_back(fields_of(lines[i]).at(place));
    return values;
  }
};

TEST_F(RunTrust, SaysOnTopWhereStepsDidNotConverge) {
  write("box.json", falling_box());
  write("hasty.json", falling_box(R"(, "solver": {"preconditioner": "jacobi", "max_iterations": 1})"));
  const std::vector<std::string> call{"run", "hasty.json", "--no-picture", "--out", "hasty"};
  const Finished done = palpate(call);
  EXPECT_EQ(done.exit_code, 0);
  const Json report = Json::parse(read("hasty/run.json"));
  const int bad = report["solver"]["steps_not_converged"];
  EXPECT_GT(bad, 0);
  EXPECT_EQ(bad, std::ranges::count(column("hasty/metrics.csv", "solver_converged"), "0"));
  const std::vector<std::string> substeps = column("hasty/metrics.csv", "substeps");
  const auto divisions = std::ssize(substeps) - std::ranges::count(substeps, "1");
  EXPECT_EQ(report["solver"]["steps_divided"], divisions);
  EXPECT_LE(bad, std::ranges::count(substeps, "4")) << "only the smallest parts are taken as they are";
  const std::string divided = "converged     in " + std::to_string(10 - bad) + " of 10 steps; " +
                              std::to_string(divisions) + " divided\n";
  EXPECT_NE(done.out.find(divided), std::string::npos) << done.out;
  const std::string line = "NOT CONVERGED in " + std::to_string(bad) + " of 10 steps: do not trust positions";
  EXPECT_EQ(lines_of(done.out)[0], line);
  EXPECT_NE(done.err.find("palpate: hasty: " + line + "\n"), std::string::npos) << done.err;
  // All but the exit code is the same.
  std::vector<std::string> strictly = call;
  strictly.emplace_back("--strict");
  const Finished strict = palpate(strictly);
  EXPECT_EQ(strict.exit_code, 1);
  EXPECT_EQ(lines_of(strict.out)[0], line);
  EXPECT_NE(strict.err.find("palpate: error: not converged in " + std::to_string(bad) +
                            " of 10 steps (--strict); results are in hasty\n"),
            std::string::npos)
      << strict.err;
  EXPECT_EQ(Json::parse(read("hasty/run.json"))["state_hash"], report["state_hash"]);
  EXPECT_EQ(output_of({"run", "box.json", "--no-picture", "--strict"}).find("NOT CONVERGED"),
            std::string::npos);
}

/// A tet whose top is pushed through its base, faster than it can spring back within a step.
TEST_F(RunTrust, NamesTetsThatAreInsideOut) {
  write("tet.mesh", one_tet({"0 0 0", "1 0 0", "0 1 0", "0 0 1"}));
  write("flip.json",
        R"({"name": "flip", "time_step": 0.01, "duration": 0.05, "gravity": [0, 0, 0], "bodies": [
    {"name": "tet", "mesh": "tet.mesh", "material": {"young_modulus": 1000},
     "fixed": [{"box": {"lower": [-1, -1, -0.01], "upper": [2, 2, 0.01]}}], "velocity": [0, 0, -150]}]})");
  const std::string text = output_of({"run", "flip.json", "--no-picture"});
  const Json report = Json::parse(read("results/flip/run.json"));
  EXPECT_EQ(report["inverted_tets"]["largest"], 1);
  EXPECT_NE(text.find("inverted tets 1 at the end, 1 at most\n"), std::string::npos) << text;
  EXPECT_EQ(report["bodies"][0]["inverted_tets"], report["inverted_tets"]["last"]);
  const std::vector<std::string> inverted = column("results/flip/metrics.csv", "inverted_tets");
  EXPECT_EQ(inverted.front(), "0");
  EXPECT_EQ(inverted.back(), "1");
}

}  // namespace
}  // namespace palpate::test
