#include <algorithm>
#include <map>

#include <palpate/version.hpp>

#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

class Run : public CommandTest {
 protected:
  void SetUp() override { write("scene.json", falling_box()); }

  /// The files that a .pvd lists.
  [[nodiscard]] std::vector<std::string> listed_frames(const std::string& folder) const {
    std::vector<std::string> files;
    const std::string text = read(folder + "/frames.pvd");
    for (std::size_t at = 0; (at = text.find("file=\"", at)) != std::string::npos;) {
      at += 6;
      files.push_back(text.substr(at, text.find('"', at) - at));
    }
    return files;
  }
  /// The rows of a table, each a map from the names in its first line.
  static std::vector<std::map<std::string, std::string>> rows_of(const std::string& table) {
    const auto lines = lines_of(table);
    const auto names = fields_of(lines.at(0));
    std::vector<std::map<std::string, std::string>> rows;
    for (std::size_t line = 1; line < lines.size(); ++line) {
      const auto fields = fields_of(lines[line]);
      auto& row = rows.emplace_back();
      for (std::size_t i = 0; i < std::min(names.size(), fields.size()); ++i) row[names[i]] = fields[i];
    }
    return rows;
  }
};

TEST_F(Run, LeavesAllResultsAndSaysWhere) {
  const std::string summary = output_of({"run", "scene.json"});
  for (const char* part :
       {"falling box: 10 steps, 0.1 s simulated, at rest", "contacts", "crossings", "ms per step", "  grid",
        "  border edges", "  depth", "  forces", "  solver", "converged     in 10 of 10 steps", "state hash",
        "results/falling-box/frames.pvd (4 frames)", "results/falling-box/metrics.csv",
        "results/falling-box/run.json", "results/falling-box/picture.png"}) {
    EXPECT_NE(summary.find(part), std::string::npos) << part << " is not in:\n" << summary;
  }
  const auto frames = listed_frames("results/falling-box");
  EXPECT_EQ(frames.size(), 4U) << "steps 0, 4, 8 and the last, 10";
  for (const std::string& frame : frames) EXPECT_TRUE(exists("results/falling-box/" + frame)) << frame;
  const std::string picture = read("results/falling-box/picture.png");
  EXPECT_TRUE(picture.starts_with("\x89PNG\r\n\x1a\n"));
  EXPECT_EQ(picture.substr(16, 8), std::string("\0\0\0\xa0\0\0\0\x78", 8)) << "160 x 120, as the scene says";
}

TEST_F(Run, MetricsHaveARowForEachStepAndUnits) {
  output_of({"run", "scene.json", "--no-picture", "--out", "out"});
  const auto lines = lines_of(read("out/metrics.csv"));
  ASSERT_EQ(lines.size(), 12U);
  const std::vector<std::string> names{"step",
                                       "time [s]",
                                       "wall_grid [s]",
                                       "wall_contacts [s]",
                                       "wall_border_edges [s]",
                                       "wall_crossings [s]",
                                       "wall_depth [s]",
                                       "wall_forces [s]",
                                       "wall_solver [s]",
                                       "wall_step [s]",
                                       "contacts",
                                       "border_edges",
                                       "crossings",
                                       "edge_contacts",
                                       "unseen_pairs",
                                       "candidates",
                                       "movers",
                                       "depth_fallbacks",
                                       "raised_depths",
                                       "cancelled_directions",
                                       "regions_without_border",
                                       "border_edges_without_crossing",
                                       "folded_pairs",
                                       "approximated_primitives",
                                       "dropped_cells",
                                       "late_clusters",
                                       "rough_depths",
                                       "completeness",
                                       "looks_ahead",
                                       "sort",
                                       "cuckoo_occupancy",
                                       "cuckoo_retries",
                                       "cuckoo_growths",
                                       "detections",
                                       "speculative_contacts",
                                       "stopped_passes",
                                       "passes",
                                       "pairs_that_could_pass",
                                       "solves",
                                       "solver_iterations",
                                       "solver_converged",
                                       "substeps",
                                       "order",
                                       "inverted_tets",
                                       "kinetic_energy [J]",
                                       "elastic_energy [J]",
                                       "largest_speed [m/s]",
                                       "fastest_body [m/s]",
                                       "deepest [m]",
                                       "thinnest [m]",
                                       "normal_force [N]",
                                       "largest_contact_force [N]"};
  EXPECT_EQ(fields_of(lines[0]), names);
  std::size_t most_contacts = 0;
  const auto rows = rows_of(read("out/metrics.csv"));
  for (std::size_t row = 0; row < rows.size(); ++row) {
    ASSERT_EQ(fields_of(lines[row + 1]).size(), names.size()) << lines[row + 1];
    EXPECT_EQ(rows[row].at("step"), std::to_string(row));
    EXPECT_NEAR(std::stod(rows[row].at("time [s]")), 0.01 * static_cast<double>(row), 1e-15);
    EXPECT_EQ(rows[row].at("solver_converged"), "1");
    EXPECT_EQ(rows[row].at("inverted_tets"), "0");
    most_contacts = std::max<std::size_t>(most_contacts, std::stoul(rows[row].at("contacts")));
  }
  EXPECT_GT(most_contacts, 0U) << "1 mm of fall takes 15 ms";
  // Implicit Euler from rest: v1 = g h less damping, and no contact yet.
  EXPECT_NEAR(std::stod(rows[1].at("largest_speed [m/s]")), 9.81 * 0.01 / (1.0 + 0.01), 1e-4);
}

TEST_F(Run, MetricsShowTheSwitchFromRepairToRadixAndBackInTheSceneOfTheFallingBall) {
  // The shipped scene: the ball hangs, falls so fast that many points change their cell in a step, and rests.
  // Without coherence, since coherence skips sorts and discards the last order.
  output_of({"run", PALPATE_SOURCE_DIR "/scenes/ball-on-plate.json", "--set", "contact.coherence=false",
             "--steps", "60", "--no-picture", "--out", "out"});
  std::vector<std::string> sorts;  // in order, without repetitions
  double points = 0.0;
  for (const auto& row : rows_of(read("out/metrics.csv"))) {
    const std::string& sort = row.at("sort");
    const double movers = std::stod(row.at("movers"));
    if (sorts.empty()) points = movers;  // all of them, in a new domain
    if (sorts.empty() || sorts.back() != sort) sorts.push_back(sort);
    EXPECT_TRUE(movers <= 0.14 * points || sort == "radix") << row.at("step");
    EXPECT_TRUE(movers >= 0.10 * points || sort == "repair") << row.at("step");
  }
  EXPECT_GT(points, 500.0);
  ASSERT_GE(sorts.size(), 4U);
  const std::vector<std::string> first(sorts.begin(), sorts.begin() + 4);
  EXPECT_EQ(first, (std::vector<std::string>{"radix", "repair", "radix", "repair"}))
      << "the first frame has no last order";
  EXPECT_EQ(sorts.back(), "repair");
}

TEST_F(Run, ReportsHowFullCuckooTablesAreAndWhatTheyTook) {
  const Json compact = json_of({"run", "scene.json", "--json", "--no-picture", "--out", "out"});
  EXPECT_TRUE(compact["cuckoo"].is_null());
  EXPECT_EQ(rows_of(read("out/metrics.csv")).back().at("cuckoo_occupancy"), "0.0000");
  const Json cuckoo =
      json_of({"run", "scene.json", "--structure", "cuckoo", "--json", "--no-picture", "--out", "out"});
  for (const char* of : {"points", "edges"}) {
    const Json& table = cuckoo["cuckoo"][of];
    EXPECT_GT(table["cells"], 0) << of;
    EXPECT_EQ(table["slots"], 576 * table["buckets"].get<int>()) << of;
    EXPECT_EQ(table["buckets"], (table["cells"].get<int>() + 408) / 409) << of;
    EXPECT_EQ(table["occupancy"], table["cells"].get<double>() / table["slots"].get<double>()) << of;
    EXPECT_GE(table["occupancy"], table["lowest_occupancy"]) << of;
    EXPECT_LE(table["occupancy"], table["highest_occupancy"]) << of;
    EXPECT_EQ(table["growths"]["total"], 0) << of;
    EXPECT_TRUE(table["bucket_retries"].contains("total") && table["redistributions"].contains("total"))
        << of;
  }
  const auto last = rows_of(read("out/metrics.csv")).back();
  EXPECT_NEAR(std::stod(last.at("cuckoo_occupancy")), cuckoo["cuckoo"]["points"]["occupancy"].get<double>(),
              5e-5);
  EXPECT_EQ(last.at("cuckoo_retries") + last.at("cuckoo_growths"), "00")
      << "tables so empty need no second try";
  EXPECT_EQ(last.at("sort"), "none") << "cuckoo does not sort points";
}

TEST_F(Run, ReportHoldsWhatARunIsComparedBy) {
  const std::string out = output_of({"run", "scene.json", "--json", "--out", "out", "--threads", "2"});
  EXPECT_EQ(out, read("out/run.json"));
  const Json report = Json::parse(out);
  for (const char* key : {"version",
                          "commit",
                          "compiler",
                          "build_type",
                          "machine",
                          "threads",
                          "scene_file",
                          "steps",
                          "most_steps",
                          "simulated_time",
                          "at_rest",
                          "interrupted",
                          "error",
                          "state_hash",
                          "wall_seconds",
                          "phases",
                          "contacts",
                          "border_edges",
                          "crossings",
                          "candidates",
                          "movers",
                          "depth_fallbacks",
                          "solver",
                          "kinetic_energy",
                          "raised_depths",
                          "cancelled_directions",
                          "regions_without_border",
                          "border_edges_without_crossing",
                          "folded_pairs",
                          "cuckoo",
                          "elastic_energy",
                          "largest_speed",
                          "fastest_body",
                          "deepest",
                          "resolved",
                          "results",
                          "bodies",
                          "scene"}) {
    EXPECT_TRUE(report.contains(key)) << key;
  }
  EXPECT_EQ(report["version"], PALPATE_VERSION);
  EXPECT_EQ(report["threads"], 2);
  EXPECT_EQ(report["steps"], 10);
  EXPECT_EQ(report["interrupted"], false);
  EXPECT_TRUE(report["error"].is_null());
  EXPECT_EQ(report["state_hash"].get<std::string>().size(), 16U);
  EXPECT_EQ(report["phases"].size(), 8U);
  EXPECT_GT(report["phases"]["solver"]["median_ms"], 0.0);
  EXPECT_GT(report["resolved"]["stiffness"]["min"], 0.0);
  EXPECT_EQ(report["bodies"][1]["name"], "box");
  EXPECT_NEAR(report["bodies"][1]["mass"], 1000 * 0.06 * 0.06 * 0.02, 1e-12);
  EXPECT_EQ(report["bodies"][1]["tets"], 45);
  EXPECT_EQ(report["results"]["frames"], 4);
  EXPECT_EQ(report["results"]["picture"], "picture.png");
}

TEST_F(Run, TheReportsSceneRunsToTheSameState) {
  write("scene.json", falling_box(R"(, "contact": {"friction": 0.2})"));
  const Json first =
      json_of({"run", "scene.json", "--json", "--no-picture", "--every", "3", "--cell-size", "0.03"});
  EXPECT_EQ(first["scene"]["output"]["every"], 3);
  EXPECT_EQ(first["scene"]["contact"]["cell_size"], 0.03);
  EXPECT_EQ(first["resolved"]["cell_size"], 0.03);
  write("again.json", first["scene"].dump());
  const Json second = json_of({"run", "again.json", "--json", "--no-picture"});
  EXPECT_EQ(second["state_hash"], first["state_hash"]);
  EXPECT_EQ(second["scene"], first["scene"]);
}

TEST_F(Run, TheSameBitsForEveryThreadCountAndStructure) {
  const auto hash = [&](std::vector<std::string> flags) {
    std::vector<std::string> arguments{"run",     "scene.json", "--json", "--no-picture",
                                       "--steps", "30",         "--out",  "o"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const Json report = json_of(arguments);
    EXPECT_GT(report["contacts"]["last"], 0) << "there must be contacts for this to mean something";
    return report["state_hash"].get<std::string>();
  };
  const std::string one = hash({"--threads", "1"});
  EXPECT_EQ(hash({"--threads", "2"}), one);
  EXPECT_EQ(hash({"--threads", "3"}), one);
  EXPECT_EQ(hash({"--structure", "brute"}), one);
  EXPECT_EQ(hash({"--structure", "cuckoo", "--order", "z"}), one);
  EXPECT_EQ(hash({"--structure", "hash"}), one);
  EXPECT_EQ(hash({"--structure", "uniform"}), one);
  EXPECT_EQ(hash({"--cell-size", "0.005", "--order", "linear", "--sort", "radix"}), one);
  EXPECT_NE(hash({"--steps", "29"}), one);
}

TEST_F(Run, UntilRestEndsAtRestOrAtTheCap) {
  // Nothing moves without gravity: at rest after as many steps as the scene asks for.
  write("still.json", falling_box(R"(, "gravity": [0, 0, 0], "rest": {"time": 0.06})"));
  const Json still = json_of({"run", "still.json", "--until-rest", "--json", "--no-picture"});
  EXPECT_EQ(still["steps"], 6);
  EXPECT_EQ(still["at_rest"], true);
  const Json capped =
      json_of({"run", "still.json", "--until-rest", "--steps", "3", "--json", "--no-picture"});
  EXPECT_EQ(capped["steps"], 3);
  EXPECT_EQ(capped["at_rest"], false);
  const Json landed = json_of({"run", "scene.json", "--until-rest", "--json", "--no-picture"});
  EXPECT_LT(landed["steps"], 10) << "it falls 0.05 mm and stays";
  EXPECT_EQ(landed["at_rest"], true);
  write("falling.json", falling_box(R"(, "gravity": [0, 0, 9.81])"));
  const Json falling = json_of({"run", "falling.json", "--until-rest", "--json", "--no-picture"});
  EXPECT_EQ(falling["steps"], 10) << "the scene's duration";
  EXPECT_EQ(falling["at_rest"], false);
}

TEST_F(Run, NoStepsWriteTheStart) {
  const Json report =
      json_of({"run", "scene.json", "--steps", "0", "--json", "--no-picture", "--out", "out"});
  EXPECT_EQ(report["steps"], 0);
  EXPECT_EQ(report["results"]["frames"], 1);
  EXPECT_TRUE(report["results"]["picture"].is_null());
  EXPECT_FALSE(exists("out/picture.png"));
  EXPECT_EQ(lines_of(read("out/metrics.csv")).size(), 2U);
}

TEST_F(Run, AnEarlierRunLeavesNoTrace) {
  output_of({"run", "scene.json", "--every", "1", "--out", "out"});
  EXPECT_TRUE(exists("out/frames/frame_000010.vtu"));
  output_of({"run", "scene.json", "--steps", "3", "--no-picture", "--out", "out"});
  EXPECT_EQ(listed_frames("out").size(), 2U);
  EXPECT_EQ(names_in(folder_ / "out/frames").size(), 2U);
  EXPECT_FALSE(exists("out/picture.png"));
  auto names = names_in(folder_ / "out");
  std::ranges::sort(names);
  EXPECT_EQ(names,
            (std::vector<std::string>{"forces.csv", "frames", "frames.pvd", "metrics.csv", "run.json"}));
}

/// A ball at 10 m/s and steps of 5 ms goes 5 cm a step, through a plate of 1 cm.
TEST_F(Run, SaysWherePointsGoFurtherThanBodiesAreThin) {
  const auto scene = [](const char* speed) {
    return std::string(
               R"({"name": "shot", "time_step": 0.005, "duration": 0.02, "gravity": [0, 0, 0], "bodies": [
      {"name": "plate", "obstacle": true, "box": {"cells": [4, 4, 1], "size": [0.04, 0.04, 0.01]}},
      {"name": "ball", "ball": {"radius": 0.01, "resolution": 2}, "translate": [0, 0, 0.08],
       "velocity": [0, 0, )") +
           speed + R"(], "material": {"young_modulus": 1e5}}]})";
  };
  write("fast.json", scene("-10"));
  const Finished fast =
      palpate({"run", "fast.json", "--no-picture", "--out", "fast", "--set", "contact.continuous=off"});
  EXPECT_EQ(fast.exit_code, 0);
  EXPECT_NE(fast.out.find("in 1 step something may have gone through a body ("), std::string::npos)
      << fast.out;
  const Json through = Json::parse(read("fast/run.json"));
  EXPECT_GE(through["steps_too_far"], 1);
  EXPECT_LT(through["steps_too_far"], 4) << "those in which it is near the plate";
  EXPECT_NEAR(through["thinnest"].get<double>(), 0.006, 1e-4) << "the mean edge of the ball";
  const Finished stopped = palpate({"run", "fast.json", "--no-picture", "--out", "stopped"});
  EXPECT_EQ(stopped.out.find("too far"), std::string::npos) << stopped.out;
  EXPECT_EQ(Json::parse(read("stopped/run.json"))["steps_too_far"], 0) << "looked at over the whole step";
  write("slow.json", scene("-0.1"));
  const Finished slow = palpate({"run", "slow.json", "--no-picture", "--out", "slow"});
  EXPECT_EQ(slow.out.find("too far"), std::string::npos) << slow.out;
  EXPECT_EQ(Json::parse(read("slow/run.json"))["steps_too_far"], 0);
}

TEST_F(Run, QuietSaysNothing) {
  const Finished done = palpate({"run", "scene.json", "--quiet", "--no-picture"});
  EXPECT_EQ(done.exit_code, 0);
  EXPECT_EQ(done.out + done.err, "");
  EXPECT_TRUE(exists("results/falling-box/run.json"));
}

TEST_F(Run, NamesOfScenesBecomeSafeFolders) {
  std::string text = falling_box();
  text.replace(text.find("falling box"), 11, "../../a b/c");
  write("scene.json", text);
  output_of({"run", "scene.json", "--steps", "1", "--no-picture"});
  EXPECT_EQ(names_in(folder_ / "results"), (std::vector<std::string>{"-.-..-a-b-c"}));
  text.replace(text.find("\"name\": \"../../a b/c\","), 22, "");
  write("plain.json", text);
  output_of({"run", "plain.json", "--steps", "1", "--no-picture"});
  EXPECT_TRUE(exists("results/plain/run.json")) << "a scene without a name has that of its file";
}

TEST_F(Run, MeshPathsCountFromTheScene) {
  std::filesystem::create_directories(folder_ / "scenes/meshes");
  output_of({"generate", "box", "--cells", "2", "2", "2", "--size", "0.05", "0.05", "0.05", "--out",
             "scenes/meshes/box.vtu"});
  write("scenes/scene.json",
        R"({"name": "from file", "bodies": [{"mesh": "meshes/box.vtu", "material": {}}]})");
  const Json report = json_of({"run", "scenes/scene.json", "--steps", "2", "--json", "--no-picture"});
  EXPECT_EQ(report["bodies"][0]["tets"], 40);
  EXPECT_EQ(report["bodies"][0]["format"], "VTK XML");
  EXPECT_NE(report["bodies"][0]["file"].get<std::string>().find("meshes/box.vtu"), std::string::npos);
}

TEST_F(Run, TakesTheViewsOfAScene) {
  std::string scene = falling_box();
  const std::string picture = R"("picture": {"size": [160, 120]})";
  scene.replace(scene.find(picture), picture.size(), picture + R"(, "views": [
      {"name": "cut", "size": [100, 80], "cut": {"point": [0, 0, 0], "normal": [1, 0, 0]}},
      {"name": "before-after", "size": [101, 60], "when": "both", "displacement": {"most": 0.001}, "contacts": true}])");
  write("views.json", scene);
  const std::string summary = output_of({"run", "views.json", "--out", "out"});
  EXPECT_NE(summary.find("out/before-after.png"), std::string::npos) << summary;
  EXPECT_EQ(read("out/cut.png").substr(16, 8), std::string("\0\0\0\x64\0\0\0\x50", 8));
  EXPECT_EQ(read("out/before-after.png").substr(16, 8), std::string("\0\0\0\x65\0\0\0\x3c", 8));
  const Json report = Json::parse(read("out/run.json"));
  EXPECT_EQ(report["results"]["views"], Json::parse(R"(["cut.png", "before-after.png"])"));
  EXPECT_EQ(report["touching"][0]["bodies"], Json::parse(R"(["plate", "box"])"));
  const Json& box = report["bodies"][1];
  EXPECT_EQ(box["inverted_tets"], 0);
  EXPECT_LT(box["displacement"]["mean"][2], 0.0) << "it fell";
  EXPECT_LE(box["displacement"]["mean_length"], box["displacement"]["largest"]);
  output_of({"run", "views.json", "--out", "out", "--no-picture"});
  EXPECT_FALSE(exists("out/cut.png")) << "what an earlier run left is not a result of this one";
}

}  // namespace
}  // namespace palpate::test
