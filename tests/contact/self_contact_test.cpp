// Oracles: the same shapes as bodies of their own; rational arithmetic; a strip folded by formula.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

#include <palpate/detection.hpp>
#include <palpate/error.hpp>

#include "contact/rational_fold.hpp"
#include "contact/scenes.hpp"
#include "geometry/box.hpp"
#include "geometry/vector.hpp"
#include "support/rational.hpp"

namespace palpate {
namespace {

Detector self_detector(const Bodies& bodies, Structure structure = Structure::compact, int threads = 1) {
  DetectionSettings settings;
  settings.structure = structure;
  settings.self_collision.assign(bodies.bodies().size(), 1);
  return Detector(bodies, settings, {}, threads);
}

constexpr std::array structures{Structure::uniform, Structure::compact, Structure::hash, Structure::cuckoo,
                                Structure::brute};

/// One mesh of several, which share nothing.
TetMesh joined(const std::vector<TetMesh>& parts) {
  TetMesh all;
  for (const TetMesh& part : parts) all = test::joined(std::move(all), part);
  return all;
}

/// Parts of one body meet each other as bodies of their own do: the same points in the same tets, the same
/// border edges and crossings, and the same depths.
void expect_parts_meet_like_bodies(const std::vector<TetMesh>& parts, std::size_t& contacts) {
  Bodies apart;
  for (const TetMesh& part : parts) apart.add("part " + std::to_string(apart.body_count()), part);
  Bodies one;
  one.add("all", joined(parts));
  Detector of_bodies(apart, {}, {}, 1);
  of_bodies.detect(apart.points_rest());
  for (const Structure structure : structures) {
    Detector of_itself = self_detector(one, structure);
    of_itself.detect(one.points_rest());
    const Contacts& a = of_bodies.contacts();
    const Contacts& b = of_itself.contacts();
    ASSERT_EQ(a.point, b.point);
    ASSERT_EQ(a.tet, b.tet);
    ASSERT_EQ(of_itself.border_edges().size(), of_bodies.border_edges().size());
    // An edge from one layer into the next enters that, which no edge does that looks for one body.
    ASSERT_GE(of_itself.crossings().size(), of_bodies.crossings().size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      ASSERT_NEAR(a.depth[i], b.depth[i], 1e-4) << "contact " << i << " of point " << a.point[i];
      ASSERT_NEAR(length(a.direction[i] - b.direction[i]) * a.certainty[i], 0.0, 1e-4)
          << "contact " << i << " of point " << a.point[i];
    }
    EXPECT_EQ(of_itself.counts().folded_pairs, 0U);
  }
  contacts += of_bodies.contacts().size();
}

TEST(SelfContact, TwoPartsOfABodyMeetLikeTwoBodies) {
  std::size_t contacts = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    const Vec3 shift = seed % 2 == 0 ? random.grid_point(-4, 4, 0.25) : random.point(-1, 1);
    std::vector<TetMesh> parts{test::box_mesh({3, 3, 3}, {-1, -1, -1}, {1, 1, 1})};
    if (seed % 3 == 0)
      parts.push_back(test::ball_mesh(4, shift, 0.7));
    else
      parts.push_back(test::box_mesh({2, 2, 2}, shift, shift + Vec3{1, 1, 1}));
    ASSERT_NO_FATAL_FAILURE(expect_parts_meet_like_bodies(parts, contacts));
  }
  EXPECT_GT(contacts, 500U);
}

TEST(SelfContact, ALayerBetweenTwoOthersIsPushedByEachAsIfItWereAlone) {
  // Three plates: points on both sides of the thin one in the middle are in contact, and its edges lead from
  // one of its neighbours straight into the other.
  std::size_t contacts = 0;
  const std::vector<TetMesh> plates{test::box_mesh({8, 8, 2}, {-4, -4, -1}, {4, 4, 0}),
                                    test::box_mesh({5, 5, 1}, {-1.9, -2.1, -0.1}, {2.1, 1.9, 0.4}),
                                    test::box_mesh({7, 7, 2}, {-3.6, -3.4, 0.3}, {3.6, 3.4, 1.3})};
  expect_parts_meet_like_bodies(plates, contacts);
  EXPECT_GT(contacts, 72U);
  Bodies one;
  one.add("all", joined(plates));
  Detector detector = self_detector(one);
  detector.detect(one.points_rest());
  std::size_t up = 0;
  std::size_t down = 0;
  for (std::size_t c = 0; c < detector.contacts().size(); ++c) {
    const Vec3& p = at(one.points_rest(), detector.contacts().point[c]);
    if (std::abs(p.z + 0.1) < 1e-12) {
      ++up;
      EXPECT_NEAR(detector.contacts().direction[c].z, 1.0, 1e-12);
      EXPECT_NEAR(detector.contacts().depth[c], 0.1, 1e-12);
    } else if (std::abs(p.z - 0.4) < 1e-12) {
      ++down;
      EXPECT_NEAR(detector.contacts().direction[c].z, -1.0, 1e-12);
      EXPECT_NEAR(detector.contacts().depth[c], 0.1, 1e-12);
    }
  }
  EXPECT_EQ(up, 36U);
  EXPECT_EQ(down, 36U);
}

/// A strip of length 8 and thickness 0.2 bent over itself: flat, half a circle up, back down along a cosine,
/// and flat again, where it is `overlap` deep in its first part.
std::vector<Vec3> folded_strip(const Bodies& bodies, double overlap) {
  constexpr double thickness = 0.2;
  constexpr double radius = 0.5;
  const double drop = 2.0 * radius - (thickness - overlap);
  std::vector<Vec3> x;
  for (const Vec3& rest : bodies.points_rest()) {
    Vec3 centre;
    Vec3 normal{0, 0, 1};
    const double s = rest.x;
    if (s < 4.0) {
      centre = {s, 0, 0};
    } else if (s < 5.0) {
      const double a = (s - 4.0) * std::numbers::pi;
      centre = {4.0 + radius * std::sin(a), 0, radius * (1.0 - std::cos(a))};
      normal = {-std::sin(a), 0, std::cos(a)};
    } else {
      const double t = std::min(1.0, (s - 5.0) / 2.0);
      const double a = t * std::numbers::pi;
      centre = {4.0 - (s - 5.0), 0, 2.0 * radius - 0.5 * drop * (1.0 - std::cos(a))};
      const double slope = t < 1.0 ? 0.25 * drop * std::numbers::pi * std::sin(a) : 0.0;
      normal = normalized(Vec3{slope, 0, -1});
    }
    // A little askew, so that the rims of the layers do not lie on each other.
    x.push_back(centre + rest.z * normal + Vec3{0, rest.y + 0.017 * s, 0});
  }
  return x;
}

TEST(SelfContact, OfAFoldedStripIsAsDeepAsItOverlaps) {
  Bodies bodies;
  bodies.add("strip", test::box_mesh({64, 6, 2}, {0, -0.5, -0.1}, {8, 0.5, 0.1}));
  for (const double overlap : {0.05, 0.011}) {
    const std::vector<Vec3> x = folded_strip(bodies, overlap);
    Detector detector = self_detector(bodies);
    detector.detect(x);
    EXPECT_EQ(detector.counts().folded_pairs, 0U);
    EXPECT_EQ(detector.counts().depth_fallbacks, 0U);
    EXPECT_EQ(detector.counts().border_edges_without_crossing, 0U);
    const Contacts& contacts = detector.contacts();
    std::size_t checked = 0;
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      const Vec3& p = at(x, contacts.point[c]);
      if (p.x < 1.2 || p.x > 1.8 || std::abs(p.y) > 0.25) continue;  // away from rims and from the bend
      ++checked;
      EXPECT_NEAR(contacts.depth[c], overlap, 0.03 * overlap);
      const bool lower = at(bodies.points_rest(), contacts.point[c]).x < 4.0;
      EXPECT_NEAR(contacts.direction[c].z, lower ? -1.0 : 1.0, 1e-3);
    }
    EXPECT_GE(checked, 30U);
  }
  const std::vector<Vec3> open = folded_strip(bodies, -0.001);
  Detector detector = self_detector(bodies);
  detector.detect(open);
  EXPECT_EQ(detector.contacts().size(), 0U) << "a gap, and tight bends that touch nothing";
}

TEST(SelfContact, IsOffUnlessAskedForAndNeverOfAnImmovableBody) {
  Bodies bodies;
  bodies.add("strip", test::box_mesh({64, 2, 2}, {0, -0.5, -0.1}, {8, 0.5, 0.1}));
  bodies.add("far", test::box_mesh({1, 1, 1}, {50, 0, 0}, {51, 1, 1}));
  std::vector<Vec3> x = folded_strip(bodies, 0.05);
  Detector off(bodies, {});
  off.detect(x);
  EXPECT_EQ(off.contacts().size(), 0U);
  DetectionSettings settings;
  settings.self_collision = {1, 0};
  Detector rigid(bodies, settings, {1, 0});
  rigid.detect(x);
  EXPECT_EQ(rigid.contacts().size(), 0U);
  Detector on(bodies, settings);
  on.detect(x);
  EXPECT_GT(on.contacts().size(), 10U);
  settings.self_collision = {1};
  EXPECT_THROW(Detector(bodies, settings), Error) << "one flag for two bodies";
}

TEST(SelfContact, AMeshThatIsNotFoldedDoesNotTouchItself) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    test::Random random(seed);
    Bodies bodies;
    bodies.add("ball", test::ball_mesh(4, random.point(-1, 1), 0.8));
    bodies.add("box", test::box_mesh({3, 4, 2}, {4, 0, 0}, {5.1, 0.7, 0.3}));
    // Stretched and sheared by an affine map, which keeps every tet where it belongs, up to rounding; then
    // shaken by less than what could turn one.
    const Vec3 shear = random.point(-0.5, 0.5);
    std::vector<Vec3> x(bodies.points_rest().begin(), bodies.points_rest().end());
    for (Vec3& p : x) {
      p = {p.x + shear.x * p.y, 1.3 * p.y + shear.y * p.z, p.z + shear.z * p.x};
      p += 0.004 * random.point(-1, 1);
    }
    Detector detector = self_detector(bodies);
    detector.detect(x);
    EXPECT_EQ(detector.contacts().size(), 0U) << "seed " << seed;
    EXPECT_EQ(detector.counts().folded_pairs, 0U) << "seed " << seed;
  }
}

TEST(SelfContact, APointPushedThroughItsNeighboursIsAFoldAndNoContact) {
  Bodies bodies;
  bodies.add("box", test::box_mesh({4, 4, 4}, {0, 0, 0}, {4, 4, 4}));
  std::vector<Vec3> x(bodies.points_rest().begin(), bodies.points_rest().end());
  const Index inner = 2 + 5 * (2 + 5 * 2);
  ASSERT_EQ(at(x, inner), (Vec3{2, 2, 2}));
  at(x, inner) += Vec3{1.2, 0.3, 0.1};  // beyond its neighbour, with all its tets on that side inside out
  Detector detector = self_detector(bodies);
  detector.detect(x);
  EXPECT_GT(detector.counts().folded_pairs, 0U);
  EXPECT_EQ(detector.contacts().size(), 0U);
}

TEST(SelfContact, AgreesWithRationalArithmeticWhateverIsFoldedOrInsideOut) {
  std::size_t contacts = 0;
  std::size_t folds = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    Bodies bodies;
    bodies.add("bar", test::box_mesh({8, 1, 1}, {0, 0, 0}, {8, 1, 1}));
    std::vector<Vec3> x(bodies.points_rest().begin(), bodies.points_rest().end());
    // The far end comes back over the near one; on a grid, so that points lie on faces and edges.
    const Vec3 by = random.grid_point(-2, 2, 0.25) + Vec3{-6, 0, 0};
    for (Vec3& p : x) {
      if (p.x >= 6.0) p += by;
      if (random.chance(seed % 3 == 0 ? 0.15 : 0.0)) p += random.grid_point(-3, 3, 0.25);
    }
    std::map<Index, Index> lowest;  // point -> tet
    std::size_t folded = 0;
    for (Index p = 0; p < static_cast<Index>(x.size()); ++p) {
      for (Index t = 0; t < static_cast<Index>(bodies.tets().size()); ++t) {
        const Tet& tet = at(bodies.tets(), t);
        if (std::find(tet.begin(), tet.end(), p) != tet.end()) continue;
        if (!box_of(std::span<const Vec3>(x), tet).contains(at(x, p))) continue;
        if (!test::rational_point_in_tet(at(x, p), at(x, tet[0]), at(x, tet[1]), at(x, tet[2]),
                                         at(x, tet[3])))
          continue;
        if (test::rational_fold(bodies, x, p, tet))
          ++folded;
        else
          lowest.try_emplace(p, t);
      }
    }
    for (const Structure structure : structures) {
      Detector detector = self_detector(bodies, structure, 2);
      detector.detect(x);
      const Contacts& found = detector.contacts();
      ASSERT_EQ(found.size(), lowest.size());
      for (std::size_t c = 0; c < found.size(); ++c) {
        ASSERT_EQ(lowest.at(found.point[c]), found.tet[c]);
        ASSERT_TRUE(std::isfinite(found.depth[c]) && found.depth[c] >= 0.0);
        ASSERT_NEAR(length(found.direction[c]), 1.0, 1e-12);
      }
      ASSERT_EQ(detector.counts().folded_pairs, folded);
    }
    contacts += lowest.size();
    folds += folded;
  }
  EXPECT_GT(contacts, 50U);
  EXPECT_GT(folds, 50U);
}

TEST(SelfContact, EveryStructureAndThreadCountGivesTheSameBits) {
  Bodies bodies;
  bodies.add("strip", test::box_mesh({64, 4, 2}, {0, -0.5, -0.1}, {8, 0.5, 0.1}));
  const std::vector<Vec3> x = folded_strip(bodies, 0.03);
  Detector brute = self_detector(bodies, Structure::brute);
  brute.detect(x);
  ASSERT_GT(brute.contacts().size(), 50U);
  int threads = 1;
  for (const Structure structure : structures) {
    Detector detector = self_detector(bodies, structure, ++threads);
    detector.detect(x);
    EXPECT_EQ(detector.contacts().tet, brute.contacts().tet);
    EXPECT_EQ(detector.contacts().depth, brute.contacts().depth);
    EXPECT_EQ(detector.contacts().direction, brute.contacts().direction);
    EXPECT_EQ(detector.crossings().size(), brute.crossings().size());
  }
}

}  // namespace
}  // namespace palpate
