// Stages and outcomes of scenes. Oracles: the same run driven by hand, closed forms, a weight, a prescribed
// rotation.
#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include <palpate/error.hpp>
#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "scene/load.hpp"
#include "scene/outcome_probe.hpp"
#include "scene/scene.hpp"
#include "scene/stage_run.hpp"

namespace palpate {
namespace {

const std::string bodies = R"("name": "s", "time_step": 0.01, "bodies": [
  {"name": "table", "box": {"cells": [3, 3, 1], "size": [0.4, 0.4, 0.04]}, "translate": [0, 0, -0.02], "obstacle": true},
  {"name": "block", "box": {"cells": [2, 2, 2], "size": [0.1, 0.1, 0.1]}, "translate": [0, 0, 0.07],
   "material": {"young_modulus": 1e5, "stiffness_damping": 0.01}},
  {"name": "rail", "box": {"cells": [1, 1, 1], "size": [0.1, 0.1, 0.02]}, "translate": [0, 0, 0.3], "absent": true,
   "material": {"young_modulus": 1e6, "stiffness_damping": 0.01}},
  {"name": "bone", "box": {"cells": [1, 1, 1], "size": [0.02, 0.02, 0.02]}, "translate": [1, 0, 0], "obstacle": true}])";

Scene staged_scene(const std::string& more) {
  return read_scene_text("{" + bodies + (more.empty() ? "" : ", ") + more + "}", "scene");
}

Simulation simulate(const Scene& scene, int threads = 2) {
  Model model = load_model(scene, [](const std::filesystem::path&) { return TetMesh{}; });
  return Simulation(std::move(model), scene.settings, threads);
}

/// Steps until all stages are over.
void lead(StageRun& stages, Simulation& simulation) {
  for (stages.begin(simulation); !stages.done(); stages.begin(simulation)) {
    simulation.step();
    stages.ends(simulation);
  }
}

std::vector<Index> points_of(const Simulation& simulation, Index body) {
  const Range range = at(simulation.bodies().bodies(), body).points;
  std::vector<Index> points;
  for (Index p = range.begin; p < range.end; ++p) points.push_back(p);
  return points;
}

const std::string three_stages = R"("stages": [
  {"name": "settle", "until": {"rest": true, "most": 1}},
  {"name": "press", "insert": ["rail"], "gravity": [0, 0, -5],
   "move": [{"body": "rail", "motion": {"keyframes": [{"time": 0.2, "translate": [0, 0, -0.205]}]}}],
   "until": {"force": {"body": "block", "from": "rail", "at_least": 3}, "most": 0.5}},
  {"name": "let-go", "release": [{"body": "rail"}],
   "tie": [{"body": "rail", "to": "block", "box": {"lower": [-1, -1, 0], "upper": [1, 1, 0.291]}}],
   "loads": [{"body": "block", "loads": [{"force": [0.1, 0, 0], "points": [0, 1], "ramp": {"times": [0, 0.1], "factors": [0, 1]}}]}],
   "until": {"time": 0.3}}])";

TEST(Stages, AreTheSameRunDrivenByHand) {
  const Scene scene = staged_scene(three_stages);
  EXPECT_EQ(scene.duration, 1.8);
  Simulation led = simulate(scene, 2);
  StageRun stages(scene, led);
  lead(stages, led);
  const auto& endings = stages.progress().endings;
  ASSERT_EQ(endings.size(), 3U);
  EXPECT_TRUE(endings[0].reached && endings[1].reached && endings[2].reached);
  EXPECT_TRUE(stages.warnings().empty());
  EXPECT_EQ(endings[2].step - endings[1].step, 30);

  Simulation hand = simulate(scene, 1);
  while (!hand.at_rest() && hand.metrics().time < 1.0) hand.step();
  EXPECT_EQ(hand.metrics().step, endings[0].step);
  const double settled = hand.metrics().time;
  ModelChange press{.insert = {2}};
  press.moves = {{points_of(hand, 2), {.keyframes = {{.time = settled}, {settled + 0.2, {0, 0, -0.205}}}}}};
  hand.change(press);
  SimulationSettings settings = hand.settings();
  settings.gravity = {0, 0, -5};
  hand.change(settings);
  const auto force_of_rail = [&] {
    for (const PairWrench& pair : hand.pair_wrenches())
      if (pair.body_a == 1 && pair.body_b == 2) return length(pair.on_b.force);
    return 0.0;
  };
  while (force_of_rail() < 3.0 && hand.metrics().time < 2.0) hand.step();
  EXPECT_EQ(hand.metrics().step, endings[1].step);
  ModelChange release{.release_bodies = {2}};
  const Range block = at(hand.bodies().bodies(), 1).points;
  const double now = hand.metrics().time;
  release.loads = {
      {.body = 1,
       .points = {{{block.begin, block.begin + 1}, {0.1, 0, 0}, {{now + 0.0, now + 0.1}, {0.0, 1.0}}}}}};
  release.ties = led.ties();
  EXPECT_EQ(release.ties.size(), 4U);
  for (const Tie& tie : release.ties) {
    EXPECT_EQ(at(hand.bodies().body_of_point(), tie.point), 2);
    EXPECT_EQ(hand.bodies().body_of(at(hand.bodies().tets(), tie.tet)), 1);
  }
  hand.change(release);
  while (hand.metrics().step < endings[2].step) hand.step();
  EXPECT_EQ(hand.state_hash(), led.state_hash());
}

TEST(Stages, BranchFromASavedStateWithTheSameBits) {
  const Scene scene = staged_scene(three_stages);
  Simulation whole = simulate(scene);
  StageRun stages(scene, whole);
  stages.begin(whole);
  std::vector<std::byte> saved;
  StageProgress progress;
  while (!stages.done()) {
    whole.step();
    if (!stages.ends(whole)) continue;
    if (stages.progress().endings.size() == 2) {
      saved = whole.save();
      progress = stages.progress();
    }
    stages.begin(whole);
  }
  Simulation branch = simulate(scene, 1);
  StageRun rest(scene, branch);
  branch.restore(saved);
  rest.resume(branch, progress);
  EXPECT_EQ(branch.settings().gravity, (Vec3{0, 0, -5})) << "what an earlier stage set";
  lead(rest, branch);
  EXPECT_EQ(branch.save(), whole.save());
}

/// A held rail of 0.1 x 0.1 x 0.02 is placed in the table, whose top is at z = 0.
TEST(Stages, ThatPutABodyIntoARigidOneSaySo) {
  const auto warnings = [](double height) {
    const Scene scene =
        staged_scene(R"("stages": [{"name": "put", "insert": ["rail"], "move": [{"body": "rail",
      "motion": {"keyframes": [{"time": 0.02, "translate": [0.12, 0, )" +
                     std::to_string(height - 0.29) + R"(]}]}}], "until": {"time": 0.03}}])");
    Simulation simulation = simulate(scene);
    StageRun stages(scene, simulation);
    lead(stages, simulation);
    return stages.warnings();
  };
  EXPECT_TRUE(warnings(0.001).empty()) << "its lower side is above the table";
  EXPECT_TRUE(warnings(0.0).empty()) << "it lies on it";
  const std::vector<std::string> found = warnings(-0.004);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0], "stage 'put' puts 'rail' into 'table', by 0.004 m at its end");
}

TEST(Stages, EndByTheirTimeAndSaySo) {
  const Scene scene = staged_scene(R"("stages": [
    {"name": "never", "until": {"force": {"body": "block", "at_least": 1e6}, "most": 0.05}},
    {"name": "falls", "remove": ["table"], "until": {"rest": true, "most": 0.1}}])");
  Simulation simulation = simulate(scene);
  StageRun stages(scene, simulation);
  lead(stages, simulation);
  EXPECT_EQ(simulation.metrics().step, 15);
  EXPECT_EQ(stages.warnings(),
            (std::vector<std::string>{"stage 'never' ended after 0.05 s, its force not reached",
                                      "stage 'falls' ended after 0.1 s, not at rest"}));
  EXPECT_FALSE(simulation.is_present(0));
}

TEST(Stages, AreWrittenAndReadAgain) {
  const Scene scene = staged_scene(three_stages + R"(, "outcomes": [
    {"name": "a", "displacement": {"body": "block", "at": [0, 0, 0.07], "along": [0, 0, 1]}},
    {"name": "b", "volume": {"body": "block", "beyond": [{"point": [0, 0, 0], "normal": [0, 0, 1]}], "within": "rail"}},
    {"name": "c", "force": {"body": "block", "from": "table"}}])");
  const std::string text = write_scene(scene);
  EXPECT_EQ(write_scene(read_scene_text(text, "again")), text);
}

/// The message for a scene with these keys more.
std::string refusal(const std::string& more) {
  try {
    const Scene scene = staged_scene(more);
    const Simulation simulation = simulate(scene);
    const StageRun stages(scene, simulation);
    const OutcomeProbe outcomes(scene, simulation.bodies());
    static_cast<void>(stages);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

std::string stage_refusal(const std::string& keys, const std::string& until = R"("until": {"time": 1})") {
  return refusal(R"("stages": [{"name": "a", )" + keys + (keys.empty() ? "" : ", ") + until + "}]");
}

TEST(Stages, BadOnesAreRefusedInOneLine) {
  EXPECT_EQ(stage_refusal(""), "");
  EXPECT_EQ(stage_refusal(R"("remove": ["tabel"])"),
            "scene: stages[0].remove[0]: found 'tabel', expected 'table'");
  EXPECT_EQ(stage_refusal(R"("insert": ["table"])"),
            "scene: stages[0].insert[0]: found 'table', which is in the scene already, expected a body that "
            "was removed, or starts with \"absent\": true");
  EXPECT_EQ(stage_refusal(R"("remove": ["rail"])"),
            "scene: stages[0].remove[0]: found 'rail', which is not in the scene at this stage, expected a "
            "body that is in the scene");
  EXPECT_EQ(stage_refusal(R"("release": [{"body": "table"}])"),
            "scene: stages[0].release[0].body: found 'table', which has no material, expected a body with a "
            "material, so "
            "that it can deform");
  EXPECT_EQ(
      stage_refusal(R"("fix": [{"body": "block", "part": {"sphere": {"center": [9, 0, 0], "radius": 1}}}])"),
      "scene: stages[0].fix[0].part: found no point of 'block', expected one or more points selected");
  EXPECT_EQ(
      stage_refusal(
          R"("move": [{"body": "block", "motion": {"keyframes": [{"time": 0, "translate": [0, 0, 1]}]}}])"),
      "scene: stages[0].move[0].motion.keyframes[0]: found a pose at time 0 that differs from the body's "
      "current pose, "
      "expected a keyframe at a later time; the motion starts at the current pose");
  EXPECT_EQ(
      stage_refusal(
          R"("move": [{"body": "table", "part": {"points": [0]}, "motion": {"keyframes": [{"time": 1}]}}])"),
      "scene: stages[0].move[0].part: found a part of the rigid body 'table', expected no 'part': a rigid "
      "body moves as a whole");
  EXPECT_EQ(
      stage_refusal(R"("fix": [{"body": "table"}])"),
      "scene: stages[0].fix[0].body: found the rigid body 'table', expected a body that deforms; 'move' "
      "with one keyframe lets a rigid body stand still");
  EXPECT_EQ(
      stage_refusal(
          R"("move": [{"body": "table", "motion": {"keyframes": [{"time": 1, "rotate": {"angle": 360}}]}}])"),
      "scene: stages[0].move[0].motion: found a first rotation by more than 180 degrees, expected at "
      "most 180 degrees, since rotations take the shorter arc");
  EXPECT_EQ(stage_refusal(R"("untie": [{"bodies": ["block"]}])"),
            "scene: stages[0].untie[0].bodies: found 1, expected two names");
  EXPECT_EQ(stage_refusal(
                "", R"("until": {"force": {"body": "block", "from": "block", "at_least": 1}, "most": 2})"),
            "scene: stages[0].until.force.from: found the body itself, expected another body, or nothing");
  EXPECT_EQ(stage_refusal(R"("loads": [{"body": "table"}])"),
            "scene: stages[0].loads[0].body: found the rigid body 'table', expected a body that deforms");
  EXPECT_EQ(stage_refusal("", R"("until": {"rest": true})"),
            "scene: stages[0].until.most: found nothing, expected the time after which the stage ends in "
            "any case");
  EXPECT_EQ(stage_refusal("", R"("until": {"time": 1, "most": 2})"),
            "scene: stages[0].until.most: found 'most' together with 'time', expected only one of the two");
  EXPECT_EQ(stage_refusal("", R"("until": {"rest": false, "most": 2})"),
            "scene: stages[0].until.rest: found false, expected true, or another condition");
  EXPECT_EQ(refusal(R"("duration": 3, "stages": [{"name": "a", "until": {"time": 1}}])"),
            "scene: duration: found 3 together with 'stages', expected no 'duration', or the sum of the "
            "limits of the stages, 1");
  EXPECT_EQ(
      refusal(R"("stages": [{"name": "a", "until": {"time": 1}}, {"name": "a", "until": {"time": 1}}])"),
      "scene: stages[1].name: found 'a' for the second time, expected a name that no other has");
  EXPECT_EQ(refusal(R"("stages": [{"name": "a/b", "until": {"time": 1}}])"),
            "scene: stages[0].name: found 'a/b', expected letters, digits, '-' and '_'");
}

TEST(Outcomes, BadOnesAreRefusedInOneLine) {
  const auto of = [](const std::string& what) {
    return refusal(R"("outcomes": [{"name": "o", )" + what + "}]");
  };
  EXPECT_EQ(of(R"("stress": {"body": "block"})"), "");
  EXPECT_EQ(of(R"("stress": {"body": "blok"})"),
            "scene: outcomes[0].stress.body: found 'blok', expected 'block'");
  EXPECT_EQ(of(R"("displacement": {"body": "block", "at": [0, 0, 0.17]})"),
            "scene: outcomes[0].displacement.at: found a position 0.05 outside of 'block', expected a "
            "position in the "
            "body at rest");
  EXPECT_EQ(of(R"("force": {"body": "block", "along": [0, 0, 0]})"),
            "scene: outcomes[0].force.along: found a zero vector, expected a direction");
  EXPECT_EQ(
      of(R"("gap": {"bodies": ["block", "block"]})"),
      "scene: outcomes[0].gap.bodies: found the same name twice, expected the names of two different bodies");
  EXPECT_EQ(of(R"("volume": {"body": "block", "within": "block"})"),
            "scene: outcomes[0].volume.within: found the body itself, expected another body, or nothing");
  EXPECT_EQ(of(R"("cavity": {"body": "blok", "walls": [{"points": [0]}]})"),
            "scene: outcomes[0].cavity.body: found 'blok', expected 'block'");
  EXPECT_EQ(of(R"("cavity": {"body": "block", "walls": []})"),
            "scene: outcomes[0].cavity.walls: found none, expected one or more");
  EXPECT_EQ(of(R"("cavity": {"body": "block", "walls": [{"points": [0]}]})"),
            "scene: outcomes[0].cavity.walls: found no surface triangle, expected one or more");
  EXPECT_EQ(of(R"("cavity": {"body": "block", "walls": [{"points": [0]}, {"points": [99]}]})"),
            "scene: outcomes[0].cavity.walls[1].points[0]: found 99, expected a point index in [0, 26]");
  EXPECT_EQ(
      refusal(
          R"("outcomes": [{"name": "o", "stress": {"body": "block"}}, {"name": "o", "stress": {"body": "block"}}])"),
      "scene: outcomes[1].name: found 'o' for the second time, expected a name that no other has");
}

TEST(Outcomes, OfABlockAtRestAndATurnedRail) {
  const Scene scene = staged_scene(R"("stages": [
    {"name": "rest", "until": {"rest": true, "most": 2}},
    {"name": "turn", "insert": ["rail"],
     "move": [{"body": "rail", "motion": {"center": [0, 0, 0.3], "keyframes": [
       {"time": 0.2, "translate": [0, 0, 0.1], "rotate": {"axis": [0, 0, 1], "angle": 40}}]}}], "until": {"time": 0.3}}],
    "outcomes": [
      {"name": "weight", "force": {"body": "block", "from": "table", "along": [0, 0, 1]}},
      {"name": "reaction", "force": {"body": "table"}},
      {"name": "turned", "rotation": {"body": "rail", "about": [0, 0, -2]}},
      {"name": "raised", "displacement": {"body": "rail"}},
      {"name": "corner", "displacement": {"body": "rail", "at": [0.05, 0, 0.3], "along": [0, 1, 0]}},
      {"name": "apart", "distance": {"from": {"body": "rail", "at": [0, 0, 0.3]}, "to": {"body": "bone", "at": [1, 0, 0]}}},
      {"name": "gap", "gap": {"bodies": ["bone", "table"]}},
      {"name": "touching", "gap": {"bodies": ["block", "table"]}},
      {"name": "area", "contact_area": {"bodies": ["block", "table"]}},
      {"name": "half", "volume": {"body": "rail", "beyond": [{"point": [0, 0, 0.4], "normal": [0, 0, 1]}]}},
      {"name": "cavity", "cavity": {"body": "rail", "walls": [
        {"box": {"lower": [-1, -1, 0], "upper": [1, 1, 0.3]}}, {"box": {"lower": [-1, -1, 0.3], "upper": [1, 1, 1]}}]}}])");
  Simulation simulation = simulate(scene);
  StageRun stages(scene, simulation);
  lead(stages, simulation);
  const OutcomeProbe probe(scene, simulation.bodies());
  const std::vector<OutcomeValue> values = probe.values(simulation);
  const auto value = [&](const std::string& name) {
    for (std::size_t i = 0; i < probe.infos().size(); ++i)
      if (probe.infos()[i].name == name) return values[i].value;
    return std::nan("");
  };
  const double weight = 9.81;  // 1 kg
  EXPECT_NEAR(value("weight"), weight, 1e-3 * weight);
  EXPECT_NEAR(value("reaction"), weight, 1e-3 * weight);
  EXPECT_NEAR(value("turned"), -40.0, 1e-9);
  EXPECT_NEAR(value("raised"), 0.1, 1e-12);
  EXPECT_NEAR(value("corner"), 0.05 * std::sin(40.0 * 3.14159265358979 / 180.0), 1e-12);
  EXPECT_NEAR(value("apart"), std::hypot(1.0, 0.4), 1e-12);
  EXPECT_NEAR(value("gap"), 0.79, 1e-12);
  EXPECT_EQ(value("touching"), 0.0);
  EXPECT_NEAR(value("area"), 0.01, 1e-4);
  EXPECT_NEAR(value("half"), 0.5 * 0.1 * 0.1 * 0.02, 1e-12);
  EXPECT_NEAR(value("cavity"), 0.1 * 0.1 * 0.02, 1e-12);
  EXPECT_EQ(probe.in_words(0, 9.81), "9.81 N");
  EXPECT_EQ(probe.in_words(9, 4.1e-7), "0.41 ml");
  EXPECT_EQ(probe.in_words(2, -40.0), "-40 deg");
}

}  // namespace
}  // namespace palpate
