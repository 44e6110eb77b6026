// The report of `palpate bench paper` on small scenes. Oracles: Amdahl's law by hand, and the scenes' own
// runs.
#include <gtest/gtest.h>

#include "apps/workplace.hpp"
#include "measure/paper.hpp"

namespace palpate::test {
namespace {

class BenchPaper : public CommandTest {
 protected:
  BenchPaper() {
    for (const char* name : {"stacking", "eye", "skull"}) write(std::string(name) + ".json", falling_box());
  }
  [[nodiscard]] Json item(const std::string& id) const {
    const Json report = json_of({"bench", "paper", "--scenes", ".", "--out", "out", "--only", id, "--json"});
    EXPECT_EQ(report["sections"].size(), 1U);
    EXPECT_EQ(report["sections"][0]["id"], id);
    return report["sections"][0];
  }
};

TEST(ParallelShare, SolvesAmdahlsLaw) {
  // 80 % of the work on 8 threads: 1 / (0.2 + 0.8 / 8) = 3.33.
  EXPECT_NEAR(measure::parallel_share(1.0 / 0.3, 8), 0.8, 1e-12);
  EXPECT_NEAR(measure::parallel_share(2.0, 2), 1.0, 1e-12);
  EXPECT_NEAR(measure::parallel_share(1.0, 4), 0.0, 1e-12);
}

TEST_F(BenchPaper, TimesEveryWayOnEveryFrame) {
  const Json section = item("figure-6");
  ASSERT_GE(section["table"]["rows"].size(), 2U);
  EXPECT_EQ(section["table"]["rows"][0][0], "serial hashing, 1 thread");
  for (const Json& row : section["table"]["rows"]) EXPECT_GT(row[4].get<double>(), 0.0) << row;
  for (const Json& series : section["charts"][0]["series"]) EXPECT_EQ(series["y"].size(), 401U);
}

TEST_F(BenchPaper, ComparesCountsWithThePaper) {
  const Json section = item("table-1");
  EXPECT_EQ(section["verdict"], "differs") << "boxes are not the paper's scenes";
  const Json row = section["table"]["rows"][3];
  EXPECT_EQ(row[0], "stacking");
  EXPECT_EQ(row[1], "tets");
  EXPECT_EQ(row[2], 10000.0);
  EXPECT_EQ(row[3], 5.0 * (2 * 2 + 3 * 3)) << "five tets a cell";
  EXPECT_NEAR(row[4].get<double>(), -99.35, 1e-9);
}

TEST_F(BenchPaper, MeasuresTheErrorOfFewCells) {
  const Json rows = item("table-2")["table"]["rows"];
  ASSERT_EQ(rows.size(), 8U);
  EXPECT_EQ(rows[0][1], "exact");
  EXPECT_EQ(rows[1][4], 0.0) << "27 cells hold all that such tets cover: the run is the exact one";
  EXPECT_GT(rows[3][3].get<double>(), 0.0) << "one cell leaves some out";
}

TEST_F(BenchPaper, RefusesWhatIsNotThere) {
  expect_error(2, {"bench", "paper", "--scenes", "nowhere"}, {"nowhere/stacking.json"});
  expect_error(2, {"bench", "paper", "--only", "figure-9"}, {"--only: found 'figure-9'", "figure-6"});
  expect_error(2, {"bench"}, {"no subcommand", "paper"});
  expect_error(2, {"bench", "paper", "--quick", "--full"}, {"--quick"});
}

}  // namespace
}  // namespace palpate::test
