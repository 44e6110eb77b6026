// What contacts remember of their way out. Oracles: rotations and distances by hand, lines of cost by hand.
#include "contact/remembered_planes.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <numbers>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/border_edges.hpp"
#include "contact/contact_list.hpp"
#include "contact/cost_line.hpp"
#include "contact/crossings.hpp"
#include "contact/depth.hpp"
#include "contact/detection_budget.hpp"
#include "geometry/vector.hpp"
#include "grid/brute.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

using Planes = RememberedPlanes;

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

struct Remembering {
  explicit Remembering(const Bodies& b) : bodies(b), contacts(contacts_of(b, b.points_rest())) {
    planes.remember(threads, bodies, bodies.points_rest(), contacts,
                    [](std::size_t) { return Planes::Outcome::found; });
  }
  std::size_t anew() const {
    return static_cast<std::size_t>(std::ranges::count(planes.sources(), std::uint8_t{Planes::anew}));
  }
  const Bodies& bodies;
  Contacts contacts;
  parallel::Threads threads{1};
  Planes planes;
};

TEST(RememberedPlanes, GoWithABodyThatTurns) {
  const Bodies bodies = three_balls();
  Remembering r(bodies);
  ASSERT_GT(r.contacts.size(), 50U);
  const std::vector<Vec3> positions = all_moved(bodies.points_rest());
  r.planes.choose(r.threads, bodies, positions, r.contacts, 0);
  EXPECT_EQ(r.planes.spared(), r.contacts.size());
  for (std::size_t c = 0; c < r.contacts.size(); ++c) {
    ASSERT_EQ(r.planes.source(c), Planes::remembered);
    const WayOut& way = *r.planes.way_out(c);
    EXPECT_NEAR(way.depth, r.contacts.depth[c], 1e-12);
    const Vec3 expected = moved(r.contacts.direction[c]) - moved(Vec3{});
    EXPECT_LT(length(way.direction - expected), 1e-9);
    EXPECT_EQ(way.certainty, r.contacts.certainty[c]);
  }
}

TEST(RememberedPlanes, APointComesNearerToItsPlaneOrGoesDeeper) {
  const Bodies bodies = bar_in_a_plate();
  Remembering r(bodies);
  ASSERT_EQ(r.contacts.size(), 4U);
  const Range bar = bodies.bodies()[1].points;
  for (const double up : {-0.15, 0.05, 0.25}) {
    std::vector<Vec3> positions(bodies.points_rest().begin(), bodies.points_rest().end());
    for (Index p = bar.begin; p < bar.end; ++p) at(positions, p) += Vec3{0.1, -0.05, up};
    r.planes.choose(r.threads, bodies, positions, r.contacts, 0);
    for (std::size_t c = 0; c < 4; ++c) {
      ASSERT_NE(r.planes.way_out(c), nullptr);
      EXPECT_NEAR(r.planes.way_out(c)->depth, std::max(0.0, 0.2 - up), 1e-12);
    }
  }
}

TEST(RememberedPlanes, WhoHasLeftItsPlaceKnowsNothing) {
  const Bodies bodies = bar_in_a_plate();
  Remembering r(bodies);
  std::vector<Vec3> positions(bodies.points_rest().begin(), bodies.points_rest().end());
  const Range bar = bodies.bodies()[1].points;
  // Edges of the plate's tets are 1 to 1.42 long.
  for (Index p = bar.begin; p < bar.end; ++p) at(positions, p).x += 0.75;
  r.planes.choose(r.threads, bodies, positions, r.contacts, 0);
  for (std::size_t c = 0; c < r.contacts.size(); ++c) {
    EXPECT_EQ(r.planes.source(c), Planes::neighbors);
    EXPECT_EQ(r.planes.way_out(c), nullptr);
  }
}

TEST(RememberedPlanes, TheOldestAreFoundAnew) {
  const Bodies bodies = three_balls();
  Remembering r(bodies);
  const std::size_t most = r.contacts.size() / 4 + 1;
  std::map<std::size_t, int> times;
  for (int round = 0; round < 8; ++round) {
    r.planes.choose(r.threads, bodies, bodies.points_rest(), r.contacts, most);
    EXPECT_EQ(r.anew(), most);
    for (std::size_t c = 0; c < r.contacts.size(); ++c)
      if (r.planes.source(c) == Planes::anew) ++times[c];
    r.planes.remember(r.threads, bodies, bodies.points_rest(), r.contacts, [&](std::size_t c) {
      return r.planes.source(c) == Planes::anew ? Planes::Outcome::found : Planes::Outcome::remembered;
    });
  }
  ASSERT_EQ(times.size(), r.contacts.size()) << "each in its turn";
  for (const auto& [contact, count] : times) {
    EXPECT_GE(count, 2) << "contact " << contact;
    EXPECT_LE(count, 3) << "contact " << contact;
  }
}

TEST(RememberedPlanes, TheRegionOfInterestComesMoreOften) {
  const Bodies bodies = three_balls();
  Remembering r(bodies);
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
    r.planes.choose(r.threads, bodies, bodies.points_rest(), r.contacts, times.size() / 8, region);
    EXPECT_EQ(r.anew(), times.size() / 8);
    for (std::size_t c = 0; c < times.size(); ++c) times[c] += r.planes.source(c) == Planes::anew ? 1 : 0;
    r.planes.remember(r.threads, bodies, bodies.points_rest(), r.contacts, [&](std::size_t c) {
      return r.planes.source(c) == Planes::anew ? Planes::Outcome::found : Planes::Outcome::remembered;
    });
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

TEST(RememberedPlanes, ThoseThatKnowNothingComeFirstAndFromEverywhere) {
  const Bodies bodies = three_balls();
  Remembering r(bodies);
  // Remembers only every second contact.
  Contacts half;
  for (std::size_t c = 0; c < r.contacts.size(); c += 2) {
    half.point.push_back(r.contacts.point[c]);
    half.body.push_back(r.contacts.body[c]);
    half.tet.push_back(r.contacts.tet[c]);
    half.weights.push_back(r.contacts.weights[c]);
    half.depth.push_back(r.contacts.depth[c]);
    half.direction.push_back(r.contacts.direction[c]);
    half.certainty.push_back(r.contacts.certainty[c]);
  }
  const auto found = [](std::size_t) { return Planes::Outcome::found; };
  r.planes.remember(r.threads, bodies, bodies.points_rest(), half, found);
  const std::size_t unknown = r.contacts.size() - half.size();

  r.planes.choose(r.threads, bodies, bodies.points_rest(), r.contacts, unknown / 5);
  EXPECT_EQ(r.anew(), unknown / 5);
  std::size_t gap = 0;
  for (std::size_t c = 1; c < r.contacts.size(); c += 2) {
    gap = r.planes.source(c) == Planes::anew ? 0 : gap + 1;
    EXPECT_LE(gap, 7U) << "a region without one that knows";
  }
  const std::size_t enough = unknown + unknown / 2;
  r.planes.choose(r.threads, bodies, bodies.points_rest(), r.contacts, enough);
  EXPECT_EQ(r.anew(), enough);
  for (std::size_t c = 1; c < r.contacts.size(); c += 2) EXPECT_EQ(r.planes.source(c), Planes::anew);
}

/// Depths of the contacts where not all are found anew.
Contacts with_planes(const Remembering& r, std::span<const Vec3> positions) {
  std::vector<PointInTet> found;
  for (std::size_t c = 0; c < r.contacts.size(); ++c)
    found.push_back({r.contacts.point[c], r.contacts.tet[c]});
  ContactList list;
  list.assign(r.threads, r.bodies, positions, found);
  BorderEdges border_edges(r.bodies);
  border_edges.find(r.threads, r.bodies, positions, list, r.planes.sources());
  for (const BorderEdge& edge : border_edges.edges())
    EXPECT_EQ(r.planes.source(static_cast<std::size_t>(edge.contact)), Planes::anew);
  BruteForce edges;
  CrossingQuery crossings;
  crossings.find(r.threads, r.bodies, positions, list.contacts(), border_edges.edges(),
                 Lattice({{-100, -100, -100}, {100, 100, 100}}, 1.0), edges, CellSlots(0, 0));
  DepthEstimate depth(r.bodies);
  const DepthCounts counts =
      depth.compute(r.threads, r.bodies, positions, list, border_edges, crossings, r.planes);
  EXPECT_EQ(counts.rough_depths, r.planes.spared());
  for (std::size_t c = 0; c < r.contacts.size(); ++c)
    EXPECT_EQ(depth.outcome(c) == Planes::Outcome::found, r.planes.source(c) == Planes::anew);
  return list.contacts();
}

TEST(RememberedPlanes, DepthsOfSomeContactsDoNotSufferFromTheOthersGoingByTheirs) {
  const Bodies bodies = three_balls();
  const std::vector<Vec3> positions = all_moved(bodies.points_rest());
  const Contacts exact = contacts_of(bodies, positions);
  for (const std::size_t part : {1U, 2U, 8U}) {
    Remembering r(bodies);
    r.planes.choose(r.threads, bodies, positions, r.contacts, r.contacts.size() / part);
    const Contacts contacts = with_planes(r, positions);
    ASSERT_EQ(contacts.point, exact.point);
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      // Nothing has changed but for the turn: what is remembered is right, and what is found anew sees it.
      const double bound = part == 1 ? 1e-9 : 0.05;
      EXPECT_NEAR(contacts.depth[c], exact.depth[c], bound * 0.01) << "part " << part;
      EXPECT_LT(length(contacts.direction[c] - exact.direction[c]), bound) << "part " << part;
    }
  }
}

TEST(RememberedPlanes, ContactsThatKnowNothingGoByTheirNeighbors) {
  const Bodies bodies = three_balls();
  const Contacts exact = contacts_of(bodies, bodies.points_rest());
  Remembering r(bodies);
  // Nothing fits any more, as after a jump: a quarter is found anew.
  Contacts elsewhere = r.contacts;
  for (std::size_t c = 0; c < elsewhere.size(); ++c) elsewhere.weights[c] = {5, -2, -1, -1};
  const auto found = [](std::size_t) { return Planes::Outcome::found; };
  r.planes.remember(r.threads, bodies, bodies.points_rest(), elsewhere, found);
  r.planes.choose(r.threads, bodies, bodies.points_rest(), r.contacts, r.contacts.size() / 4);
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

TEST(RememberedPlanes, ThePlaneDeformsWithTheTissue) {
  const Bodies bodies = bar_in_a_plate();
  Remembering r(bodies);
  ASSERT_EQ(r.contacts.size(), 4U);
  const Range plate = bodies.bodies()[0].points;
  const auto expect = [&](double shear, double height, double depth) {
    std::vector<Vec3> positions(bodies.points_rest().begin(), bodies.points_rest().end());
    for (Vec3& p : positions) {
      const bool of_plate = &p - positions.data() < plate.end;
      p = of_plate ? Vec3{p.x + shear * p.z, p.y, height * p.z} : Vec3{p.x, p.y, p.z < 0.0 ? -depth : p.z};
    }
    r.planes.choose(r.threads, bodies, positions, r.contacts, 0);
    for (std::size_t c = 0; c < r.contacts.size(); ++c) {
      ASSERT_NE(r.planes.way_out(c), nullptr);
      EXPECT_NEAR(r.planes.way_out(c)->depth, depth, 1e-12);
      EXPECT_NEAR(r.planes.way_out(c)->direction.z, 1.0, 1e-12);
    }
  };
  expect(0.0, 1.0, 0.2);
  expect(0.3, 1.0, 0.2);  // friction drags the top along: the face stays where it is
  expect(1.0, 1.0, 0.15);
  expect(0.0, 0.5, 0.1);  // squeezed
  expect(-0.4, 1.7, 0.25);
}

TEST(RememberedPlanes, WhatNobodyKnewIsNotRemembered) {
  const Bodies bodies = three_balls();
  Remembering r(bodies);
  const auto outcome = [](std::size_t c) {
    return c % 3 == 0   ? Planes::Outcome::none
           : c % 3 == 1 ? Planes::Outcome::guessed
                        : Planes::Outcome::found;
  };
  RememberedPlanes planes;  // of a first detection
  planes.remember(r.threads, bodies, bodies.points_rest(), r.contacts, outcome);
  planes.choose(r.threads, bodies, bodies.points_rest(), r.contacts, 0);
  for (std::size_t c = 0; c < r.contacts.size(); ++c)
    EXPECT_EQ(planes.source(c), c % 3 == 0 ? Planes::neighbors : Planes::remembered);
  // Of the others, guesses come first.
  const std::size_t guesses = (r.contacts.size() + 1) / 3;
  const std::size_t unknown = (r.contacts.size() + 2) / 3;
  planes.choose(r.threads, bodies, bodies.points_rest(), r.contacts, unknown + guesses);
  for (std::size_t c = 0; c < r.contacts.size(); ++c)
    EXPECT_EQ(planes.source(c), c % 3 == 2 ? Planes::remembered : Planes::anew) << c;
  // What was not found anew does not forget the plane that it had.
  planes.remember(r.threads, bodies, bodies.points_rest(), r.contacts,
                  [](std::size_t) { return Planes::Outcome::none; });
  planes.choose(r.threads, bodies, bodies.points_rest(), r.contacts, 0);
  for (std::size_t c = 0; c < r.contacts.size(); ++c)
    EXPECT_EQ(planes.source(c), c % 3 == 0 ? Planes::neighbors : Planes::remembered);
}

TEST(RememberedPlanes, WithoutAnyMemoryAllGoByAFew) {
  const Bodies bodies = three_balls();
  Remembering r(bodies);
  r.planes = {};
  r.planes.choose(r.threads, bodies, bodies.points_rest(), r.contacts, r.contacts.size() / 8);
  EXPECT_EQ(r.anew(), r.contacts.size() / 8);
  with_planes(r, bodies.points_rest());
}

TEST(DetectionBudget, SomeAreAlwaysFoundAnew) {
  DetectionSettings settings;
  settings.budget = Budget{.milliseconds = 1e-9};
  DetectionBudget budget(settings, 1);
  DetectionCounts counts;
  counts.contacts = 1000;
  budget.begin(1.0);
  EXPECT_EQ(budget.contacts_anew(1000), 1000U) << "the first detection is not limited";
  budget.end({.depth = 1e-3}, 0, nullptr, nullptr, counts);
  budget.begin(1.0);
  for (const std::size_t contacts : {1U, 10U, 31U, 32U}) EXPECT_EQ(budget.contacts_anew(contacts), 1U);
  EXPECT_EQ(budget.contacts_anew(1000), 32U);
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
