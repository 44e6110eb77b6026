// Messages of pages. Oracle: the documented messages, and a fuzz in which only Error may be thrown.
#include "view/command.hpp"

#include <gtest/gtest.h>
#include <string>
#include <vector>

#include <palpate/error.hpp>

#include "view/fuzz.hpp"

namespace palpate::view {
namespace {

template <class What>
What parsed(const std::string& text) {
  return std::get<What>(parse_command(text));
}

TEST(Command, ReadsEachAsDocumented) {
  EXPECT_FALSE(parsed<Play>(R"({"play": {"on": false}})").on);
  parsed<StepOnce>(R"({"step": {}})");
  parsed<Reset>(R"({"reset": {}})");
  EXPECT_EQ(parsed<SetSpeed>(R"({"speed": {"speed": 0.5}})").speed, 0.5);
  EXPECT_EQ(parsed<SetSpeed>(R"({"speed": {"speed": "max"}})").speed, std::nullopt);
  const auto pull = parsed<Pull>(R"({"pull": {"vertex": 7, "target": [1, 2, 3], "strength": 2}})");
  EXPECT_EQ(pull.vertex, 7);
  EXPECT_EQ(pull.target, (Vec3{1, 2, 3}));
  EXPECT_EQ(pull.strength, 2.0);
  EXPECT_EQ(parsed<MovePull>(R"({"move_pull": {"target": [1, 2, 3]}})").target, (Vec3{1, 2, 3}));
  parsed<LetGo>(R"({"let_go": {}})");
  const auto command = parsed<DriveMotion>(R"({"drive_motion": {"motion": 1, "offset": [0, 0, 1]}})");
  EXPECT_EQ(command.time, std::nullopt);
  EXPECT_EQ(command.offset, (Vec3{0, 0, 1}));
  EXPECT_EQ(parsed<ResumeMotion>(R"({"resume_motion": {"motion": 1}})").motion, 1);
  EXPECT_EQ(parsed<Seek>(R"({"seek": {"frame": 3}})").frame, 3);
  EXPECT_EQ(parsed<DisplayOptions>(R"({"look": {"borders": true}})"), (DisplayOptions{false, true, false}));
  EXPECT_EQ(parsed<DisplayOptions>(R"({"look": {"fields": ["von_mises", "stress_xy"]}})").fields,
            (std::vector<std::string>{"von_mises", "stress_xy"}));
  EXPECT_TRUE(parsed<DisplayOptions>(R"({"look": {"inside": true}})").inside);
  EXPECT_EQ(parsed<Shown>(R"({"shown": {"frame": 12}})").frame, 12.0);
}

TEST(Command, RefusesWhatIsNone) {
  const std::vector<std::string> wrong{
      "",
      "hello",
      "[]",
      "{}",
      R"({"play": {}})",
      R"({"play": {"on": 1}})",
      R"({"play": {"on": true}, "reset": {}})",
      R"({"play": {"on": true, "loud": true}})",
      R"({"explode": {}})",
      R"({"pull": {"vertex": -1, "target": [0, 0, 0]}})",
      R"({"pull": {"vertex": 1.5, "target": [0, 0, 0]}})",
      R"({"pull": {"vertex": 1, "target": [0, 0]}})",
      R"({"pull": {"vertex": 1, "target": [0, 0, 1e999]}})",
      R"({"pull": {"vertex": 1, "target": [0, 0, 0], "strength": 1e9}})",
      R"({"speed": {"speed": 0}})",
      R"({"seek": {"frame": 99999999999}})",
      R"({"look": {"fields": "von_mises"}})",
      R"({"look": {"fields": ["stress"]}})",
      R"({"look": {"fields": ["stress_zx"]}})",
      R"({"look": {"fields": ["depth", "von_mises", "pressure", "volume_ratio", "energy_density"]}})",
      R"({"change": {"gravity": [0, 0]}})",
      R"({"change": {"contact": {"structure": "tree"}}})",
      R"({"change": {"contact": {"friction": -1}}})",
      R"({"change": {"time_step": 1}})",
  };
  for (const std::string& text : wrong) EXPECT_THROW(static_cast<void>(parse_command(text)), Error) << text;
}

TEST(Command, ChangesWhatItNamesAndNothingElse) {
  SimulationSettings settings;
  settings.response.stiffness = 100.0;
  settings.response.friction = 0.25;
  settings.detection.cells_per_primitive = 8;
  const auto change = parsed<Change>(
      R"({"change": {"gravity": [0, 1, 0], "contact": {"sort": "radix", "stiffness": "auto", "cells_per_primitive": 3}}})");
  const SimulationSettings after = changed(settings, change.settings);
  EXPECT_EQ(after.gravity, (Vec3{0, 1, 0}));
  EXPECT_EQ(after.detection.sort, Sort::radix);
  EXPECT_EQ(after.detection.cells_per_primitive, 3);
  EXPECT_EQ(after.response.stiffness, std::nullopt) << "the word stands for none";
  EXPECT_EQ(after.response.friction, 0.25);
  const SimulationSettings limited = changed({}, {{"contact", {{"budget", {{"milliseconds", 0.5}}}}}});
  EXPECT_EQ(limited.detection.budget.value().milliseconds, 0.5);
  EXPECT_EQ(changed(limited, {{"gravity", {0, 0, 0}}}).detection.budget, limited.detection.budget);
  EXPECT_EQ(changed(limited, {{"contact", {{"budget", nullptr}}}}).detection.budget, std::nullopt);
  EXPECT_EQ(changed({}, settings_json(after)).detection, after.detection) << "what is told can be set";
}

TEST(Command, AFuzzOfAHundredThousandEndsInErrorsOnly) {
  test::Fuzz fuzz(1);
  std::size_t taken = 0;
  std::size_t refused = 0;
  for (int i = 0; i < 100000; ++i) {
    const std::string text = fuzz.message();
    try {
      static_cast<void>(parse_command(text));
      ++taken;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 80000U) << "most must be malformed";
  EXPECT_GT(taken, 100U) << "some must come near enough to pass";
}

}  // namespace
}  // namespace palpate::view
