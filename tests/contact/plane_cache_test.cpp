// Cached penetration planes. Oracles: rotations and distances by hand, lines of cost by hand.
#include "contact/plane_cache.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <numbers>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/border_edges.hpp"
#include "contact/contact_tables.hpp"
#include "contact/cost_line.hpp"
#include "contact/crossings_of.hpp"
#include "contact/depth.hpp"
#include "contact/detection_budget.hpp"
#include "geometry/vector.hpp"
#include "mesh/clusters.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

using Outcome = PlaneCache::Outcome;

/// Balls in a row, each a little in the next.
Bodies three_balls() {
  Bodies bodies;
  for (int i = 0; i < 3; ++i)
    bodies.add("ball" + std::to_string(i), test::ball_mesh(9, {0.09 * i, 0.001 * i, 0.0}, 0.05));
  return bodies;
}

/// A bar that stands 0.2 deep in a plate with its top at z = 0: four contacts.
Bodies bar_in_a_plate() {
  Bodies bodies;
  bodies.add("plate", test::box_mesh({4, 4, 1}, {-2, -2, -1}, {2, 2, 0}));
  bodies.add("bar", test::box_mesh({1, 1, 2}, {0.2, 0.3, -0.2}, {0.7, 0.8, 1.0}));
  return bodies;
}

Contacts contacts_of(const Bodies& bodies, std::span<const Vec3> positions) {
  Detector detector(bodies, {});
  detector.detect(positions);
  return detector.contacts();
}

/// A turn by a fifth of a right angle, and a shift.
Vec3 moved(const Vec3& p) {
  return test::rotated(p, {1, 2, 3}, 0.1 * std::numbers::pi) + Vec3{0.3, -0.2, 0.1};
}
std::vector<Vec3> all_moved(std::span<const Vec3> positions) {
  std::vector<Vec3> result;
  for (const Vec3& p : positions) result.push_back(moved(p));
  return result;
}

/// Detections of the same contacts, one after the other.
struct Cached {
  explicit Cached(const Bodies& b) : bodies(b), contacts(contacts_of(b, b.points_rest())) {
    for (std::size_t c = 0; c < contacts.size(); ++c) pairs.push_back({contacts.point[c], contacts.tet[c]});
    begin(pairs);
    update([](std::size_t) { return Outcome::computed; });
  }
  /// A detection that finds these pairs, with depths as they are at rest.
  void begin(std::span<const PointInTet> found) {
    tables.begin();
    tables.now().assign(threads, bodies, bodies.points_rest(), found, &tables.last());
    Contacts& now = tables.now().contacts();
    std::size_t c = 0;
    for (std::size_t row = 0; row < now.size(); ++row, ++c) {
      while (contacts.point[c] != now.point[row] || contacts.body[c] != now.body[row]) ++c;
      now.depth[row] = contacts.depth[c];
      now.direction[row] = contacts.direction[c];
      now.certainty[row] = contacts.certainty[c];
    }
  }
  void choose(std::span<const Vec3> positions, std::size_t most,
              const std::optional<InterestRegion>& region = {}) {
    if (updated) begin(pairs);
    updated = false;
    cache.choose(threads, bodies, positions, tables.now(), tables.last(), most, region);
  }
  void update(const auto& outcome) {
    updated = true;
    cache.update(threads, bodies, bodies.points_rest(), tables.now(), tables.last(), outcome);
  }
  /// Of those chosen to, all compute their plane.
  void update_chosen() {
    update([&](std::size_t c) {
      return cache.source(c) == PlaneCache::compute ? Outcome::computed : Outcome::cached;
    });
  }
  std::size_t computed() const {
    return static_cast<std::size_t>(std::ranges::count(cache.sources(), std::uint8_t{PlaneCache::compute}));
  }
  const Bodies& bodies;
  Contacts contacts;
  std::vector<PointInTet> pairs;
  parallel::Threads threads{1};
  ContactTables tables;
  PlaneCache cache;
  bool updated = false;  ///< the last detection is complete
};

TEST(PlaneCache, GoWithABodyThatTurns) {
  const Bodies bodies = three_balls();
  Cached r(bodies);
  ASSERT_GT(r.contacts.size(), 50U);
  const std::vector<Vec3> positions = all_moved(bodies.points_rest());
  r.choose(positions, 0);
  EXPECT_EQ(r.cache.spared(), r.contacts.size());
  for (std::size_t c = 0; c < r.contacts.size(); ++c) {
    ASSERT_EQ(r.cache.source(c), PlaneCache::cached);
    const PenetrationPlane& plane = *r.cache.plane(c);
    EXPECT_NEAR(plane.depth, r.contacts.depth[c], 1e-12);
    const Vec3 expected = moved(r.contacts.direction[c]) - moved(Vec3{});
    EXPECT_LT(length(plane.direction - expected), 1e-9);
    EXPECT_EQ(plane.certainty, r.contacts.certainty[c]);
  }
}

TEST(PlaneCache, APointComesNearerToItsPlaneOrGoesDeeper) {
  const Bodies bodies = bar_in_a_plate();
  Cached r(bodies);
  ASSERT_EQ(r.contacts.size(), 4U);
  const Range bar = bodies.bodies()[1].points;
  for (const double up : {-0.15, 0.05, 0.25}) {
    std::vector<Vec3> positions(bodies.points_rest().begin(), bodies.points_rest().end());
    for (Index p = bar.begin; p < bar.end; ++p) at(positions, p) += Vec3{0.1, -0.05, up};
    r.choose(positions, 0);
    for (std::size_t c = 0; c < 4; ++c) {
      ASSERT_NE(r.cache.plane(c), nullptr);
      EXPECT_NEAR(r.cache.plane(c)->depth, std::max(0.0, 0.2 - up), 1e-12);
    }
  }
}

TEST(PlaneCache, APointThatHasLeftItsPlaceHasNone) {
  const Bodies bodies = bar_in_a_plate();
  Cached r(bodies);
  std::vector<Vec3> positions(bodies.points_rest().begin(), bodies.points_rest().end());
  const Range bar = bodies.bodies()[1].points;
  // Edges of the plate's tets are 1 to 1.42 long.
  for (Index p = bar.begin; p < bar.end; ++p) at(positions, p).x += 0.75;
  r.choose(positions, 0);
  for (std::size_t c = 0; c < r.contacts.size(); ++c) {
    EXPECT_EQ(r.cache.source(c), PlaneCache::neighbors);
    EXPECT_EQ(r.cache.plane(c), nullptr);
  }
}

TEST(PlaneCache, TheOldestAreComputed) {
  const Bodies bodies = three_balls();
  Cached r(bodies);
  const std::size_t most = r.contacts.size() / 4 + 1;
  std::map<std::size_t, int> times;
  for (int round = 0; round < 8; ++round) {
    r.choose(bodies.points_rest(), most);
    EXPECT_EQ(r.computed(), most);
    for (std::size_t c = 0; c < r.contacts.size(); ++c)
      if (r.cache.source(c) == PlaneCache::compute) ++times[c];
    r.update_chosen();
  }
  ASSERT_EQ(times.size(), r.contacts.size()) << "each in its turn";
  for (const auto& [contact, count] : times) {
    EXPECT_GE(count, 2) << "contact " << contact;
    EXPECT_LE(count, 3) << "contact " << contact;
  }
}

TEST(PlaneCache, TheRegionOfInterestComesMoreOften) {
  const Bodies bodies = three_balls();
  Cached r(bodies);
  const InterestRegion region{{0.045, 0.0, 0.0}, 0.035};
  const auto of_interest = [&](std::size_t c) {
    return region.contains(at(bodies.points_rest(), r.contacts.point[c]));
  };
  std::size_t inside = 0;
  std::vector<int> times(r.contacts.size(), 0);
  for (std::size_t c = 0; c < times.size(); ++c) inside += of_interest(c) ? 1 : 0;
  ASSERT_GT(inside, 10U);
  ASSERT_GT(times.size() - inside, 10U);
  for (int round = 0; round < 64; ++round) {
    r.choose(bodies.points_rest(), times.size() / 8, region);
    EXPECT_EQ(r.computed(), times.size() / 8);
    for (std::size_t c = 0; c < times.size(); ++c)
      times[c] += r.cache.source(c) == PlaneCache::compute ? 1 : 0;
    r.update_chosen();
  }
  double sum_inside = 0.0;
  double sum_outside = 0.0;
  for (std::size_t c = 0; c < times.size(); ++c) {
    EXPECT_GE(times[c], 2) << "each in its turn: contact " << c;
    (of_interest(c) ? sum_inside : sum_outside) += times[c];
  }
  const double ratio =
      (sum_inside / static_cast<double>(inside)) / (sum_outside / static_cast<double>(times.size() - inside));
  EXPECT_GT(ratio, 2.5);
  EXPECT_LT(ratio, 5.5);
}

TEST(PlaneCache, ThoseWithoutComeFirstSampledUniformly) {
  const Bodies bodies = three_balls();
  Cached r(bodies);
  // Only every second contact was there.
  std::vector<PointInTet> half;
  for (std::size_t c = 0; c < r.pairs.size(); c += 2) half.push_back(r.pairs[c]);
  const auto computed = [](std::size_t) { return Outcome::computed; };
  r.begin(half);
  r.cache.choose_none();
  r.update(computed);
  const std::size_t unknown = r.contacts.size() - half.size();

  r.choose(bodies.points_rest(), unknown / 5);
  EXPECT_EQ(r.computed(), unknown / 5);
  std::size_t gap = 0;
  for (std::size_t c = 1; c < r.contacts.size(); c += 2) {
    gap = r.cache.source(c) == PlaneCache::compute ? 0 : gap + 1;
    EXPECT_LE(gap, 7U) << "a region without one";
  }
  r.begin(half);
  r.cache.choose_none();
  r.update(computed);
  const std::size_t enough = unknown + unknown / 2;
  r.choose(bodies.points_rest(), enough);
  EXPECT_EQ(r.computed(), enough);
  for (std::size_t c = 1; c < r.contacts.size(); c += 2) EXPECT_EQ(r.cache.source(c), PlaneCache::compute);
}

/// Depths of the contacts where not all are computed.
Contacts with_planes(Cached& r, std::span<const Vec3> positions) {
  ContactTable table;
  table.assign(r.threads, r.bodies, positions, r.pairs);
  BorderEdges border_edges(r.bodies);
  border_edges.find(r.threads, r.bodies, positions, table, r.cache.sources());
  for (const BorderEdge& edge : border_edges.edges())
    EXPECT_EQ(r.cache.source(static_cast<std::size_t>(edge.contact)), PlaneCache::compute);
  const Crossings crossings = test::crossings_of(r.bodies, positions, table, border_edges);
  DepthEstimate depth(r.bodies);
  const DepthCounts counts =
      depth.compute(r.threads, r.bodies, positions, table, border_edges, crossings, r.cache);
  EXPECT_EQ(counts.rough_depths, r.cache.spared());
  for (std::size_t c = 0; c < r.contacts.size(); ++c)
    EXPECT_EQ(depth.outcome(c) == Outcome::computed, r.cache.source(c) == PlaneCache::compute);
  return table.contacts();
}

TEST(PlaneCache, DepthsOfSomeContactsDoNotSufferFromTheOthersGoingByTheirs) {
  const Bodies bodies = three_balls();
  const std::vector<Vec3> positions = all_moved(bodies.points_rest());
  const Contacts exact = contacts_of(bodies, positions);
  for (const std::size_t part : {1U, 2U, 8U}) {
    Cached r(bodies);
    r.choose(positions, r.contacts.size() / part);
    const Contacts contacts = with_planes(r, positions);
    ASSERT_EQ(contacts.point, exact.point);
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      // Nothing has changed but for the turn: the cached planes are right, and what is computed sees them.
      const double bound = part == 1 ? 1e-9 : 0.05;
      EXPECT_NEAR(contacts.depth[c], exact.depth[c], bound * 0.01) << "part " << part;
      EXPECT_LT(length(contacts.direction[c] - exact.direction[c]), bound) << "part " << part;
    }
  }
}

TEST(PlaneCache, ContactsWithoutGoByTheirNeighbors) {
  const Bodies bodies = three_balls();
  const Contacts exact = contacts_of(bodies, bodies.points_rest());
  Cached r(bodies);
  // Nothing fits any more, as after a jump: a quarter is computed.
  r.begin(r.pairs);
  for (auto& weights : r.tables.now().contacts().weights) weights = {5, -2, -1, -1};
  r.cache.choose_none();
  r.update([](std::size_t) { return Outcome::computed; });
  r.choose(bodies.points_rest(), r.contacts.size() / 4);
  const Contacts contacts = with_planes(r, bodies.points_rest());
  double deepest = 0.0;
  double depths = 0.0;
  double exact_depths = 0.0;
  for (std::size_t c = 0; c < exact.size(); ++c) deepest = std::max(deepest, exact.depth[c]);
  for (std::size_t c = 0; c < exact.size(); ++c) {
    EXPECT_GT(dot(contacts.direction[c], exact.direction[c]), 0.7) << "contact " << c;
    EXPECT_LE(contacts.depth[c], 1.2 * deepest);
    depths += contacts.depth[c];
    exact_depths += exact.depth[c];
  }
  EXPECT_NEAR(depths, exact_depths, 0.5 * exact_depths);
}

TEST(PlaneCache, ThePlaneDeformsWithTheTissue) {
  const Bodies bodies = bar_in_a_plate();
  Cached r(bodies);
  ASSERT_EQ(r.contacts.size(), 4U);
  const Range plate = bodies.bodies()[0].points;
  const auto expect = [&](double shear, double height, double depth) {
    std::vector<Vec3> positions(bodies.points_rest().begin(), bodies.points_rest().end());
    for (Vec3& p : positions) {
      const bool of_plate = &p - positions.data() < plate.end;
      p = of_plate ? Vec3{p.x + shear * p.z, p.y, height * p.z} : Vec3{p.x, p.y, p.z < 0.0 ? -depth : p.z};
    }
    r.choose(positions, 0);
    for (std::size_t c = 0; c < r.contacts.size(); ++c) {
      ASSERT_NE(r.cache.plane(c), nullptr);
      EXPECT_NEAR(r.cache.plane(c)->depth, depth, 1e-12);
      EXPECT_NEAR(r.cache.plane(c)->direction.z, 1.0, 1e-12);
    }
  };
  expect(0.0, 1.0, 0.2);
  expect(0.3, 1.0, 0.2);  // friction drags the top along: the face stays where it is
  expect(1.0, 1.0, 0.15);
  expect(0.0, 0.5, 0.1);  // squeezed
  expect(-0.4, 1.7, 0.25);
}

TEST(PlaneCache, WhatNobodyComputedIsNotCached) {
  const Bodies bodies = three_balls();
  Cached r(bodies);
  const auto outcome = [](std::size_t c) {
    return c % 3 == 0 ? Outcome::none : c % 3 == 1 ? Outcome::propagated : Outcome::computed;
  };
  r.begin(r.pairs);  // a first detection
  r.cache.choose_none();
  r.update(outcome);
  r.choose(bodies.points_rest(), 0);
  for (std::size_t c = 0; c < r.contacts.size(); ++c)
    EXPECT_EQ(r.cache.source(c), c % 3 == 0 ? PlaneCache::neighbors : PlaneCache::cached);
  r.update([](std::size_t c) { return c % 3 == 0 ? Outcome::none : Outcome::cached; });
  // After contacts without a plane, guessed planes are computed before cached ones.
  const std::size_t guesses = (r.contacts.size() + 1) / 3;
  const std::size_t unknown = (r.contacts.size() + 2) / 3;
  r.choose(bodies.points_rest(), unknown + guesses);
  for (std::size_t c = 0; c < r.contacts.size(); ++c)
    EXPECT_EQ(r.cache.source(c), c % 3 == 2 ? PlaneCache::cached : PlaneCache::compute) << c;
  // What could not be computed keeps the plane that it had.
  r.update([](std::size_t) { return Outcome::none; });
  r.choose(bodies.points_rest(), 0);
  for (std::size_t c = 0; c < r.contacts.size(); ++c)
    EXPECT_EQ(r.cache.source(c), c % 3 == 0 ? PlaneCache::neighbors : PlaneCache::cached);
}

TEST(PlaneCache, WithoutACacheAllGoByAFew) {
  const Bodies bodies = three_balls();
  Cached r(bodies);
  r.tables = {};
  r.cache = {};
  r.choose(bodies.points_rest(), r.contacts.size() / 8);
  EXPECT_EQ(r.computed(), r.contacts.size() / 8);
  with_planes(r, bodies.points_rest());
}

TEST(DetectionBudget, SomeAreAlwaysFoundAnew) {
  DetectionSettings settings;
  settings.budget = Budget{.milliseconds = 1e-9};
  ClusterQueue tets(0);
  ClusterQueue triangles(0);
  DetectionBudget budget(settings, 1, tets, triangles);
  DetectionCounts counts;
  counts.contacts = 1000;
  budget.begin(1.0);
  EXPECT_EQ(budget.recomputed_contacts_limit(1000), 1000U) << "the first detection is not limited";
  budget.end({.depth = 1e-3}, 0, counts);
  budget.begin(1.0);
  for (const std::size_t contacts : {1U, 10U, 31U, 32U})
    EXPECT_EQ(budget.recomputed_contacts_limit(contacts), 1U);
  EXPECT_EQ(budget.recomputed_contacts_limit(1000), 32U);
}

TEST(DetectionBudget, AForecastThatIsTooHighLeavesTimeForPointsAndIsCorrected) {
  DetectionSettings settings;
  settings.budget = Budget{.milliseconds = 1e6};  // so long that this test takes nothing of it
  const Bodies bodies = three_balls();
  const Clusters clusters = make_tet_clusters(bodies);
  ClusterQueue tets(clusters.clusters.size());
  ClusterQueue triangles(0);
  DetectionBudget budget(settings, 3, tets, triangles);
  DetectionCounts counts;
  counts.contacts = 10;
  budget.begin(1.0);
  budget.end({.depth = 1e4}, 0, counts);
  counts.contacts = 0;
  constexpr int samples = 33;  // more than the forecast has
  for (int i = 0; i < samples; ++i) {
    budget.begin(1.0);
    EXPECT_TRUE(budget.points_limit()->allowance.time_left(0.99)) << i;
    tets.arrange(clusters, bodies.points_rest(), std::nullopt, [](const Cluster&) { return true; });
    budget.end({.crossings = 1.0}, 0, counts);
    EXPECT_EQ(counts.late_clusters, clusters.clusters.size());
  }
  budget.begin(1.0);
  EXPECT_TRUE(budget.points_limit()->allowance.time_left(0.1)) << "nothing in the last detections took long";
}

TEST(CostLine, FindsTheLineThatWorkLiesOn) {
  CostLine line(256.0);
  EXPECT_FALSE(line.known());
  for (int i = 0; i < 40; ++i) {
    const double work = 500.0 + 100.0 * (i % 7);
    line.add(work, 3e-4 + 2e-7 * work);
  }
  EXPECT_NEAR(line.of(200.0), 3e-4 + 2e-7 * 200.0, 2e-5);
  EXPECT_NEAR(line.of(3000.0), 3e-4 + 2e-7 * 3000.0, 6e-5);
}

TEST(CostLine, ATimeOfLittleWorkDoesNotMakeItDear) {
  // With one cost for each unit, 100 units at 320 us would make 3000 look like 9.6 ms.
  CostLine line(256.0);
  for (int i = 0; i < 40; ++i) line.add(i < 30 ? 3000.0 : 100.0, i < 30 ? 9e-4 : 3.2e-4);
  EXPECT_NEAR(line.of(3000.0), 9e-4, 1e-4);
}

TEST(CostLine, NoTimesMakeItNonsense) {
  // Work that comes and goes, and times that follow no line.
  std::uint64_t state = 1;
  const auto random = [&] {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state >> 40) / (1 << 24);
  };
  for (int round = 0; round < 2000; ++round) {
    CostLine line(256.0);
    double most = 0.0;
    for (int i = 0; i < 50; ++i) {
      const double work = random() < 0.3 ? random() < 0.5 ? 0.0 : 1.0 : 4000.0 * random();
      const double seconds = random() < 0.1 ? 0.0 : 1e-2 * random();
      most = std::max(most, seconds);
      line.add(work, seconds);
      ASSERT_TRUE(std::isfinite(line.fixed()) && std::isfinite(line.each()));
      ASSERT_GE(line.fixed(), 0.0);
      ASSERT_GE(line.each(), 0.0);
    }
    // No more than twice as much as the dearest of all was for so little work.
    EXPECT_LT(line.fixed(), 2.0 * most);
  }
}

TEST(CostLine, AlikeWorkIsTakenForTheUsualLine) {
  CostLine line(256.0);
  for (int i = 0; i < 5; ++i) line.add(1000.0, 1e-3);
  EXPECT_NEAR(line.of(1000.0), 1e-3, 1e-12);
  EXPECT_NEAR(line.fixed(), 1e-3 * 256.0 / 1256.0, 1e-12);
}

TEST(CostLine, OneTimePutAsideDoesNotCount) {
  CostLine line(256.0);
  for (int i = 0; i < 32; ++i) line.add(1000.0, i == 20 ? 0.5 : 1e-3);
  EXPECT_LE(line.of(1000.0), 1.5e-3);
}

}  // namespace
}  // namespace palpate
