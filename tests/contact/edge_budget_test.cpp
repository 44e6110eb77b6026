// Oracle: the search of edges without a deadline (itself checked in edge_contacts_test.cpp).
#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <set>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/deadline.hpp"
#include "contact/detector_steps.hpp"
#include "contact/edge_contacts.hpp"
#include "geometry/vector.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"

namespace palpate {
namespace {

using EdgeSet = std::set<std::pair<Index, Index>>;  // (edge, body)

/// Boxes that pass through each other in many ways, and one that may touch itself.
class Crowd {
 public:
  explicit Crowd(int seed) : random_(static_cast<std::uint64_t>(seed)) {
    settings_.edge_contacts = true;
    for (int b = 0; b < 40; ++b) {
      TetMesh box = test::box_mesh({2, 6, 2}, {-0.02, -0.1, -0.02}, {0.02, 0.1, 0.02});
      const Vec3 axis = random_.point(-1, 1);
      const Vec3 shift = random_.point(-0.15, 0.15);
      for (Vec3& p : box.points) p = test::rotated(p, axis, 1.3) + shift;
      bodies_.add("b", std::move(box));
    }
    settings_.self_collision.assign(40, 0);
    settings_.self_collision[7] = 1;
    x_.assign(bodies_.points_rest().begin(), bodies_.points_rest().end());
  }
  void move(double by) {
    for (const Body& body : bodies_.bodies()) {
      const Vec3 shift = random_.point(-by, by);
      for (Index p = body.points.begin; p < body.points.end; ++p) at(x_, p) += shift;
    }
  }
  EdgeSet find(EdgeContactQuery& query, const Deadline& deadline) const {
    Detector detector(bodies_, settings_, {}, 2);
    detector.detect(x_);
    EdgeContacts found;
    query.find(parallel::Threads(2), bodies_, x_, DetectorSteps::may_touch(detector),
               DetectorSteps::table(detector), found, deadline);
    EdgeSet set;
    for (std::size_t c = 0; c < found.size(); ++c) set.insert({found.edge[c], found.body[c]});
    return set;
  }
  [[nodiscard]] const Bodies& bodies() const { return bodies_; }

 private:
  test::Random random_;
  Bodies bodies_;
  DetectionSettings settings_;
  std::vector<Vec3> x_;
};

TEST(EdgeBudget, WhatWaitsIsFoundInLaterSearches) {
  const Crowd crowd(1);
  EdgeContactQuery exact(crowd.bodies());
  const EdgeSet all = crowd.find(exact, {});
  EXPECT_EQ(exact.work().all, 0U) << "no deadline";
  ASSERT_GT(all.size(), 100U);
  EdgeContactQuery query(crowd.bodies());
  EdgeSet once;
  std::size_t first = 0;
  for (int i = 0; i < 400; ++i) {
    const EdgeSet found = crowd.find(query, Deadline::after_seconds(-1.0));
    EXPECT_TRUE(std::ranges::includes(all, found)) << "what is found is real";
    if (found != all) {
      EXPECT_GT(query.work().late, 0U);
      EXPECT_LT(query.work().late, query.work().all);
      EXPECT_FALSE(query.work().late_pairs.empty());
    }
    once.insert(found.begin(), found.end());
    if (i == 0) first = found.size();
  }
  EXPECT_LT(first, all.size()) << "the first chunk only";
  EXPECT_EQ(once, all);
}

TEST(EdgeBudget, ASearchWithoutADeadlineFindsAllWhateverWasLeftOutBefore) {
  Crowd crowd(2);
  EdgeContactQuery query(crowd.bodies());
  for (int i = 0; i < 120; ++i) {
    crowd.move(i % 40 < 30 ? 2e-5 : 2e-3);  // slow motion keeps lists
    const bool in_time = i % 5 == 4;
    const EdgeSet found = crowd.find(query, in_time ? Deadline() : Deadline::after_seconds(-1.0));
    EdgeContactQuery exact(crowd.bodies());
    const EdgeSet all = crowd.find(exact, {});
    if (in_time) {
      ASSERT_EQ(found, all) << "search " << i;
    } else {
      ASSERT_TRUE(std::ranges::includes(all, found));
    }
  }
}

TEST(EdgeBudget, EnoughTimeLeavesNothingOut) {
  const Crowd crowd(3);
  EdgeContactQuery exact(crowd.bodies());
  EdgeContactQuery query(crowd.bodies());
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(crowd.find(query, Deadline::after_seconds(1e6)), crowd.find(exact, {}));
    EXPECT_EQ(query.work().late, 0U);
    EXPECT_GT(query.work().all, 0U);
  }
}

/// A detector with almost no time says that edges are missing.
TEST(EdgeBudget, ADetectorCountsWhatIsLeftOut) {
  Crowd crowd(4);
  DetectionSettings settings;
  settings.budget = Budget{.milliseconds = 1e-6};
  Detector detector(crowd.bodies(), settings, {}, 1);
  std::size_t late = 0;
  for (int i = 0; i < 20; ++i) {
    detector.detect(crowd.bodies().points_rest());
    if (detector.counts().late_clusters == 0) continue;
    ++late;
    EXPECT_LT(detector.counts().completeness, 1.0);
    EXPECT_TRUE(std::ranges::any_of(detector.late_bodies(), [](std::uint8_t flag) { return flag != 0; }));
  }
  EXPECT_GT(late, 10U);
}

}  // namespace
}  // namespace palpate
