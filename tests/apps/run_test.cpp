#include <algorithm>

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
};

TEST_F(Run, LeavesAllResultsAndSaysWhere) {
  const std::string summary = output_of({"run", "scene.json"});
  for (const char* part :
       {"falling box: 10 steps, 0.1 s simulated, not at rest", "contacts", "crossings", "ms per step",
        "  grid", "  border edges", "  depth", "  forces", "  solver", "solver cap    hit in 0 steps",
        "state hash", "results/falling-box/frames.pvd (4 frames)", "results/falling-box/metrics.csv",
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
                                       "candidates",
                                       "movers",
                                       "depth_fallbacks",
                                       "approximated_primitives",
                                       "dropped_cells",
                                       "sort",
                                       "solves",
                                       "solver_iterations",
                                       "solver_converged",
                                       "kinetic_energy [J]",
                                       "elastic_energy [J]",
                                       "largest_speed [m/s]",
                                       "fastest_body [m/s]",
                                       "deepest [m]"};
  EXPECT_EQ(fields_of(lines[0]), names);
  std::size_t most_contacts = 0;
  for (std::size_t row = 1; row < lines.size(); ++row) {
    const auto fields = fields_of(lines[row]);
    ASSERT_EQ(fields.size(), names.size()) << lines[row];
    EXPECT_EQ(fields[0], std::to_string(row - 1));
    EXPECT_NEAR(std::stod(fields[1]), 0.01 * static_cast<double>(row - 1), 1e-15);
    EXPECT_EQ(fields[21], "1");
    most_contacts = std::max<std::size_t>(most_contacts, std::stoul(fields[10]));
  }
  EXPECT_GT(most_contacts, 0U) << "1 mm of fall takes 15 ms";
  // Implicit Euler from rest: v1 = g h less damping, and no contact yet.
  EXPECT_NEAR(std::stod(fields_of(lines[2])[24]), 9.81 * 0.01 / (1.0 + 0.01), 1e-4);
}

TEST_F(Run, ReportHoldsWhatARunIsComparedBy) {
  const std::string out = output_of({"run", "scene.json", "--json", "--out", "out", "--threads", "2"});
  EXPECT_EQ(out, read("out/run.json"));
  const Json report = Json::parse(out);
  for (const char* key :
       {"version",        "commit",        "compiler",     "build_type",      "machine",  "threads",
        "scene_file",     "steps",         "most_steps",   "simulated_time",  "at_rest",  "interrupted",
        "error",          "state_hash",    "wall_seconds", "phases",          "contacts", "border_edges",
        "crossings",      "candidates",    "movers",       "depth_fallbacks", "solver",   "kinetic_energy",
        "elastic_energy", "largest_speed", "fastest_body", "deepest",         "resolved", "results",
        "bodies",         "scene"}) {
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
  const Json falling = json_of({"run", "scene.json", "--until-rest", "--json", "--no-picture"});
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
  EXPECT_EQ(names, (std::vector<std::string>{"frames", "frames.pvd", "metrics.csv", "run.json"}));
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

}  // namespace
}  // namespace palpate::test
