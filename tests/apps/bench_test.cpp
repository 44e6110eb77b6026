// The reports of `palpate bench` on small scenes. Oracles: Amdahl's law, quartiles and growth by hand, and
// the scenes' own runs.
#include <cmath>
#include <gtest/gtest.h>

#include "apps/workplace.hpp"
#include "measure/paper.hpp"
#include "measure/scaling.hpp"

namespace palpate::test {
namespace {

class BenchPaper : public CommandTest {
 protected:
  BenchPaper() {
    for (const char* name : {"stacking", "eye", "skull"}) write(std::string(name) + ".json", falling_box());
  }
  [[nodiscard]] Json item(const std::string& id) const {
    const Json report = json_of({"bench", "paper", "--scenes", ".", "--out", "out", "--only", id, "--json"});
    EXPECT_EQ(report["complete"], true);
    EXPECT_EQ(report["sections"].size(), 1U);
    EXPECT_EQ(report["sections"][0]["id"], id);
    return report["sections"][0];
  }
};

TEST(ParallelShare, SolvesAmdahlsLaw) {
  // 80 % of the work on 8 threads: 1 / (0.2 + 0.8 / 8) = 3.33.
  EXPECT_NEAR(measure::parallel_fraction(1.0 / 0.3, 8), 0.8, 1e-12);
  EXPECT_NEAR(measure::parallel_fraction(2.0, 2), 1.0, 1e-12);
  EXPECT_NEAR(measure::parallel_fraction(1.0, 4), 0.0, 1e-12);
}

TEST_F(BenchPaper, TimesEveryVariantOnEveryFrame) {
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

TEST(Measure, HasTheQuartilesOfItsSample) {
  const measure::Measure m = measure::measure_of("x", {4.0, 1.0, 3.0, 2.0, 5.0, 6.0});
  EXPECT_EQ(m.samples, 6U);
  EXPECT_EQ(m.least, 1.0);
  EXPECT_EQ(m.lower_quartile, 2.25) << "a quarter of the way from the 1st to the 6th";
  EXPECT_EQ(m.median, 3.5);
  EXPECT_EQ(m.upper_quartile, 4.75);
  EXPECT_EQ(m.most, 6.0);
  EXPECT_EQ(measure::measure_of("x", {7.0}).upper_quartile, 7.0);
}

TEST(Growth, FindsThePowerOfAPower) {
  const std::vector<double> x{1e4, 3e4, 1e5, 1e6};
  std::vector<double> y;
  for (const double u : x) y.push_back(0.7 * std::pow(u, 1.3));
  EXPECT_NEAR(measure::growth_exponent(x, y), 1.3, 1e-12);
}

TEST(Growth, HasNoExponentWhereQuartilesOverlap) {
  measure::PhaseGrowth clear{.name = "clear"};
  measure::PhaseGrowth noisy{.name = "noisy"};
  for (const double tets : {1e4, 1e5}) {
    clear.add(tets, measure::measure_of("", {0.9 * tets, tets, 1.1 * tets}));
    noisy.add(tets, measure::measure_of("", {0.01 * tets, tets, 20.0 * tets}));
  }
  measure::Section section;
  measure::describe_growth(section, "Work", {clear, noisy});
  EXPECT_NE(section.why.find("(1 is linear): clear 1.00; no exponent where quartiles of neighbouring sizes "
                             "overlap: noisy"),
            std::string::npos)
      << section.why;
}

TEST(Growth, CountsMemoryThatIsUsedAgain) {
  const std::size_t before = measure::allocated_bytes();
  if (before == 0) GTEST_SKIP() << "another allocator than glibc's";
  for (int time = 0; time < 2; ++time) {  // the second time reuses the pages of the first
    const std::vector<double> values(1 << 20, 1.0);
    EXPECT_GE(measure::allocated_bytes(), before + values.size() * sizeof(double));
  }
  EXPECT_LT(measure::allocated_bytes(), before + (1 << 20));
}

class BenchScaling : public CommandTest {
 protected:
  [[nodiscard]] Json section(const std::string& id) const {
    const Json report =
        json_of({"bench", "scaling", "--most-tets", "40000", "--only", id, "--out", "out", "--json"});
    EXPECT_EQ(report["kind"], "scaling");
    EXPECT_EQ(report["effort"], "quick");
    EXPECT_EQ(report, Json::parse(read("out/report.json")));
    return report["sections"].at(0);
  }
};

TEST_F(BenchScaling, TellsTimeAndMemoryBySize) {
  const Json section = this->section("growth");
  const Json& rows = section["table"]["rows"];
  ASSERT_EQ(rows.size(), 2U) << "10000 and 32400 tets; larger ones are left out";
  EXPECT_EQ(rows[0][0], 10000);
  EXPECT_EQ(rows[0][1], 4840) << "Table 1 of the paper";
  EXPECT_EQ(rows[1][0], 18 * 18 * 20 * 5);
  for (const Json& row : rows) {
    if (row[13].is_null()) continue;  // another allocator than glibc's
    EXPECT_GE(row[13].get<double>(), 16.0) << "bytes of the meshes a tet: four indices at least";
  }
  EXPECT_NE(section["why"].get<std::string>().find("whole "), std::string::npos);
  for (const Json& measure : section["measures"]) {
    EXPECT_GE(measure["samples"], 3) << measure;
    EXPECT_LE(measure["least"], measure["median"]) << measure;
    EXPECT_LE(measure["median"], measure["most"]) << measure;
  }
}

TEST_F(BenchScaling, ThreadsFindTheSame) {
  const Json first = section("threads");
  EXPECT_EQ(first["table"]["rows"][0][1], 1);
  EXPECT_EQ(first["table"]["rows"][0][3], 1.0) << "one thread is as fast as one thread";
}

TEST_F(BenchScaling, AStepHasAllItsPhases) {
  const Json growth = section("step-growth");
  ASSERT_FALSE(growth["table"]["rows"].empty());
  for (const Json& row : growth["table"]["rows"]) {
    EXPECT_GE(row[3].get<double>(), 1.0) << "solves a step";
    const double phases = row[5].get<double>() + row[6].get<double>();
    EXPECT_GT(row[4].get<double>(), 0.0);
    EXPECT_GT(row[6].get<double>(), 0.0);
    EXPECT_LT(phases, 1.5 * row[7].get<double>()) << "medians of parts are about those of the whole";
  }
}

TEST_F(BenchScaling, RefusesWhatIsNotThere) {
  expect_error(2, {"bench", "scaling", "--only", "speed"}, {"--only: found 'speed'", "growth"});
  expect_error(2, {"bench", "scaling", "--most-tets", "many"}, {"--most-tets: found 'many'"});
  std::filesystem::create_directory(folder_ / "out");
  write("out/report.json", "kept");
  expect_error(2, {"bench", "scaling", "--most-tets", "9999", "--out", "out"},
               {"--most-tets: found '9999', expected at least 10000"});
  EXPECT_EQ(read("out/report.json"), "kept");
}

TEST_F(BenchPaper, RefusesWhatIsNotThere) {
  expect_error(2, {"bench", "paper", "--scenes", "nowhere"}, {"nowhere/stacking.json"});
  expect_error(2, {"bench", "paper", "--only", "figure-9"}, {"--only: found 'figure-9'", "figure-6"});
  expect_error(2, {"bench"}, {"no subcommand", "paper"});
  expect_error(2, {"bench", "paper", "--quick", "--full"}, {"--quick"});
}

}  // namespace
}  // namespace palpate::test
