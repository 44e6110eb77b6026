// Oracle: the scenes, in which bodies cross by construction; and the detection with edge contacts.
#include <algorithm>
#include <cstdint>
#include <gtest/gtest.h>
#include <set>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/scenes.hpp"
#include "support/crossed_arms.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

DetectionSettings of_points() {
  DetectionSettings settings;
  settings.edge_contacts = false;
  return settings;
}

std::size_t unseen(const Bodies& bodies, const std::vector<std::uint8_t>& immovable = {}) {
  Detector detector(bodies, of_points(), immovable, 1);
  detector.detect(bodies.points_rest());
  return detector.counts().unseen_pairs;
}

/// Two bars of 200 x 20 x 20 mm, one across the other.
Bodies crossed_bars(double height_of_upper) {
  Bodies bodies;
  bodies.add("lower", test::box_mesh({1, 1, 1}, {-0.1, -0.01, -0.01}, {0.1, 0.01, 0.01}));
  bodies.add("upper", test::box_mesh({1, 1, 1}, {-0.01, -0.1, height_of_upper - 0.01},
                                     {0.01, 0.1, height_of_upper + 0.01}));
  return bodies;
}

TEST(UnseenPairs, AreBodiesThatCrossWithoutAContact) {
  EXPECT_EQ(unseen(crossed_bars(0.019)), 1U) << "1 mm deep";
  EXPECT_EQ(unseen(crossed_bars(0.021)), 0U) << "apart";
  EXPECT_EQ(unseen(crossed_bars(0.02)), 0U) << "they touch";
  EXPECT_EQ(unseen(crossed_bars(0.019), {1, 1}), 0U) << "obstacles";
  Bodies boxes;
  boxes.add("large", test::box_mesh({1, 1, 1}, {0, 0, 0}, {1, 1, 1}));
  boxes.add("small", test::box_mesh({1, 1, 1}, {0.4, 0.4, 0.9}, {0.6, 0.6, 1.1}));
  EXPECT_EQ(unseen(boxes), 0U) << "points of one are in the other: a contact";
}

TEST(UnseenPairs, OfABodyWithItselfNeedSelfCollision) {
  for (const bool itself : {true, false}) {
    Bodies bodies;
    bodies.add("arms", test::crossed_arms(-0.001));
    DetectionSettings settings = of_points();
    settings.self_collision = {static_cast<std::uint8_t>(itself)};
    Detector detector(bodies, settings, {}, 1);
    detector.detect(bodies.points_rest());
    EXPECT_EQ(detector.contacts().size(), 0U);
    EXPECT_EQ(detector.counts().unseen_pairs, itself ? 1U : 0U);
  }
}

/// The search is made in every eighth detection only, and between them the number stays.
TEST(UnseenPairs, AreSoughtInSomeDetections) {
  const Bodies bodies = crossed_bars(0.019);
  const std::vector<Vec3> together(bodies.points_rest().begin(), bodies.points_rest().end());
  std::vector<Vec3> apart = together;
  const Range upper = bodies.bodies()[1].points;
  for (Index p = upper.begin; p < upper.end; ++p) at(apart, p).z += 1.0;
  Detector detector(bodies, of_points(), {}, 1);
  detector.detect(together);
  for (int later = 1; later <= 16; ++later) {
    detector.detect(later <= 8 ? apart : together);
    EXPECT_EQ(detector.counts().unseen_pairs, later < 8 || later == 16 ? 1U : 0U) << later;
  }
}

/// Pairs with edge contacts and without contacts of points, in scenes in which no two bodies just touch.
TEST(UnseenPairs, HaveEdgeContactsOnly) {
  std::size_t all = 0;
  for (const int kind : {0, 8, 9, 10, 11}) {
    for (std::uint64_t seed = 0; seed < 25; ++seed) {
      const test::ContactScene scene = test::make_contact_scene(kind, seed);
      const Bodies& bodies = scene.bodies;
      Detector with_edges(bodies, {}, scene.immovable, 1);
      with_edges.detect(scene.positions);
      const Contacts& points = with_edges.contacts();
      const EdgeContacts& edges = with_edges.edge_contacts();
      std::set<std::pair<Index, Index>> seen;
      std::set<std::pair<Index, Index>> crossed;
      for (std::size_t c = 0; c < points.size(); ++c)
        seen.insert(std::minmax(at(bodies.body_of_point(), points.point[c]), points.body[c]));
      for (std::size_t c = 0; c < edges.size(); ++c) {
        const std::pair<Index, Index> pair =
            std::minmax(bodies.body_of(at(bodies.edges(), edges.edge[c])), edges.body[c]);
        if (!seen.contains(pair)) crossed.insert(pair);
      }
      Detector without(bodies, of_points(), scene.immovable, 2);
      without.detect(scene.positions);
      EXPECT_EQ(without.counts().unseen_pairs, crossed.size()) << "kind " << kind << " seed " << seed;
      all += crossed.size();
    }
  }
  EXPECT_GT(all, 20U);
}

}  // namespace
}  // namespace palpate
