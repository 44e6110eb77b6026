// Oracles: the same shapes as bodies of their own; all edges against all triangles in rational arithmetic.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/rational_fold.hpp"
#include "contact/same_detections.hpp"
#include "geometry/box.hpp"
#include "geometry/vector.hpp"
#include "support/crossed_arms.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"
#include "support/rational.hpp"

namespace palpate {
namespace {

DetectionSettings of_itself(const Bodies& bodies) {
  DetectionSettings settings;
  settings.edge_contacts = true;
  settings.self_collision.assign(bodies.bodies().size(), 1);
  return settings;
}

TEST(SelfEdgeContacts, OfTwoPartsOfABodyAreThoseOfTwoBodies) {
  std::size_t found = 0;
  for (std::uint64_t seed = 0; seed < 80; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    const TetMesh first = test::box_mesh({3, 2, 1}, {-0.1, -0.1, -0.03}, {0.1, 0.1, 0.03});
    TetMesh second = first;
    const Vec3 axis = random.point(-1, 1);
    const Vec3 shift = random.point(-0.15, 0.15);
    for (Vec3& p : second.points) p = test::rotated(p, axis, 1.5) + shift;
    Bodies two;
    two.add("first", first);
    two.add("second", second);
    Bodies one;
    one.add("both", test::joined(first, second));
    Detector expected(two, {}, {}, 1);
    expected.detect(two.points_rest());
    Detector detector(one, of_itself(one), {}, 1);
    detector.detect(one.points_rest());
    const EdgeContacts& a = expected.edge_contacts();
    const EdgeContacts& b = detector.edge_contacts();
    ASSERT_EQ(a.edge, b.edge);
    ASSERT_EQ(a.triangles, b.triangles);
    ASSERT_EQ(a.parameters, b.parameters);
    for (std::size_t c = 0; c < a.size(); ++c) {
      ASSERT_NEAR(a.depth[c], b.depth[c], 1e-12);
      ASSERT_LT(length(a.direction[c] - b.direction[c]), 1e-9);
    }
    found += a.size();
  }
  EXPECT_GT(found, 300U);
}

struct Meeting {
  test::Rational parameter;
  bool leaves;
  bool operator<(const Meeting& other) const {
    return std::tie(parameter, leaves) < std::tie(other.parameter, other.leaves);
  }
};

/// What rational arithmetic says of a surface edge of a body that may touch itself.
struct Expected {
  bool meets = false;                ///< a triangle that has no end of it, in a point or in its plane
  std::optional<double> parts = {};  ///< length of the longest part between an entry and an exit, relative
};

class Oracle {
 public:
  Oracle(const Bodies& bodies, std::span<const Vec3> x) : bodies_(bodies), x_(x) {}

  [[nodiscard]] Expected edge(Index e) const {
    const Edge& ends = at(bodies_.edges(), e);
    const Vec3& a = at(x_, ends[0]);
    const Vec3& b = at(x_, ends[1]);
    std::vector<Meeting> meetings;
    Expected expected;
    for (std::size_t t = 0; t < bodies_.triangles().size(); ++t) {
      const Triangle& c = bodies_.triangles()[t];
      if (has(c, ends[0]) || has(c, ends[1]) || !box_of(x_, c).overlaps(box_of(x_, ends))) continue;
      const Tet& tet = at(bodies_.tets(), bodies_.triangle_tets()[t]);
      if (test::rational_fold(bodies_, x_, ends[0], tet) || test::rational_fold(bodies_, x_, ends[1], tet))
        continue;
      const test::RationalVec o = test::rational(at(x_, c[0]));
      const auto normal_dot = [&](const test::RationalVec& v) {
        return test::determinant(test::minus(test::rational(at(x_, c[1])), o),
                                 test::minus(test::rational(at(x_, c[2])), o), v);
      };
      const test::Rational along = normal_dot(test::minus(test::rational(b), test::rational(a)));
      if (along == 0 && normal_dot(test::minus(test::rational(a), o)) == 0) expected.meets = true;
      test::Rational parameter;
      if (!test::rational_crossing(a, b, at(x_, c[0]), at(x_, c[1]), at(x_, c[2]), parameter)) continue;
      expected.meets = true;
      meetings.push_back({parameter, along > 0});
    }
    if (meetings.empty() || is_inside(ends[0]) || is_inside(ends[1]))
      return {expected.meets && !is_inside(ends[0]) && !is_inside(ends[1])};
    std::ranges::sort(meetings, std::less{});
    expected.parts = longest(meetings);
    return expected;
  }

  /// Whether a point of an edge is in a tet that has no end of it.
  [[nodiscard]] bool is_inside(const Edge& ends, const Vec3& p) const {
    return std::ranges::any_of(bodies_.tets(), [&](const Tet& tet) {
      return !has(tet, ends[0]) && !has(tet, ends[1]) && box_of(x_, tet).contains(p) && is_in(p, tet);
    });
  }

 private:
  static bool has(const auto& corners, Index p) { return std::ranges::find(corners, p) != corners.end(); }
  [[nodiscard]] bool is_in(const Vec3& p, const Tet& tet) const {
    return test::rational_point_in_tet(p, at(x_, tet[0]), at(x_, tet[1]), at(x_, tet[2]), at(x_, tet[3]));
  }
  [[nodiscard]] bool is_inside(Index p) const {
    return std::ranges::any_of(bodies_.tets(), [&](const Tet& tet) {
      return !has(tet, p) && box_of(x_, tet).contains(at(x_, p)) && is_in(at(x_, p), tet) &&
             !test::rational_fold(bodies_, x_, p, tet);
    });
  }
  static std::optional<double> longest(std::span<const Meeting> meetings) {
    std::optional<double> most;
    const test::Rational* entry = nullptr;
    const test::Rational* exit = nullptr;
    const auto end_part = [&] {
      if (exit == nullptr) return;
      most = std::max(most.value_or(0.0), static_cast<double>(test::Rational(*exit - *entry)));
      entry = exit = nullptr;
    };
    for (const Meeting& meeting : meetings) {
      if (!meeting.leaves) end_part();
      if (!meeting.leaves && entry == nullptr) entry = &meeting.parameter;
      if (meeting.leaves && entry != nullptr) exit = &meeting.parameter;
    }
    end_part();
    return most;
  }

  const Bodies& bodies_;
  std::span<const Vec3> x_;
};

/// Compares all edges with the oracle; edges that only touch may or may not be contacts. Returns the number
/// of edge contacts.
std::size_t expect_rational_edges(const Bodies& bodies, std::span<const Vec3> x, bool may_be_inverted) {
  constexpr double touch = 1e-9;
  Detector detector(bodies, of_itself(bodies), {}, 2);
  detector.detect(x);
  const EdgeContacts& found = detector.edge_contacts();
  const Oracle oracle(bodies, x);
  for (Index e = 0; e < std::ssize(bodies.edges()); ++e) {
    if (at(bodies.edge_triangles(), e)[0] < 0) continue;
    const Expected expected = oracle.edge(e);
    const bool is_found = std::ranges::binary_search(found.edge, e);
    if (expected.parts && *expected.parts > touch) {
      EXPECT_TRUE(is_found) << "edge " << e;
    }
    if (is_found) {
      EXPECT_TRUE(expected.meets) << "edge " << e;
    }
  }
  for (std::size_t c = 0; c < found.size(); ++c) {
    const auto [in, out] = found.parameters[c];
    const Edge& ends = at(bodies.edges(), found.edge[c]);
    EXPECT_TRUE(in <= out && std::isfinite(found.depth[c]) && found.depth[c] >= 0.0);
    EXPECT_NEAR(length(found.direction[c]), 1.0, 1e-9);
    for (const Index t : found.triangles[c]) {
      for (const Index corner : at(bodies.triangles(), t))
        EXPECT_TRUE(corner != ends[0] && corner != ends[1]);
    }
    if (may_be_inverted || out - in < touch) continue;
    const double middle = 0.5 * (in + out);
    EXPECT_TRUE(oracle.is_inside(ends, (1.0 - middle) * at(x, ends[0]) + middle * at(x, ends[1])))
        << "edge " << found.edge[c];
  }
  return found.size();
}

TEST(SelfEdgeContacts, OfABentBarAreThoseOfRationalArithmetic) {
  std::size_t found = 0;
  for (std::uint64_t seed = 0; seed < 80; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    Bodies bodies;
    bodies.add("bar", test::box_mesh({8, 1, 1}, {0, 0, 0}, {8, 1, 1}));
    std::vector<Vec3> x(bodies.points_rest().begin(), bodies.points_rest().end());
    // The far end comes back over the near one, turned; on a grid, so that it touches in all ways.
    const bool on_grid = seed % 2 == 0;
    const bool inverted = seed % 8 == 0;
    const Vec3 by = (on_grid ? random.grid_point(-2, 2, 0.25) : random.point(-1, 1)) + Vec3{2, 0, 0};
    for (Vec3& p : x) {
      if (p.x >= 6.0) p = Vec3{p.y, 7.0 - p.x, p.z} + by;
      if (inverted && random.chance(0.1)) p += random.grid_point(-3, 3, 0.25);
      if (!on_grid) p += random.point(-0.05, 0.05);
    }
    found += expect_rational_edges(bodies, x, true);
  }
  EXPECT_GT(found, 200U);
}

TEST(SelfEdgeContacts, OfCrossedArmsAreThoseOfRationalArithmetic) {
  std::size_t found = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    Bodies bodies;
    bodies.add("bar", test::crossed_arms(0.01));
    const Vec3 down{0.0, 0.0, -random.uniform(0.008, 0.02)};
    std::vector<Vec3> x(bodies.points_rest().begin(), bodies.points_rest().end());
    for (Vec3& p : x) {
      if (p.z > 0.015 && p.y < 0.1) p += down;
      p += random.point(-0.002, 0.002);
    }
    found += expect_rational_edges(bodies, x, false);
  }
  EXPECT_GT(found, 80U);
}

TEST(SelfEdgeContacts, OfCrossedArmsLeadStraightUp) {
  Bodies bodies;
  bodies.add("bar", test::crossed_arms(-0.0002));
  Detector off(bodies, {}, {}, 1);
  off.detect(bodies.points_rest());
  EXPECT_EQ(off.edge_contacts().size(), 0U);
  Detector detector(bodies, of_itself(bodies), {}, 1);
  detector.detect(bodies.points_rest());
  EXPECT_EQ(detector.contacts().size(), 0U);
  const EdgeContacts& edges = detector.edge_contacts();
  ASSERT_GE(edges.size(), 4U) << "two long edges of each arm";
  for (std::size_t c = 0; c < edges.size(); ++c) {
    const Edge& edge = at(bodies.edges(), edges.edge[c]);
    const Vec3 along = at(bodies.points_rest(), edge[1]) - at(bodies.points_rest(), edge[0]);
    const bool lower = std::abs(along.x) > std::abs(along.y);
    EXPECT_NEAR(edges.depth[c], 0.0002, 1e-9) << c;
    EXPECT_NEAR(edges.direction[c].z, lower ? -1.0 : 1.0, 1e-9) << c;
  }
}

/// Lists of earlier frames, threads and structures change nothing.
TEST(SelfEdgeContacts, OfAMotionAreThoseOfEachFrameAlone) {
  Bodies bodies;
  bodies.add("bar", test::crossed_arms(0.01));
  bodies.add("beside", test::box_mesh({3, 3, 1}, {-0.05, 0.02, -0.005}, {0.05, 0.1, 0.005}));
  const DetectionSettings settings = of_itself(bodies);
  Detector detector(bodies, settings, {}, 3);
  std::size_t found = 0;
  for (int frame = 0; frame < 200; ++frame) {
    // The upper arm comes down, rests, shakes and leaves again, while all moves.
    const double time = frame < 80 ? frame : 80 + std::max(0, frame - 120);
    const Vec3 down{0.0, 0.0, -0.017 * std::sin(0.02 * time)};
    const Vec3 together = frame % 60 < 20 ? Vec3{0.3, 0.1 * frame, 0.0} : Vec3{};
    test::Random random(static_cast<std::uint64_t>(frame / 3));
    std::vector<Vec3> x(bodies.points_rest().begin(), bodies.points_rest().end());
    for (Vec3& p : x) {
      if (p.z > 0.015 && p.y < 0.1) p += down;
      if (frame > 140) p += random.point(-2e-4, 2e-4);
      p += together;
    }
    detector.detect(x);
    DetectionSettings alone = settings;
    alone.structure = frame % 2 == 0 ? Structure::compact : Structure::hash;
    Detector first(bodies, alone, {}, 1);
    first.detect(x);
    ASSERT_NO_FATAL_FAILURE(test::expect_same(detector, first)) << "frame " << frame;
    const auto own = [&](std::size_t c) {
      return bodies.body_of(at(bodies.edges(), first.edge_contacts().edge[c])) ==
             first.edge_contacts().body[c];
    };
    for (std::size_t c = 0; c < first.edge_contacts().size(); ++c) found += own(c) ? 1 : 0;
  }
  EXPECT_GT(found, 300U);
}

TEST(SelfEdgeContacts, AMeshThatIsNotFoldedHasNone) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    test::Random random(seed);
    Bodies bodies;
    bodies.add("ball", test::ball_mesh(4, random.point(-1, 1), 0.8));
    bodies.add("box", test::box_mesh({3, 4, 1}, {4, 0, 0}, {5.1, 0.7, 0.3}));
    bodies.add("bar", test::crossed_arms(0.001));
    const Vec3 shear = random.point(-0.5, 0.5);
    std::vector<Vec3> x(bodies.points_rest().begin(), bodies.points_rest().end());
    for (Vec3& p : x) {
      p = {p.x + shear.x * p.y, 1.3 * p.y + shear.y * p.z, p.z + shear.z * p.x};
      p += 0.0002 * random.point(-1, 1);
    }
    Detector detector(bodies, of_itself(bodies), {}, 1);
    detector.detect(x);
    for (std::size_t c = 0; c < detector.edge_contacts().size(); ++c) {
      const EdgeContacts& edges = detector.edge_contacts();
      EXPECT_NE(bodies.body_of(at(bodies.edges(), edges.edge[c])), edges.body[c]) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace palpate
