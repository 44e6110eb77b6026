// Oracles: the definitions of the rules; all lengths tried by hand through the counts of a detector.
#include "grid/cell_size.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <string>

#include <palpate/error.hpp>

#include "support/meshes.hpp"

namespace palpate {
namespace {

CellSizeChoice choice(const Bodies& bodies, const CellSize& wanted) {
  const std::vector<std::uint8_t> all(bodies.points_rest().size(), 1);
  return choose_cell_size(parallel::Threads(2), bodies, bodies.points_rest(), all, wanted);
}

TEST(CellSize, RulesAreWhatTheySay) {
  Bodies bodies;
  bodies.add("one", {{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, {{0, 1, 2, 3}}});
  const double sum = 1 + 2 + 3 + std::sqrt(5.0) + std::sqrt(10.0) + std::sqrt(13.0);
  EXPECT_NEAR(choice(bodies, CellSizeRule::mean_edge).cell_size, sum / 6, 1e-15);
  EXPECT_EQ(choice(bodies, CellSizeRule::max_edge).cell_size, std::sqrt(13.0));
  EXPECT_EQ(choice(bodies, 0.7).cell_size, 0.7);
}

TEST(CellSize, LengthsThatAreNoneAreRefused) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const double length : {0.0, -1.0, std::nan(""), infinity, 1e151})
    EXPECT_THROW(check_cell_size(length), Error) << length;
  for (const double length : {1e-300, 1.0, 1e150}) EXPECT_NO_THROW(check_cell_size(length)) << length;
  EXPECT_NO_THROW(check_cell_size(CellSizeRule::automatic));
}

TEST(CellSize, AutomaticIsNearTheMeanEdgeForLikeElements) {
  Bodies bodies;
  bodies.add("a", test::box_mesh({8, 8, 8}, {0, 0, 0}, {1, 1, 1}));
  bodies.add("b", test::ball_mesh(8, {0.5, 0.5, 1.4}, 0.5));
  const CellSizeChoice automatic = choice(bodies, CellSizeRule::automatic);
  const double mean = choice(bodies, CellSizeRule::mean_edge).cell_size;
  EXPECT_GT(automatic.cell_size, 0.25 * mean);
  EXPECT_LT(automatic.cell_size, 4.0 * mean);
  EXPECT_GE(automatic.trials.size(), 4U);
  for (const CellSizeTrial& t : automatic.trials) EXPECT_GE(t.work, 0.0);
}

/// A hundredfold difference of elements: a fine ball inside a coarse block, and a long thin needle.
Bodies mixed_scene() {
  Bodies bodies;
  bodies.add("block", test::box_mesh({6, 6, 6}, {-30, -30, -30}, {30, 30, 30}));
  bodies.add("ball", test::ball_mesh(12, {1, 2, 30}, 0.6));
  bodies.add("needle", test::box_mesh({1, 1, 40}, {-5, -5, 20}, {-4.98, -4.98, 60}));
  return bodies;
}

TEST(CellSize, AutomaticHasTheLeastWorkOfAllItTriedAndNeedsNoTuningWhereElementsDiffer) {
  const Bodies bodies = mixed_scene();
  const CellSizeChoice automatic = choice(bodies, CellSizeRule::automatic);
  const auto best = std::min_element(automatic.trials.begin(), automatic.trials.end(),
                                     [](const auto& a, const auto& b) { return a.work < b.work; });
  EXPECT_EQ(best->cell_size, automatic.cell_size);
  const auto work_at = [&](double size) {  // of the nearest length tried
    return std::min_element(automatic.trials.begin(), automatic.trials.end(),
                            [&](const auto& a, const auto& b) {
                              return std::abs(std::log(a.cell_size / size)) <
                                     std::abs(std::log(b.cell_size / size));
                            })
        ->work;
  };
  EXPECT_LT(best->work, work_at(choice(bodies, CellSizeRule::max_edge).cell_size));
  EXPECT_LE(best->work, work_at(choice(bodies, CellSizeRule::mean_edge).cell_size));
}

TEST(CellSize, ContactsDoNotDependOnIt) {
  const Bodies bodies = mixed_scene();
  std::vector<Index> points;
  for (const CellSize& size : {CellSize(CellSizeRule::automatic), CellSize(CellSizeRule::mean_edge),
                               CellSize(CellSizeRule::max_edge), CellSize(0.3)}) {
    DetectionSettings settings;
    settings.cell_size = size;
    Detector detector(bodies, settings, {}, 2);
    detector.detect(bodies.points_rest());
    if (points.empty()) points = detector.contacts().point;
    EXPECT_EQ(detector.contacts().point, points);
    EXPECT_GT(points.size(), 100U);
    EXPECT_EQ(detector.cell_size_choice().trials.empty(),
              size.index() == 1 || std::get<0>(size) != CellSizeRule::automatic);
  }
}

TEST(CellSize, IsTheSameForEveryThreadCount) {
  const Bodies bodies = mixed_scene();
  const std::vector<std::uint8_t> all(bodies.points_rest().size(), 1);
  const double one = choose_cell_size(parallel::Threads(1), bodies, bodies.points_rest(), all, {}).cell_size;
  EXPECT_EQ(choose_cell_size(parallel::Threads(3), bodies, bodies.points_rest(), all, {}).cell_size, one);
}

}  // namespace
}  // namespace palpate
