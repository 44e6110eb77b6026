#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

/// Two balls that overlap by 4 mm; `more` goes into the scene.
std::string overlapping(const std::string& more, const std::string& more_of_bodies = "") {
  std::string scene =
      R"({"name": "overlap", "time_step": 0.01, "duration": 0.05, "gravity": [0, 0, 0], )" + more;
  scene += R"("bodies": [
    {"name": "left", "ball": {"radius": 0.025, "resolution": 6}, "translate": [-0.023, 0, 0], "material": {})";
  scene += more_of_bodies + R"(},
    {"name": "right", "ball": {"radius": 0.025, "resolution": 6}, "translate": [0.023, 0, 0], "material": {})";
  return scene + more_of_bodies + "}]}";
}

class RelaxCommand : public CommandTest {};

TEST_F(RelaxCommand, InfoTellsWhichBodiesOverlap) {
  write("scene.json", overlapping(""));
  EXPECT_NE(output_of({"info", "scene.json"}).find("  left and right: "), std::string::npos);
  const Json json = json_of({"info", "scene.json", "--json"});
  ASSERT_EQ(json["overlaps_at_start"].size(), 1U);
  EXPECT_EQ(json["overlaps_at_start"][0]["bodies"], (Json{"left", "right"}));
  EXPECT_EQ(json["overlaps_at_start"][0]["contacts"], json["contacts_at_start"]);
  EXPECT_GT(json["overlaps_at_start"][0]["deepest"], 0.001);
}

TEST_F(RelaxCommand, RunRemovesOverlapsWhereTheSceneAsksForIt) {
  write("scene.json", overlapping(""));
  EXPECT_TRUE(
      json_of({"run", "scene.json", "--json", "--no-picture", "--out", "as-is"})["relaxed"].is_null());
  write("scene.json", overlapping(R"("relax": {},)"));
  const Json json = json_of({"run", "scene.json", "--json", "--no-picture", "--out", "out"});
  EXPECT_EQ(json["relaxed"]["done"], true);
  EXPECT_GT(json["relaxed"]["deepest_before"], 0.001);
  EXPECT_LE(json["relaxed"]["deepest_after"], json["relaxed"]["allowed_depth"]);
  EXPECT_EQ(json["scene"]["relax"]["depth"], 0.01) << "resolved settings";
  EXPECT_NE(output_of({"run", "scene.json", "--no-picture", "--out", "out"}).find("relaxed       "),
            std::string::npos);
}

TEST_F(RelaxCommand, RunSaysWhatIsLeftAndGoesOn) {
  write("scene.json", overlapping(R"("relax": {"max_steps": 1, "depth": 1e-6},)"));
  const Finished done = palpate({"run", "scene.json", "--no-picture", "--out", "out"});
  EXPECT_EQ(done.exit_code, 0);
  EXPECT_NE(done.err.find("scene.json: overlaps of "), std::string::npos) << done.err;
  EXPECT_NE(done.err.find("are left after relaxing"), std::string::npos) << done.err;
}

}  // namespace
}  // namespace palpate::test
