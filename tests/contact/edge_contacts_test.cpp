// Oracles: edges against triangles in rational arithmetic, one by one; whether two tets meet by separating
// axes in integers; depths by hand.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/same_detections.hpp"
#include "contact/scenes.hpp"
#include "geometry/box.hpp"
#include "geometry/vector.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"
#include "support/rational.hpp"

namespace palpate {
namespace {

using test::ContactScene;
DetectionSettings with_edges() {
  DetectionSettings settings;
  settings.edge_contacts = true;
  return settings;
}

using EdgeSet = std::set<std::pair<Index, Index>>;  // (edge, body)

EdgeSet set_of(const EdgeContacts& contacts) {
  EdgeSet set;
  for (std::size_t c = 0; c < contacts.size(); ++c) set.insert({contacts.edge[c], contacts.body[c]});
  return set;
}

bool is_in(const ContactScene& scene, Index point, const Body& body) {
  const auto& x = scene.positions;
  for (Index t = body.tets.begin; t < body.tets.end; ++t) {
    const Tet& tet = at(scene.bodies.tets(), t);
    if (test::rational_point_in_tet(at(x, point), at(x, tet[0]), at(x, tet[1]), at(x, tet[2]), at(x, tet[3])))
      return true;
  }
  return false;
}

/// All surface edges that meet a triangle of another body, and whose ends are in none of its tets.
EdgeSet rational_edges(const ContactScene& scene) {
  const Bodies& bodies = scene.bodies;
  const auto& x = scene.positions;
  std::set<Index> surface;
  for (const Triangle& t : bodies.triangles()) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(t[i], t[(i + 1) % 3]);
      for (const Index edge : bodies.point_edges()[low])
        if (bodies.other_end(edge, low) == high) surface.insert(edge);
    }
  }
  EdgeSet set;
  for (const Index e : surface) {
    const Edge& edge = at(bodies.edges(), e);
    const Index a = bodies.body_of(edge);
    for (Index b = 0; b < bodies.body_count(); ++b) {
      if (a == b || (at(scene.immovable, a) == 1 && at(scene.immovable, b) == 1)) continue;
      const Body& body = at(bodies.bodies(), b);
      bool meets = false;
      for (Index t = body.triangles.begin; t < body.triangles.end && !meets; ++t) {
        const Triangle& c = at(bodies.triangles(), t);
        if (!box_of(std::span<const Vec3>(x), c).overlaps(box_of(std::span<const Vec3>(x), edge))) continue;
        test::Rational parameter;
        meets = test::rational_crossing(at(x, edge[0]), at(x, edge[1]), at(x, c[0]), at(x, c[1]), at(x, c[2]),
                                        parameter);
      }
      if (meets && !is_in(scene, edge[0], body) && !is_in(scene, edge[1], body)) set.insert({e, b});
    }
  }
  return set;
}

class EdgeContactsOn : public ::testing::TestWithParam<int> {};

TEST_P(EdgeContactsOn, AreThoseOfRationalArithmetic) {
  std::size_t found = 0;
  for (std::uint64_t seed = 0; seed < 25; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const ContactScene scene = test::make_contact_scene(GetParam(), seed);
    const EdgeSet expected = rational_edges(scene);
    Detector detector(scene.bodies, with_edges(), scene.immovable, 2);
    detector.detect(scene.positions);
    const EdgeContacts& edges = detector.edge_contacts();
    ASSERT_EQ(set_of(edges), expected);
    for (std::size_t c = 0; c < edges.size(); ++c) {
      ASSERT_TRUE(std::isfinite(edges.depth[c]) && edges.depth[c] >= 0.0);
      ASSERT_NEAR(length(edges.direction[c]), 1.0, 1e-9);
      ASSERT_TRUE(edges.parameters[c][0] <= edges.parameters[c][1]);
    }
    found += expected.size();
  }
  constexpr std::array scattered{2, 3, 4, 6, 7, 9};
  const bool few = std::ranges::find(scattered, GetParam()) != scattered.end();
  EXPECT_TRUE(few || found > 10U);
}

INSTANTIATE_TEST_SUITE_P(Scenes, EdgeContactsOn, ::testing::Range(0, test::contact_scene_kinds));

using IntVec = std::array<std::int64_t, 3>;
using IntTet = std::array<IntVec, 4>;

IntVec minus(const IntVec& a, const IntVec& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
IntVec cross_of(const IntVec& a, const IntVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
std::int64_t dot_of(const IntVec& a, const IntVec& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Whether a plane across an axis has the closed tets on different sides and touches at most one.
bool separates(const IntVec& axis, const IntTet& a, const IntTet& b) {
  const auto range = [&](const IntTet& tet) {
    std::array<std::int64_t, 4> d{};
    std::ranges::transform(tet, d.begin(), [&](const IntVec& p) { return dot_of(axis, p); });
    return std::pair(std::ranges::min(d), std::ranges::max(d));
  };
  const auto [low_a, high_a] = range(a);
  const auto [low_b, high_b] = range(b);
  return high_a < low_b || high_b < low_a;
}

bool meet(const IntTet& a, const IntTet& b) {
  std::vector<IntVec> axes;
  const auto edges = [](const IntTet& t) {
    std::vector<IntVec> list;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j) list.push_back(minus(t[j], t[i]));
    return list;
  };
  const auto of_a = edges(a);
  const auto of_b = edges(b);
  for (const auto* tet : {&a, &b})
    for (std::size_t i = 0; i < 4; ++i)
      axes.push_back(cross_of(minus((*tet)[(i + 1) % 4], (*tet)[i]), minus((*tet)[(i + 2) % 4], (*tet)[i])));
  for (const IntVec& u : of_a)
    for (const IntVec& v : of_b) axes.push_back(cross_of(u, v));
  return std::ranges::none_of(axes, [&](const IntVec& axis) { return separates(axis, a, b); });
}

/// A tet of positive volume with corners on a small grid, so that all kinds of touching are frequent.
IntTet random_tet(test::Random& random, int most) {
  while (true) {
    IntTet tet;
    for (IntVec& p : tet)
      for (std::int64_t& coordinate : p) coordinate = random.integer(0, most);
    const IntVec n = cross_of(minus(tet[1], tet[0]), minus(tet[2], tet[0]));
    const std::int64_t volume = dot_of(n, minus(tet[3], tet[0]));
    if (volume < 0) std::swap(tet[2], tet[3]);
    if (volume != 0) return tet;
  }
}

/// A tet, or two that share a face and lie on different sides of it, so that the body may have a dent.
struct SmallBody {
  std::vector<IntVec> points;
  std::vector<Tet> tets;
  [[nodiscard]] IntTet corners(const Tet& tet) const {
    IntTet result;
    for (std::size_t i = 0; i < 4; ++i) result[i] = at(points, tet[i]);
    return result;
  }
};

SmallBody random_body(test::Random& random, int most, int tets) {
  const IntTet first = random_tet(random, most);
  SmallBody body{{first.begin(), first.end()}, {{0, 1, 2, 3}}};
  if (tets == 1) return body;
  const IntVec n = cross_of(minus(first[1], first[0]), minus(first[2], first[0]));
  for (int tries = 0; tries < 100; ++tries) {
    IntVec apex;
    for (std::int64_t& coordinate : apex) coordinate = random.integer(0, most);
    if (dot_of(n, minus(apex, first[0])) >= 0) continue;  // the first tet is on the other side
    body.points.push_back(apex);
    body.tets.push_back({0, 2, 1, 4});
    break;
  }
  return body;
}

bool meet(const SmallBody& a, const SmallBody& b) {
  return std::ranges::any_of(a.tets, [&](const Tet& one) {
    return std::ranges::any_of(b.tets,
                               [&](const Tet& other) { return meet(a.corners(one), b.corners(other)); });
  });
}

/// A thousand pairs of bodies in one model, each pair far from the others.
std::size_t check_pairs(std::uint64_t seed, int most, int tets, std::size_t& met) {
  constexpr int pairs = 1000;
  test::Random random(seed);
  Bodies bodies;
  std::vector<bool> expected;
  for (int i = 0; i < pairs; ++i) {
    const SmallBody a = random_body(random, most, tets);
    const SmallBody b = random_body(random, most, tets);
    expected.push_back(meet(a, b));
    for (const SmallBody* body : {&a, &b}) {
      TetMesh mesh{.points = {}, .tets = body->tets};
      for (const IntVec& p : body->points) {
        mesh.points.push_back({double(p[0]) + 64.0 * (i % 10), double(p[1]) + 64.0 * (i / 10 % 10),
                               double(p[2]) + 64.0 * (i / 100)});
      }
      bodies.add("b", std::move(mesh));
    }
  }
  Detector detector(bodies, with_edges(), {}, 1);
  detector.detect(bodies.points_rest());
  std::vector<bool> found(pairs, false);
  for (const Index body : detector.contacts().body) found[static_cast<std::size_t>(body / 2)] = true;
  for (const Index body : detector.edge_contacts().body) found[static_cast<std::size_t>(body / 2)] = true;
  met += static_cast<std::size_t>(std::ranges::count(expected, true));
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) wrong += expected[i] != found[i] ? 1 : 0;
  return wrong;
}

void expect_a_contact_wherever_bodies_meet(std::uint64_t rounds) {
  for (const int tets : {1, 2}) {
    for (const int most : {2, 3, 5, 20}) {
      std::size_t met = 0;
      for (std::uint64_t seed = 0; seed < rounds; ++seed)
        ASSERT_EQ(check_pairs(1000 * seed + static_cast<std::uint64_t>(most), most, tets, met), 0U)
            << tets << " tets, grid of " << most << ", seed " << seed;
      EXPECT_GT(met, 100U * rounds);
      EXPECT_LT(met, 1000U * rounds);
    }
  }
}

TEST(EdgeContacts, WhereverTwoSmallBodiesMeetThereIsAContact) {
  expect_a_contact_wherever_bodies_meet(5);
}

TEST(EdgeContacts, DISABLED_WhereverTwoMillionPairsOfSmallBodiesMeetThereIsAContact) {
  expect_a_contact_wherever_bodies_meet(250);
}

/// A bar of one cell, of 0.2 x 0.02 x 0.02 along an axis.
TetMesh bar(int axis, const Vec3& centre) {
  Vec3 half{0.01, 0.01, 0.01};
  (axis == 0 ? half.x : half.y) = 0.1;
  return test::box_mesh({1, 1, 1}, centre - half, centre + half);
}

TEST(EdgeContacts, OfCrossedBarsLeadStraightUp) {
  Bodies bodies;
  bodies.add("lower", bar(0, {0.0, 0.0, 0.0}));
  bodies.add("upper", bar(1, {0.003, 0.0, 0.0198}));  // 0.2 mm deep
  Detector detector(bodies, with_edges(), {}, 1);
  detector.detect(bodies.points_rest());
  EXPECT_EQ(detector.contacts().size(), 0U);
  const EdgeContacts& edges = detector.edge_contacts();
  ASSERT_GE(edges.size(), 4U) << "two long edges of each bar";
  for (std::size_t c = 0; c < edges.size(); ++c) {
    const double up = edges.body[c] == 0 ? 1.0 : -1.0;
    EXPECT_NEAR(edges.depth[c], 0.0002, 1e-9) << c;
    EXPECT_NEAR(edges.direction[c].z, up, 1e-9) << c;
    EXPECT_NEAR(edges.parameters[c][1] - edges.parameters[c][0], 0.1, 0.05)
        << "20 of 200 mm, more on a diagonal";
  }
}

/// Prisms: bars that stand on an edge.
TEST(EdgeContacts, OfARidgeOnARidgeLeadAcrossBoth) {
  const auto on_edge = [](int axis, double z) {
    TetMesh mesh = bar(axis, {});
    for (Vec3& p : mesh.points) {
      p = test::rotated(p, axis == 0 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}, 0.78539816339744831);
      p.z += z;
    }
    return mesh;
  };
  Bodies bodies;
  bodies.add("lower", on_edge(0, 0.0));
  const double apart = 2.0 * 0.01 * std::sqrt(2.0);
  bodies.add("upper", on_edge(1, apart - 0.001));
  Detector detector(bodies, with_edges(), {}, 1);
  detector.detect(bodies.points_rest());
  EXPECT_EQ(detector.contacts().size(), 0U);
  const EdgeContacts& edges = detector.edge_contacts();
  ASSERT_EQ(edges.size(), 2U) << "each ridge goes through the other bar";
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_NEAR(edges.depth[c], 0.001, 1e-9);
    EXPECT_NEAR(std::abs(edges.direction[c].z), 1.0, 1e-9);
    // 45 degrees: as far inside as twice the depth.
    EXPECT_NEAR((edges.parameters[c][1] - edges.parameters[c][0]) * 0.2, 0.002, 1e-9);
  }
}

TEST(EdgeContacts, OfANeedleThroughASheetLeadBack) {
  Bodies bodies;
  bodies.add("sheet", test::box_mesh({4, 4, 1}, {-0.1, -0.1, 0.0}, {0.1, 0.1, 0.001}));
  // From above, with its tip 1 mm below the sheet; the edges from the tip are 10 mm long.
  TetMesh needle{
      .points = {{0.003, 0.001, -0.001}, {0.002, 0.001, 0.009}, {0.004, 0.0, 0.009}, {0.003, 0.002, 0.009}},
      .tets = {{0, 1, 2, 3}}};
  bodies.add("needle", needle);
  Detector detector(bodies, with_edges(), {}, 1);
  detector.detect(bodies.points_rest());
  const EdgeContacts& edges = detector.edge_contacts();
  ASSERT_EQ(edges.size(), 3U);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(edges.body[c], 0);
    EXPECT_NEAR(edges.depth[c], 0.002, 0.0001) << "the sheet, and what is below it";
    EXPECT_GT(edges.direction[c].z, 0.97);
  }
}

TEST(EdgeContacts, OfConvexBodiesLeaveWhenMovedByTheirDepth) {
  std::size_t moved = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    test::Random random(seed);
    Bodies bodies;
    for (int b = 0; b < 2; ++b) {  // convex: what is out of the way that it came by is out
      TetMesh box = test::box_mesh({1, 2, 1}, {-0.05, -0.1, -0.03}, {0.05, 0.1, 0.03});
      const Vec3 axis = random.point(-1, 1);
      const Vec3 shift = b * random.point(-0.12, 0.12);
      for (Vec3& p : box.points) p = test::rotated(p, axis, 1.0) + shift;
      bodies.add("b", std::move(box));
    }
    Detector detector(bodies, with_edges(), {}, 1);
    detector.detect(bodies.points_rest());
    const EdgeContacts edges = detector.edge_contacts();
    for (std::size_t c = 0; c < edges.size(); ++c) {
      std::vector<Vec3> positions(bodies.points_rest().begin(), bodies.points_rest().end());
      const Edge& edge = at(bodies.edges(), edges.edge[c]);
      for (const Index p : edge) at(positions, p) += (edges.depth[c] + 1e-6) * edges.direction[c];
      detector.detect(positions);
      EXPECT_FALSE(set_of(detector.edge_contacts()).contains({edges.edge[c], edges.body[c]}))
          << "seed " << seed << " contact " << c;
      ++moved;
    }
  }
  EXPECT_GT(moved, 50U);
}

/// A detector that has lists from frames before finds what one does that sees each frame first: bodies that
/// rest, creep, jump, fly past each other, turn, and move together with what is near them.
TEST(EdgeContacts, OfAMotionAreThoseOfEachFrameAlone) {
  test::Random random(11);
  Bodies bodies;
  std::vector<Vec3> velocities;
  for (int b = 0; b < 10; ++b) {
    const Vec3 size = random.point(0.02, 0.1);
    bodies.add("b", test::box_mesh({2, 3, 2}, -1.0 * size, size));
    velocities.push_back(b % 3 == 0 ? Vec3{} : std::pow(10.0, -1.0 - 0.5 * b) * random.point(-1, 1));
  }
  std::vector<Vec3> centers(10);
  std::vector<double> angles(10, 0.0);
  for (Vec3& center : centers) center = random.point(-0.1, 0.1);
  Detector detector(bodies, with_edges(), {}, 2);
  DetectionSettings settings = with_edges();
  settings.coherence = false;
  Detector without_lists(bodies, settings, {}, 2);
  std::size_t found = 0;
  for (int frame = 0; frame < 300; ++frame) {
    const Vec3 together = frame % 100 < 30 ? Vec3{0.01, 0.02, -0.5} : Vec3{};
    for (std::size_t b = 0; b < 10; ++b) {
      centers[b] += together + (frame % 50 < 10 ? Vec3{} : velocities[b]);
      if (frame == 150 && b < 3) centers[b] += random.point(-0.05, 0.05);
      if (frame % 4 != 0) angles[b] += length(velocities[b]);
      if (length(centers[b] - centers[0]) > 0.25) velocities[b] = -1.0 * velocities[b];
    }
    std::vector<Vec3> positions(bodies.points_rest().begin(), bodies.points_rest().end());
    for (std::size_t p = 0; p < positions.size(); ++p) {
      const auto b = static_cast<std::size_t>(bodies.body_of_point()[p]);
      positions[p] = test::rotated(positions[p], {0.3, 0.5, 0.8}, angles[b]) + centers[b];
    }
    detector.detect(positions);
    Detector first(bodies, with_edges(), {}, 1);
    first.detect(positions);
    ASSERT_EQ(set_of(detector.edge_contacts()), set_of(first.edge_contacts())) << "frame " << frame;
    ASSERT_EQ(detector.edge_contacts().depth, first.edge_contacts().depth);
    without_lists.detect(positions);
    ASSERT_EQ(set_of(without_lists.edge_contacts()), set_of(first.edge_contacts())) << "frame " << frame;
    found += detector.edge_contacts().size();
  }
  EXPECT_GT(found, 3000U);
}

TEST(EdgeContacts, AreTheSameForEveryThreadCountAndStructure) {
  for (const std::uint64_t seed : {3U, 4U}) {
    test::Random random(seed);
    Bodies bodies;
    for (int b = 0; b < 12; ++b) bodies.add("b", test::ball_mesh(4, random.point(-0.15, 0.15), 0.1));
    DetectionSettings settings = with_edges();
    Detector one(bodies, settings, {}, 1);
    one.detect(bodies.points_rest());
    EXPECT_GT(one.edge_contacts().size(), 10U);
    for (const Structure structure : {Structure::compact, Structure::hash, Structure::brute}) {
      settings.structure = structure;
      Detector other(bodies, settings, {}, 3);
      other.detect(bodies.points_rest());
      test::expect_same(one, other);
    }
    settings.edge_contacts = false;
    Detector without(bodies, settings, {}, 1);
    without.detect(bodies.points_rest());
    EXPECT_EQ(without.edge_contacts().size(), 0U);
    EXPECT_EQ(without.contacts().point, one.contacts().point);
  }
}

}  // namespace
}  // namespace palpate
