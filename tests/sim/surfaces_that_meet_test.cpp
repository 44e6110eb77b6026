// Frames of piles in motion: two bodies have a contact exactly where their surfaces intersect or one is
// inside the other. Oracle: all pairs of surface triangles in exact arithmetic.
#include <algorithm>
#include <gtest/gtest.h>
#include <set>
#include <utility>

#include "sim/random_scenes.hpp"
#include "support/surfaces_meet.hpp"

namespace palpate {
namespace {

using Pair = std::pair<Index, Index>;

/// Pairs of different bodies with a contact of a point or of an edge.
std::set<Pair> pairs_in_contact(const Simulation& simulation) {
  const Bodies& bodies = simulation.bodies();
  std::set<Pair> pairs;
  const auto add = [&](Index a, Index b) {
    if (a != b) pairs.insert({std::min(a, b), std::max(a, b)});
  };
  const Contacts& points = simulation.detector().contacts();
  for (std::size_t c = 0; c < points.size(); ++c)
    add(at(bodies.body_of_point(), points.point[c]), points.body[c]);
  const EdgeContacts& edges = simulation.detector().edge_contacts();
  for (std::size_t c = 0; c < edges.size(); ++c)
    add(bodies.body_of(at(bodies.edges(), edges.edge[c])), edges.body[c]);
  return pairs;
}

struct Found {
  std::size_t met = 0;  ///< pairs, in all frames
  int frames = 0;
  int without_points = 0;  ///< frames whose only contacts are of edges
  int at_rest = 0;         ///< piles
};

/// Compares all frames of a random pile, until it rests.
void check_pile(std::uint64_t seed, int most_steps, bool meet_themselves, Found& found) {
  test::RandomScene scene(seed);
  if (meet_themselves) scene.settings.detection.self_collision.assign(scene.model.bodies.bodies().size(), 1);
  Simulation simulation(std::move(scene.model), scene.settings, 1);
  const Bodies& bodies = simulation.bodies();
  for (int step = 0; step < most_steps && !simulation.at_rest(); ++step, ++found.frames) {
    simulation.step();
    std::set<Pair> expected;
    for (Index a = 0; a < bodies.body_count(); ++a) {
      for (Index b = a + 1; b < bodies.body_count(); ++b) {
        const test::Meeting meeting = test::rational_meeting(bodies, simulation.positions(), a, b);
        if (meeting.surfaces || meeting.nested) expected.insert({a, b});
      }
    }
    ASSERT_EQ(pairs_in_contact(simulation), expected) << "seed " << seed << ", step " << step;
    found.met += expected.size();
    if (!expected.empty() && simulation.detector().contacts().size() == 0) ++found.without_points;
  }
  if (simulation.at_rest()) ++found.at_rest;
}

TEST(EdgeContactsOfPiles, AreThereWhereverSurfacesIntersectInAnyFrame) {
  Found found;
  for (const std::uint64_t seed : {1, 2, 3, 5, 8, 13}) check_pile(seed, 80, false, found);
  EXPECT_GT(found.met, 300U);
  EXPECT_GT(found.without_points, 0);
}

TEST(EdgeContactsOfPiles, AreThereWithSelfCollision) {
  Found found;
  for (const std::uint64_t seed : {4, 6}) check_pile(seed, 80, true, found);
  EXPECT_GT(found.met, 100U);
}

TEST(EdgeContactsOfPiles, DISABLED_AreThereUntilSixtyPilesRest) {
  Found found;
  for (std::uint64_t seed = 100; seed < 160; ++seed) check_pile(seed, 400, seed % 2 == 0, found);
  EXPECT_GT(found.met, 20000U);
  EXPECT_GT(found.without_points, 30);
  EXPECT_GT(found.at_rest, 10);
}

}  // namespace
}  // namespace palpate
