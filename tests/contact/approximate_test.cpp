// Oracle: the exact contacts (themselves checked against rational arithmetic in detector_test.cpp).
#include <algorithm>
#include <gtest/gtest.h>
#include <set>
#include <tuple>

#include <palpate/detection.hpp>
#include <palpate/error.hpp>

#include "contact/scenes.hpp"

namespace palpate {
namespace {

using PointsInBodies = std::set<std::pair<Index, Index>>;

PointsInBodies points_in_bodies(const Contacts& contacts) {
  PointsInBodies set;
  for (std::size_t c = 0; c < contacts.size(); ++c) set.insert({contacts.point[c], contacts.body[c]});
  return set;
}

Detector detector_for(const test::ContactScene& scene, Structure structure, std::optional<int> slots,
                      int threads, double cell_size) {
  DetectionSettings settings;
  settings.structure = structure;
  settings.cells_per_primitive = slots;
  settings.cell_size = cell_size;
  return Detector(scene.bodies, settings, scene.immovable, threads);
}

TEST(ApproximateMode, FindsASubsetAndSaysWhatItDropped) {
  std::size_t missed = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    const test::ContactScene scene = test::make_contact_scene(8, seed);
    Detector exact = detector_for(scene, Structure::compact, std::nullopt, 1, 0.2);
    exact.detect(scene.positions);
    EXPECT_EQ(exact.counts().dropped_cells, 0U);
    const PointsInBodies all = points_in_bodies(exact.contacts());
    for (const int slots : {27, 8, 1}) {
      Detector approximate = detector_for(scene, Structure::compact, slots, 1, 0.2);
      approximate.detect(scene.positions);
      const PointsInBodies found = points_in_bodies(approximate.contacts());
      ASSERT_TRUE(std::includes(all.begin(), all.end(), found.begin(), found.end())) << slots << " slots";
      ASSERT_TRUE(found == all || approximate.counts().dropped_cells > 0) << "a loss is never silent";
      ASSERT_EQ(approximate.counts().dropped_cells > 0, approximate.counts().approximated_primitives > 0);
      missed += all.size() - found.size();
    }
  }
  EXPECT_GT(missed, 0U) << "the scenes must be hard enough to lose something";
}

TEST(ApproximateMode, WithRoomForAllCellsIsExact) {
  const test::ContactScene scene = test::make_contact_scene(8, 4);
  Detector exact = detector_for(scene, Structure::compact, std::nullopt, 1, 3.0);
  Detector roomy = detector_for(scene, Structure::compact, 8, 1, 3.0);
  exact.detect(scene.positions);
  roomy.detect(scene.positions);
  EXPECT_EQ(roomy.counts().dropped_cells, 0U);
  EXPECT_EQ(exact.contacts().tet, roomy.contacts().tet);
  EXPECT_EQ(exact.contacts().depth, roomy.contacts().depth);
}

TEST(ApproximateMode, HasTheSameBitsForEveryThreadCountAndChangesWithTheStep) {
  std::size_t changes = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const test::ContactScene scene = test::make_contact_scene(8, seed);
    std::vector<PointsInBodies> by_step;
    for (const int threads : {1, 2, 5}) {
      Detector detector = detector_for(scene, Structure::compact, 1, threads, 0.2);
      for (std::size_t step = 0; step < 4; ++step) {
        detector.detect(scene.positions);
        const PointsInBodies found = points_in_bodies(detector.contacts());
        if (by_step.size() == step) by_step.push_back(found);
        ASSERT_EQ(found, by_step[step]) << threads << " threads, step " << step << ", seed " << seed;
      }
    }
    changes += std::set<PointsInBodies>(by_step.begin(), by_step.end()).size() - 1;
  }
  EXPECT_GT(changes, 5U);
}

TEST(ApproximateMode, RefusesSlotsOutOfRange) {
  const test::ContactScene scene = test::make_contact_scene(8, 1);
  for (const int slots : {0, 28, -1}) {
    EXPECT_THROW(detector_for(scene, Structure::compact, slots, 1, 0.2), Error) << slots;
  }
}

}  // namespace
}  // namespace palpate
