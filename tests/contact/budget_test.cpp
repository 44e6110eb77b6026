// Oracle: the detection without a budget (itself checked against rational arithmetic in detector_test.cpp).
#include <algorithm>
#include <gtest/gtest.h>
#include <limits>
#include <set>
#include <string>

#include <palpate/detection.hpp>
#include <palpate/error.hpp>

#include "contact/same_detections.hpp"
#include "contact/scenes.hpp"
#include "geometry/vector.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

using Pair = std::pair<Index, Index>;
using Pairs = std::set<Pair>;

Pairs pairs_of(const Contacts& contacts) {
  Pairs pairs;
  for (std::size_t c = 0; c < contacts.size(); ++c) pairs.insert({contacts.point[c], contacts.body[c]});
  return pairs;
}

Detector detector_with(const Bodies& bodies, const std::optional<Budget>& budget, int threads = 1) {
  DetectionSettings settings;
  settings.budget = budget;
  return Detector(bodies, settings, {}, threads);
}

/// Balls in a row, each a little in the next.
Bodies row_of_balls(int count) {
  Bodies bodies;
  for (int i = 0; i < count; ++i)
    bodies.add("ball" + std::to_string(i), test::ball_mesh(9, {0.09 * i, 0.001 * i, 0.0}, 0.05));
  return bodies;
}

TEST(BudgetOf, AnyAmountThatSufficesChangesNoBit) {
  for (int kind = 0; kind < test::contact_scene_kinds; ++kind) {
    SCOPED_TRACE(test::contact_scene_name(kind));
    const test::ContactScene scene = test::make_contact_scene(kind, 3);
    Detector exact = detector_with(scene.bodies, std::nullopt);
    exact.detect(scene.positions);
    for (const Budget& budget :
         {Budget{.tests = std::numeric_limits<int>::max()}, Budget{.milliseconds = 1e6}}) {
      Detector limited = detector_with(scene.bodies, budget, 2);
      for (int i = 0; i < 3; ++i) {  // the order of work changes with what is found
        limited.detect(scene.positions);
        test::expect_same(limited, exact);
        EXPECT_EQ(limited.counts().candidates, exact.counts().candidates);
        EXPECT_EQ(limited.counts().late_clusters, 0U);
        EXPECT_EQ(limited.counts().completeness, 1.0);
      }
    }
  }
}

TEST(BudgetOf, TestsFindsASubsetAndSaysWhatIsMissing) {
  const Bodies bodies = row_of_balls(4);
  Detector exact = detector_with(bodies, std::nullopt);
  exact.detect(bodies.points_rest());
  const Pairs all = pairs_of(exact.contacts());
  ASSERT_GT(all.size(), 50U);
  std::size_t missed = 0;
  for (int tests = 1; tests < 100000; tests *= 3) {
    Detector limited = detector_with(bodies, Budget{.tests = tests});
    for (int i = 0; i < 4; ++i) {
      limited.detect(bodies.points_rest());
      const Pairs found = pairs_of(limited.contacts());
      ASSERT_TRUE(std::ranges::includes(all, found)) << "contacts that are not there";
      const auto late = limited.late_bodies();
      for (const Pair& pair : all) {
        if (found.contains(pair)) continue;
        ++missed;
        EXPECT_EQ(late[static_cast<std::size_t>(pair.second)], 1) << "a loss is never silent";
      }
      EXPECT_EQ(limited.counts().completeness<1.0, limited.counts().late_clusters> 0);
      EXPECT_EQ(limited.counts().completeness<1.0, std::ranges::count(late, 1)> 0);
    }
  }
  EXPECT_GT(missed, 100U) << "the budgets must be so small that something is lost";
}

TEST(BudgetOf, TestsIsTheSameForEveryThreadCount) {
  const Bodies bodies = row_of_balls(4);
  for (const int tests : {500, 3000, 9000}) {
    Detector one = detector_with(bodies, Budget{.tests = tests}, 1);
    Detector three = detector_with(bodies, Budget{.tests = tests}, 3);
    for (int i = 0; i < 6; ++i) {
      one.detect(bodies.points_rest());
      three.detect(bodies.points_rest());
      test::expect_same(three, one);
      EXPECT_EQ(three.counts().candidates, one.counts().candidates);
      EXPECT_EQ(three.counts().late_clusters, one.counts().late_clusters);
      EXPECT_TRUE(std::ranges::equal(three.late_bodies(), one.late_bodies()));
    }
  }
}

TEST(BudgetOf, TestsIsKeptButForTheLastChunks) {
  const Bodies bodies = row_of_balls(4);
  Detector exact = detector_with(bodies, std::nullopt);
  exact.detect(bodies.points_rest());
  const std::size_t needed = exact.counts().candidates;
  for (const int tests : {500, 2000, 5000}) {
    ASSERT_GT(needed, 2U * static_cast<std::size_t>(tests));
    Detector limited = detector_with(bodies, Budget{.tests = tests});
    for (int i = 0; i < 10; ++i) {
      limited.detect(bodies.points_rest());
      EXPECT_LT(limited.counts().completeness, 1.0);
      // A chunk is 16 clusters; in each part of the budget the one that spends the last of it is done whole.
      EXPECT_LT(limited.counts().candidates, static_cast<std::size_t>(tests) + 4000U);
    }
  }
}

TEST(BudgetOf, WhatWaitsIsFoundAndWhatIsFoundStays) {
  const Bodies bodies = row_of_balls(4);
  Detector exact = detector_with(bodies, std::nullopt);
  exact.detect(bodies.points_rest());
  const Pairs all = pairs_of(exact.contacts());
  // Enough for the clusters in contact, but not for all.
  const int tests = static_cast<int>(exact.counts().candidates * 3 / 4);
  Detector limited = detector_with(bodies, Budget{.tests = tests});
  for (int i = 0; i < 30; ++i) limited.detect(bodies.points_rest());
  for (int i = 0; i < 10; ++i) {
    limited.detect(bodies.points_rest());
    EXPECT_EQ(pairs_of(limited.contacts()), all);
  }
  // Less than for those: then each comes in its turn.
  Detector poor = detector_with(bodies, Budget{.tests = tests / 12});
  Pairs ever;
  for (int i = 0; i < 200; ++i) {
    poor.detect(bodies.points_rest());
    ever.merge(pairs_of(poor.contacts()));
  }
  EXPECT_EQ(ever, all);
}

TEST(BudgetOf, TheRegionOfInterestComesFirst) {
  const Bodies bodies = row_of_balls(5);
  const auto near_to = [&](const Contacts& contacts, double x) {
    std::size_t count = 0;
    for (const Index point : contacts.point)
      count += std::abs(at(bodies.points_rest(), point).x - x) < 0.02 ? 1 : 0;
    return count;
  };
  Detector exact = detector_with(bodies, std::nullopt);
  exact.detect(bodies.points_rest());
  const int tests = static_cast<int>(exact.counts().candidates / 6);
  for (int gap = 0; gap < 4; ++gap) {
    const double x = 0.09 * gap + 0.045;
    ASSERT_GT(near_to(exact.contacts(), x), 10U);
    Detector limited = detector_with(
        bodies, Budget{.tests = tests, .region = InterestRegion{.center = {x, 0.0, 0.0}, .radius = 0.035}});
    limited.detect(bodies.points_rest());
    EXPECT_EQ(near_to(limited.contacts(), x), near_to(exact.contacts(), x)) << "gap " << gap;
    EXPECT_LT(limited.contacts().size(), exact.contacts().size());
  }
}

TEST(BudgetOf, NoTimeIsSaidToo) {
  const Bodies bodies = row_of_balls(3);
  Detector limited = detector_with(bodies, Budget{.milliseconds = 1e-9});
  limited.detect(bodies.points_rest());
  EXPECT_EQ(limited.counts().completeness, 1.0) << "the first is not limited";
  EXPECT_GT(limited.contacts().size(), 0U);
  limited.detect(bodies.points_rest());
  EXPECT_LT(limited.counts().completeness, 0.1) << "only the first chunk of the search of edges";
  EXPECT_EQ(limited.contacts().size(), 0U);
  EXPECT_EQ(std::ranges::count(limited.late_bodies(), 1), 3);
}

TEST(BudgetOf, LittleTimeGivesContactsThatAreThereWithDepthsThatAreNumbers) {
  const Bodies bodies = row_of_balls(4);
  Detector exact = detector_with(bodies, std::nullopt);
  // From nothing to enough on any machine: between, some contacts have time and some have not.
  for (double milliseconds = 1e-3; milliseconds < 30.0; milliseconds *= 1.6) {
    Detector limited = detector_with(bodies, Budget{.milliseconds = milliseconds}, 2);
    std::vector<Vec3> positions(bodies.points_rest().begin(), bodies.points_rest().end());
    for (int frame = 0; frame < 40; ++frame) {
      // The balls turn, each a little around its middle, and come nearer and go apart.
      for (std::size_t p = 0; p < positions.size(); ++p) {
        const auto ball = at(bodies.body_of_point(), static_cast<Index>(p));
        const Vec3 middle{0.09 * ball, 0.001 * ball, 0.0};
        const double apart = 1.0 + 0.05 * std::sin(0.3 * frame);
        positions[p] = apart * middle +
                       test::rotated(bodies.points_rest()[p] - middle, {0, 1, ball + 1.0}, 0.02 * frame);
      }
      exact.detect(positions);
      limited.detect(positions, frame % 3 == 0 ? 0.5 : 1.0);
      const Contacts& contacts = limited.contacts();
      const Pairs all = pairs_of(exact.contacts());
      const Pairs found = pairs_of(contacts);
      ASSERT_TRUE(std::ranges::includes(all, found)) << "contacts that are not there";
      if (limited.counts().completeness == 1.0) {
        EXPECT_EQ(found, all);
      }
      for (std::size_t c = 0; c < contacts.size(); ++c) {
        ASSERT_GE(contacts.depth[c], 0.0);
        ASSERT_LT(contacts.depth[c], 0.1) << "the balls' diameter";
        ASSERT_NEAR(length(contacts.direction[c]), 1.0, 1e-9);
        ASSERT_GE(contacts.certainty[c], 0.0);
        ASSERT_LE(contacts.certainty[c], 1.0);
      }
      EXPECT_LE(limited.counts().rough_depths, contacts.size());
    }
  }
}

TEST(BudgetOf, NonsenseIsRefused) {
  const Bodies bodies = row_of_balls(2);
  for (const Budget& budget :
       {Budget{}, Budget{.tests = 1, .milliseconds = 1.0}, Budget{.tests = 0}, Budget{.milliseconds = 0.0},
        Budget{.milliseconds = std::numeric_limits<double>::quiet_NaN()},
        Budget{.tests = 5, .region = InterestRegion{.center = {}, .radius = 0.0}}})
    EXPECT_THROW(detector_with(bodies, budget), Error);
  DetectionSettings settings;
  settings.budget = Budget{.tests = 5};
  settings.structure = Structure::hash;
  EXPECT_THROW(Detector(bodies, settings), Error);
  settings.structure = Structure::compact;
  settings.cells_per_primitive = 8;
  EXPECT_THROW(Detector(bodies, settings), Error);
}

}  // namespace
}  // namespace palpate
