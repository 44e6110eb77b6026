// The hardest pulls and jerks that the page allows, in the scenes of the gallery: no pull inverts tets, keeps
// a step from converging or blows up a run.
#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include <palpate/error.hpp>
#include <palpate/io/mesh_reader.hpp>
#include <palpate/relax.hpp>

#include "geometry/vector.hpp"
#include "support/random.hpp"
#include "view/live.hpp"
#include "view/pull_limits.hpp"
#include "view/scenes.hpp"

namespace palpate::view {
namespace {

std::unique_ptr<LiveSource> source_of(const std::string& name) {
  const Scene scene = read_scene(std::string(PALPATE_SOURCE_DIR "/") + name);
  Model model = load_model(scene, [](const auto& path) { return io::read_mesh(path).mesh; });
  if (scene.relax) relax(model, scene.settings, *scene.relax, 1);
  return std::make_unique<LiveSource>(scene, std::move(model), 1);
}

/// The worst effects of a pull.
struct Worst {
  double force = 0.0;  ///< over the limit of the tissue
  std::int64_t inverted = 0;
  std::int64_t inverted_at_end = 0;
  std::int64_t not_converged = 0;
};

class Hand {
 public:
  Hand(LiveSource& source, std::uint64_t seed) : source_(source), surface_(source.bodies()), random_(seed) {}

  /// Begins a pull at some tissue to a distant target.
  void take() {
    while (true) {
      const auto vertex = Index{random_.integer(0, surface_.vertex_count() - 1)};
      try {
        source_.apply(1, Pull{vertex, far(), strength});
        return;
      } catch (const Error&) {  // a point of bone
      }
    }
  }
  /// Moves the target elsewhere within one step.
  void jerk() { source_.apply(1, MovePull{far()}); }
  void let_go() { source_.apply(1, LetGo{}); }

 private:
  static constexpr double strength = 20.0;  ///< the largest of the page
  Vec3 far() {
    const auto coordinate = [&] { return random_.uniform(-1.0, 1.0); };
    const double size = source_.stage().about.at("diagonal");
    return size * Vec3{coordinate(), coordinate(), coordinate()};
  }
  LiveSource& source_;
  Surface surface_;
  test::Random random_;
};

Worst hold_and_jerk(LiveSource& source, double seconds, std::uint64_t seed) {
  Hand hand(source, seed);
  Worst worst;
  const double time_step = source.simulation().settings().time_step;
  const int steps = static_cast<int>(seconds / time_step);
  for (int step = 0; step < steps; ++step) {
    // Pulls for 20 steps, jerks in every third of the next 24, releases for 8.
    const int phase = step % 52;
    if (phase == 0) hand.take();
    if (phase >= 20 && phase < 44 && phase % 3 == 0) hand.jerk();
    if (phase == 44) hand.let_go();
    source.advance();
    const auto counts = source.counts();
    for (const auto& pull : counts["pulls"]) {
      const Vec3 force{pull["force"][0], pull["force"][1], pull["force"][2]};
      worst.force = std::max(worst.force, length(force) / pull["most"].get<double>());
    }
    worst.inverted = counts["inverted_tets"]["most"];
    worst.inverted_at_end = counts["inverted_tets"]["now"];
    worst.not_converged = counts["steps_not_converged"];
  }
  return worst;
}

/// Temporarily allowed values.
struct Momentary {
  double force = 1.05;  ///< over the limit of the tissue
  std::int64_t inverted = 0;
};

void expect_it_takes_pulls(const std::string& scene, double seconds, const Momentary& allowed = {}) {
  const auto source = source_of(scene);
  const Worst worst = hold_and_jerk(*source, seconds, 5);
  EXPECT_LE(worst.force, allowed.force);
  EXPECT_GT(worst.force, 0.5) << "the hand did pull";
  EXPECT_LE(worst.inverted, allowed.inverted);
  EXPECT_EQ(worst.inverted_at_end, 0);
  EXPECT_EQ(worst.not_converged, 0);
}

class Pulls : public ::testing::TestWithParam<const char*> {};
TEST_P(Pulls, HeldAndJerkedDoNoHarm) {
  expect_it_takes_pulls(GetParam(), 0.3);
}
/// The same for a minute of simulated time, which takes minutes. The coarse bars and blocks of the gallery
/// move violently: one or two tets are inverted for a moment, and forces may exceed the limit for a step.
TEST_P(Pulls, DISABLED_AMinuteOfThemDoesNoHarm) {
  const bool gallery = std::string(GetParam()).starts_with("examples");
  expect_it_takes_pulls(GetParam(), 60.0, gallery ? Momentary{.force = 1.5, .inverted = 2} : Momentary{});
}
/// The name of a scene's file in a form that GoogleTest accepts.
std::string name_of(const ::testing::TestParamInfo<const char*>& scene) {
  std::string name = std::filesystem::path(scene.param).stem();
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(Scenes, Pulls,
                         ::testing::Values("scenes/eye.json", "scenes/skull.json", "scenes/stacking.json"),
                         name_of);
/// The scenes of docs/gallery.md, except the tower.
INSTANTIATE_TEST_SUITE_P(Gallery, Pulls,
                         ::testing::Values("examples/scenes/attached.json", "examples/scenes/belt.json",
                                           "examples/scenes/crossed-bars.json",
                                           "examples/scenes/everything.json", "examples/scenes/fold.json",
                                           "examples/scenes/grab.json", "examples/scenes/incline-slide.json",
                                           "examples/scenes/incline-stick.json", "examples/scenes/jaw.json",
                                           "examples/scenes/liver.json", "examples/scenes/muscle.json",
                                           "examples/scenes/needle.json", "examples/scenes/load.json",
                                           "examples/scenes/plastic.json", "examples/scenes/press.json",
                                           "examples/scenes/regions.json",
                                           "examples/scenes/two-stiffnesses.json"),
                         name_of);
/// Ten stiff blocks on each other: pulls need more iterations than the scene allows, and steps report that
/// (docs/viewer-server.md). All else holds.
TEST(PullsTower, TurnNoTetInsideOut) {
  const auto source = source_of("examples/scenes/tower.json");
  const Worst worst = hold_and_jerk(*source, 0.1, 5);
  EXPECT_GT(worst.force, 0.0);
  EXPECT_EQ(worst.inverted, 0);
}
/// No other scene of the gallery is left out.
TEST(PullsGallery, HasEveryScene) {
  const auto& suite = *::testing::UnitTest::GetInstance();
  std::set<std::string> tested;
  for (int s = 0; s < suite.total_test_suite_count(); ++s) {
    const auto& tests = *suite.GetTestSuite(s);
    if (std::string(tests.name()) != "Gallery/Pulls") continue;
    for (int t = 0; t < tests.total_test_count(); ++t) {
      const std::string name = tests.GetTestInfo(t)->name();
      if (!name.starts_with("DISABLED_")) tested.insert(name.substr(name.find('/') + 1));
    }
  }
  std::set<std::string> files;
  for (const auto& file : std::filesystem::directory_iterator(PALPATE_SOURCE_DIR "/examples/scenes")) {
    std::string name = file.path().stem();
    std::replace(name.begin(), name.end(), '-', '_');
    files.insert(name);
  }
  files.erase("tower");
  EXPECT_EQ(tested, files);
}

}  // namespace
}  // namespace palpate::view
