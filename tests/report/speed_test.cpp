// The tables of `palpate bench speed` from invented figures: ratios by hand, every goal, verdicts at their
// bounds; and the files of a part.
#include <gtest/gtest.h>
#include <set>

#include <palpate/error.hpp>

#include "results/support.hpp"
#include "speed/part.hpp"
#include "speed/rows.hpp"

namespace palpate::bench {
namespace {

Json query_case(const std::string& name, double tets, double ours) {
  return {{"name", name},
          {"tets", tets},
          {"best_target", "AVX3_ZEN4"},
          {"median_ms",
           {{"clustered", ours},
            {"coherent", ours / 2},
            {"clustered, AVX2", ours / 0.75},
            {"Embree: refit, one scene", 40 * ours},
            {"Embree: refit, per body", 30 * ours}}},
          {"smallest_ms", {{"clustered, 1 thread", 3.0}, {"clustered, 2 threads", 2.0}}}};
}

Json query_cases() {
  Json cases = Json::array();
  for (const auto& [name, tets] :
       {std::pair("stacking 10000", 1e4), std::pair("stacking 102400", 102400.0),
        std::pair("stacking 1000000", 1e6), std::pair("pile", 82240.0), std::pair("eye", 10160.0),
        std::pair("skull", 24071.0), std::pair("self-collision", 1e4), std::pair("tubes", 42000.0),
        std::pair("raptors", 27827.0)})
    cases.push_back(query_case(name, tets, tets * 1e-5));
  cases.push_back({{"name", "stacking 9985600"},
                   {"tets", 1e7},
                   {"median_ms", {{"clustered", 200.0}}},
                   {"smallest_ms", {{"clustered", 200.0}}}});
  return cases;
}

Json handling_cases() {
  Json cases =
      Json::array({{{"name", "stacking 10000"},
                    {"border_edges", {{"ms", 0.5}, {"embree_ms", 5.0}, {"embree_mode", "refit, per body"}}}},
                   {{"name", "stacking 10000"},
                    {"clustered", {{"all_ms", 1.2}, {"contacts_ms", 0.2}}},
                    {"points alone", {{"all_ms", 0.8}, {"contacts_ms", 0.2}}}},
                   {{"name", "stacking 10000"},
                    {"at_rest", {{"clustered", {{"all_ms", 1.0}}}, {"coherent", {{"all_ms", 0.6}}}}}}});
  return cases;
}

Json threads_cases() {
  Json cases = Json::array();
  for (const char* name : {"stacking 10000", "stacking 102400", "stacking 1000000", "falling stack", "eye"}) {
    const auto times = [](int threads, double all, double grid) {
      return Json{{"threads", threads},
                  {"all", {{"ms", all}, {"faster", 3.4 / all}}},
                  {"grid", {{"ms", grid}, {"faster", 0.3 / grid}}}};
    };
    cases.push_back({{"name", name},
                     {"times", Json::array({times(1, 3.4, 0.3), times(2, 2.0, 0.4), times(4, 1.0, 0.4)})}});
  }
  return cases;
}

Json instructions_cases() {
  Json cases = Json::array();
  for (const auto& [name, unit] :
       {std::pair("assembly", "tet"), std::pair("depth", "contact"), std::pair("crossings", "border edge"),
        std::pair("whole detection", "tet"), std::pair("step of the falling stack", "tet")}) {
    cases.push_back({{"name", name},
                     {"unit", unit},
                     {"units", 5e5},
                     {"per_unit", 400.0},
                     {"instructions", 2e8},
                     {"parallel", {{"longest_chain", 1.6e7}, {"share", 0.92}}}});
  }
  return cases;
}

Json movers_cases() {
  return Json::array(
      {{{"name", "2 % near"}, {"repair_ms", 0.1}, {"memcpy_ms", 0.02}, {"std_sort_last_order_ms", 3.0}}});
}

Json dynamics_cases() {
  Json cases = Json::array();
  for (const char* name : {"stacking", "skull", "block"}) {
    cases.push_back({{"name", name},
                     {"eigen", {{"update_ms", 10.0}, {"solve_ms", 100.0}, {"preconditioner", "diagonal"}}},
                     {"update_ms", 0.5},
                     {"solve", {{"jacobi", {{"ms", 5.0}}}, {"multigrid", {{"ms", 4.0}}}}},
                     {"product", {{"GB_per_s", 80.0}, {"read_GB_per_s", 100.0}}}});
  }
  return cases;
}

Json step_cases() {
  Json cases = Json::array();
  for (const char* name : {"stacking at rest", "head"}) {
    cases.push_back({{"name", name},
                     {"sofa_scaled_ms", 24.0},
                     {"fixed", {{"ms", 2.0}}},
                     {"converged", {{"auto", {{"ms", 6.0}}}, {"multigrid", {{"ms", 4.0}}}}}});
  }
  return cases;
}

Json tissue_cases() {
  Json cases = Json::array();
  for (const char* name : {"element pass", "step of the eye"})
    cases.push_back({{"name", name}, {"corotational_ms", 2.0}, {"neo_hookean_ms", 5.5}});
  return cases;
}

Json row(const Json& rows, const std::string& work) {
  for (const Json& r : rows)
    if (r.at("work") == work) return r;
  ADD_FAILURE() << "no row '" << work << "' in " << rows.dump(1);
  return {};
}

TEST(SpeedRows, EveryGoalIsMeasuredOnce) {
  std::multiset<std::string> works;
  for (const Json& rows :
       {query_rows(query_cases()), handling_rows(handling_cases()), threads_rows(threads_cases()),
        movers_rows(movers_cases()), dynamics_rows(dynamics_cases()), step_rows(step_cases()),
        tissue_rows(tissue_cases()), instructions_rows(instructions_cases())})
    for (const Json& r : rows) works.insert(r.at("work").get<std::string>());
  std::multiset<std::string> wanted;
  for (const Goal& goal : goals) wanted.insert(std::string(goal.work));
  EXPECT_EQ(works, wanted);
}

TEST(SpeedRows, RatiosAreThoseByHand) {
  const Json query = query_rows(query_cases());
  const Json small = row(query, "contacts, stacking 10000");
  EXPECT_DOUBLE_EQ(small["ratio"], 30.0) << "against the faster mode of Embree";
  EXPECT_EQ(small["other_side"], "Embree, refit, per body");
  EXPECT_EQ(small["verdict"], "met");
  EXPECT_EQ(row(query, "contacts, stacking 1000000")["verdict"], "aim met") << "the aim is 30";
  EXPECT_DOUBLE_EQ(row(query, "contacts with coherence, stacking 10000")["ratio"], 60.0);
  EXPECT_DOUBLE_EQ(row(query, "contacts, 2 threads against 1, stacking 10000")["ratio"], 1.5);
  EXPECT_DOUBLE_EQ(row(query, "contacts, AVX2 against AVX-512, stacking 10000")["ratio"], 75.0);
  EXPECT_DOUBLE_EQ(row(query, "contacts, ns a tet with 10 million against 10000")["ratio"], 2.0);
  const Json handling = handling_rows(handling_cases());
  EXPECT_DOUBLE_EQ(row(handling, "border edges against triangles, stacking 10000")["ratio"], 10.0);
  const Json whole = row(handling, "whole collision handling relative to its contact query, stacking 10000");
  EXPECT_NEAR(whole["ratio"].get<double>(), 6.0, 1e-12);
  EXPECT_EQ(whole["verdict"], "missed") << "at most 5";
  EXPECT_NEAR(
      row(handling, "handling of points alone relative to its contact query, stacking 10000")["ratio"], 4.0,
      1e-12);
  EXPECT_DOUBLE_EQ(
      row(handling, "handling at rest, with coherence relative to without, stacking 10000")["ratio"], 60.0);
  const Json threads = threads_rows(threads_cases());
  EXPECT_EQ(threads.size(), 7U) << "two for each stack; one for the falling one; none for the eye";
  const Json detection = row(threads, "whole detection, 2 threads against 1, stacking 10000");
  EXPECT_DOUBLE_EQ(detection["ratio"], 1.7);
  EXPECT_EQ(detection["verdict"], "met");
  EXPECT_EQ(row(threads, "update of the grid, 2 threads against 1, stacking 10000")["verdict"], "missed");
  const Json instructions = instructions_rows(instructions_cases());
  EXPECT_EQ(instructions.size(), 4U) << "only these have a goal";
  EXPECT_EQ(row(instructions, "crossings, instructions per border edge")["verdict"], "met");
  EXPECT_DOUBLE_EQ(row(instructions, "parallel part of the instructions, whole detection")["ratio"], 92.0);
  const Json movers = movers_rows(movers_cases());
  EXPECT_DOUBLE_EQ(row(movers, "adding 2 % movers, 128k entries, against memcpy")["ratio"], 5.0);
  EXPECT_EQ(row(movers, "adding 2 % movers, 128k entries, against memcpy")["verdict"], "met");
  EXPECT_DOUBLE_EQ(row(movers, "adding 2 % movers, 128k entries, against std::sort")["ratio"], 30.0);
  const Json dynamics = dynamics_rows(dynamics_cases());
  EXPECT_DOUBLE_EQ(row(dynamics, "rotations, forces, assembly: stacking")["ratio"], 20.0);
  EXPECT_DOUBLE_EQ(row(dynamics, "time to an error of 1e-3: skull")["ratio"], 25.0)
      << "our best preconditioner";
  EXPECT_EQ(row(dynamics, "time to an error of 1e-3: skull")["verdict"], "missed");
  EXPECT_DOUBLE_EQ(
      row(dynamics, "product with the matrix relative to reading as much memory: block")["ratio"], 80.0);
  const Json tissue = tissue_rows(tissue_cases());
  EXPECT_DOUBLE_EQ(row(tissue, "stable neo-Hookean over corotational: element pass")["ratio"], 2.75);
  EXPECT_EQ(row(tissue, "stable neo-Hookean over corotational: element pass")["verdict"], "missed");
  EXPECT_EQ(row(tissue, "stable neo-Hookean over corotational: step of the eye")["verdict"], "met");
  const Json step = step_rows(step_cases());
  EXPECT_DOUBLE_EQ(row(step, "step of 25 iterations: head")["ratio"], 12.0);
  EXPECT_EQ(row(step, "step of 25 iterations: head")["verdict"], "aim met");
  EXPECT_DOUBLE_EQ(row(step, "step to an error of 1e-3: stacking at rest")["ratio"], 6.0);
}

TEST(SpeedRows, WhatWasNotMeasuredHasNoRow) {
  EXPECT_EQ(query_rows(Json::array()), Json::array());
  Json one = query_case("stacking 10000", 1e4, 0.1);
  one["best_target"] = "AVX2";
  for (const Json& r : query_rows(Json::array({one})))
    EXPECT_EQ(r.at("work").get<std::string>().find("AVX"), std::string::npos)
        << "without AVX-512 there is nothing to compare AVX2 with";
}

TEST(SpeedRows, TheMiddleReferenceScales) {
  const auto scale = [](double copy, double sort, double chain) {
    return machine_scale({{"memcpy_GB_per_s", copy}, {"sort_ms", sort}, {"multiply_add_ms", chain}});
  };
  EXPECT_DOUBLE_EQ(scale(23.0, 68.0, 70.0), 1.0);
  EXPECT_DOUBLE_EQ(scale(11.5, 136.0, 140.0), 2.0) << "a machine of half the speed";
  EXPECT_DOUBLE_EQ(scale(23.0, 136.0, 7.0), 1.0) << "one is odd to each side";
}

TEST(SpeedRows, TheTextSaysWhatTheRowsSay) {
  const std::string text = table_text(handling_rows(handling_cases()));
  EXPECT_NE(text.find("detection"), std::string::npos);
  EXPECT_EQ(text.find("dynamics"), std::string::npos) << "no rows of it";
  EXPECT_NE(text.find("6×     ≤ 5×   ≤ 2.5×  missed"), std::string::npos) << text;
}

class SpeedPart : public ::testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path file() const { return folder_.path() / "made up.json"; }
  [[nodiscard]] Json written() const { return Json::parse(test::content_of(file())); }
  Json run(std::vector<Case> cases) {
    const Part part{"made up", std::move(cases), [](const Json& c) { return Json{{"rows of", c.size()}}; }};
    return run_part(part, {{"kind", "speed"}}, file(),
                    [this](const std::string& line) { told_.push_back(line); });
  }
  test::TemporaryFolder folder_;
  std::vector<std::string> told_;
};

TEST_F(SpeedPart, WritesWhatItReturns) {
  const Json result = run({{"a", 0,
                            [] {
                              return Json{{"name", "a"}};
                            }},
                           {"b", 0, [] {
                              return Json{{"name", "b"}};
                            }}});
  EXPECT_EQ(result, written());
  EXPECT_EQ(result["kind"], "speed");
  EXPECT_EQ(result["cases"].size(), 2U);
  EXPECT_EQ(result["table"]["rows of"], 2);
  ASSERT_EQ(told_.size(), 2U);
  EXPECT_TRUE(told_[1].starts_with("made up, 2 of 2: b")) << told_[1];
}

TEST_F(SpeedPart, AWrongResultEndsItAndLeavesWhatWasMeasured) {
  const auto wrong = []() -> Json { throw Error("benchmark", "b", "other pairs", "the same"); };
  EXPECT_THROW(run({{"a", 0, [] { return Json{{"name", "a"}}; }}, {"b", 0, wrong}}), Error);
  EXPECT_EQ(written()["cases"].size(), 1U);
  EXPECT_EQ(written()["table"]["rows of"], 1);
}

}  // namespace
}  // namespace palpate::bench
