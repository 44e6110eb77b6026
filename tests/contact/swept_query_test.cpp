// What whole bodies touch within a step. Oracle: all pairs of primitives, one after the other.
#include "contact/swept_query.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <set>
#include <tuple>

#include "contact/local_thickness.hpp"
#include "contact/rim_falloff.hpp"
#include "contact/swept_pair.hpp"
#include "geometry/triangle.hpp"
#include "geometry/vector.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"

namespace palpate {
namespace {

using test::Random;

constexpr double tolerance = 1e-6;
using Key = std::tuple<SweptKind, Index, Index>;

struct Scene {
  Bodies bodies;
  std::vector<Vec3> start;
  std::vector<Vec3> end;
  std::vector<std::uint8_t> immovable;
  std::vector<std::uint8_t> self_collision;
  std::set<std::array<Index, 2>> ties;  ///< point, body
  std::vector<std::array<Index, 2>> tied_points;
  std::vector<std::array<Index, 2>> tied_bodies;

  void add(TetMesh mesh) { bodies.add("b", std::move(mesh)); }
  /// Each body goes its own way and turns; points tremble.
  void move(Random& random, double far) {
    start.assign(bodies.points_rest().begin(), bodies.points_rest().end());
    end = start;
    for (const Body& body : bodies.bodies()) {
      const Vec3 shift = random.point(-far, far);
      const Vec3 axis = random.point(-1, 1);
      const double angle = random.uniform(-0.5, 0.5);
      for (Index p = body.points.begin; p < body.points.end; ++p)
        at(end, p) = test::rotated(at(start, p), axis, angle) + shift + random.point(-0.01, 0.01);
    }
    immovable.assign(bodies.bodies().size(), 0);
    self_collision.assign(bodies.bodies().size(), 0);
  }
  /// Ties some points of each body to each other body.
  void tie(Random& random) {
    std::set<std::array<Index, 2>> pairs;
    for (std::size_t p = 0; p < start.size(); ++p) {
      const Index own = bodies.body_of_point()[p];
      for (Index other = 0; other < bodies.body_count(); ++other) {
        if (other == own || !random.chance(0.1)) continue;
        ties.insert({static_cast<Index>(p), other});
        pairs.insert({std::min(own, other), std::max(own, other)});
      }
    }
    tied_points.assign(ties.begin(), ties.end());
    tied_bodies.assign(pairs.begin(), pairs.end());
  }
  [[nodiscard]] PairFilter filter() const {
    return {.immovable = immovable,
            .self_collision = self_collision,
            .tied_points = tied_points,
            .tied_bodies = tied_bodies};
  }
};

Scene random_scene(std::uint64_t seed) {
  Random random(seed);
  Scene scene;
  const int bodies = random.integer(2, 5);
  for (int b = 0; b < bodies; ++b) {
    const Vec3 place = random.point(-1, 1);
    switch (random.integer(0, 3)) {
      case 0:
        scene.add(test::box_mesh({3, 2, 1}, place, place + Vec3{0.7, 0.5, 0.02}));
        break;
      case 1:
        scene.add(test::ball_mesh(2, place, random.uniform(0.1, 0.5)));
        break;
      case 2:
        scene.add(test::box_mesh({4, 1, 1}, place, place + Vec3{1.0, 0.01, 0.01}));
        break;
      default:
        scene.add(test::soup(1, [&] { return place + random.point(-0.2, 0.2); }));
        break;
    }
  }
  scene.move(random, 1.0);
  if (random.chance(0.3)) scene.immovable[0] = scene.immovable[1] = 1;
  if (random.chance(0.3)) scene.self_collision[0] = 1;
  if (random.chance(0.5)) scene.tie(random);
  return scene;
}

bool have_common_point(const auto& a, const auto& b) {
  return std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end();
}

SweptPoints points_of(const Scene& scene, const std::vector<Index>& corners) {
  SweptPoints points;
  for (std::size_t i = 0; i < 4; ++i) {
    points.start[i] = at(scene.start, corners[i]);
    points.end[i] = at(scene.end, corners[i]);
  }
  return points;
}

std::set<Key> all_pairs(const Scene& scene) {
  const Bodies& bodies = scene.bodies;
  std::set<Index> surface_points;
  std::set<Edge> sides;
  for (const Triangle& t : bodies.triangles()) {
    for (std::size_t c = 0; c < 3; ++c) {
      surface_points.insert(t[c]);
      sides.insert({std::min(t[c], t[(c + 1) % 3]), std::max(t[c], t[(c + 1) % 3])});
    }
  }
  const auto wanted = [&](Index a, Index b) {
    if (a == b) return at(scene.self_collision, a) != 0 && at(scene.immovable, a) == 0;
    return at(scene.immovable, a) == 0 || at(scene.immovable, b) == 0;
  };
  const auto are_tied = [&](const auto& a, const auto& b) {
    const auto any_is_tied = [&](const auto& points, const auto& others) {
      const Index body = at(bodies.body_of_point(), others[0]);
      return std::ranges::any_of(points, [&](Index p) { return scene.ties.contains({p, body}); });
    };
    return any_is_tied(a, b) || any_is_tied(b, a);
  };
  std::set<Key> found;
  for (const Index p : surface_points) {
    for (std::size_t t = 0; t < bodies.triangles().size(); ++t) {
      const Triangle& corners = bodies.triangles()[t];
      if (!wanted(at(bodies.body_of_point(), p), bodies.body_of(corners))) continue;
      if (have_common_point(std::array{p}, corners) || are_tied(std::array{p}, corners)) continue;
      if (point_meets_triangle(points_of(scene, {p, corners[0], corners[1], corners[2]}), tolerance))
        found.insert({SweptKind::point_triangle, p, static_cast<Index>(t)});
    }
  }
  const auto number = [&](const Edge& edge) {
    return static_cast<Index>(std::find(bodies.edges().begin(), bodies.edges().end(), edge) -
                              bodies.edges().begin());
  };
  for (const Edge& a : sides) {
    for (const Edge& b : sides) {
      const Index i = number(a);
      const Index j = number(b);
      if (i >= j || !wanted(bodies.body_of(a), bodies.body_of(b)) || have_common_point(a, b)) continue;
      if (are_tied(a, b)) continue;
      if (edge_meets_edge(points_of(scene, {a[0], a[1], b[0], b[1]}), tolerance))
        found.insert({SweptKind::edge_edge, i, j});
    }
  }
  return found;
}

TEST(SweptQuery, FindsWhatAllPairsFind) {
  std::size_t touches = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Scene scene = random_scene(seed);
    SweptQuery query(scene.bodies);
    std::set<Key> found;
    for (const SweptContact& c : query.find(parallel::Threads(1), scene.start, scene.end, scene.filter(),
                                            {.tolerance = tolerance, .least_motion = -1.0})) {
      EXPECT_TRUE(found.emplace(c.kind, c.first, c.second).second) << "twice";
    }
    EXPECT_EQ(found, all_pairs(scene)) << "seed " << seed;
    touches += found.size();
  }
  EXPECT_GT(touches, 500U);
}

TEST(SweptQuery, FindsWhatPathsFromOtherPositionsTouch) {
  std::size_t touches = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Scene scene = random_scene(seed);
    Random random(seed);
    const std::vector<Vec3> start = scene.start;
    for (Vec3& p : scene.start) p += random.point(-0.3, 0.3);
    SweptQuery query(scene.bodies);
    std::set<Key> found;
    for (const SweptContact& c : query.find(parallel::Threads(1), start, scene.start, scene.end,
                                            scene.filter(), {.tolerance = tolerance, .least_motion = -1.0}))
      found.emplace(c.kind, c.first, c.second);
    const std::set<Key> expected = all_pairs(scene);
    EXPECT_EQ(found, expected) << "seed " << seed;
    touches += found.size();
  }
  EXPECT_GT(touches, 200U);
}

/// A plate and many balls: several chunks of clusters and of their pairs.
Scene balls_over_plate() {
  Scene scene;
  scene.add(test::box_mesh({20, 20, 1}, {0, 0, 0}, {2, 2, 0.01}));
  for (int i = 0; i < 16; ++i)
    scene.add(test::ball_mesh(4, {0.25 + 0.5 * (i % 4), 0.25 + 0.5 * (i / 4), 0.4}, 0.24));
  Random random(5);
  scene.move(random, 0.0);
  for (const Body& body : scene.bodies.bodies().subspan(1))
    for (Index p = body.points.begin; p < body.points.end; ++p) at(scene.end, p).z -= 0.8;
  return scene;
}

TEST(SweptQuery, HasTheSameBitsForEveryThreadCount) {
  const Scene scene = balls_over_plate();
  std::vector<SweptContact> first;
  for (const int threads : {1, 2, 3, 7}) {
    SweptQuery query(scene.bodies);
    const auto found =
        query.find(parallel::Threads(threads), scene.start, scene.end, scene.filter(), {tolerance, 0.25});
    EXPECT_GT(query.counts().cluster_pairs, 100U);
    if (threads == 1) first.assign(found.begin(), found.end());
    EXPECT_GT(first.size(), 1000U);
    EXPECT_TRUE(std::ranges::equal(first, found)) << threads;
  }
}

TEST(SweptQuery, LooksOnlyAtWhatCouldPass) {
  Scene scene = balls_over_plate();
  SweptQuery query(scene.bodies);
  const auto find = [&] {
    return query
        .find(parallel::Threads(1), scene.start, scene.end, scene.filter(),
              {.tolerance = tolerance, .least_motion = 0.25})
        .size();
  };
  // All fall together: nothing moves against anything.
  for (std::size_t p = 0; p < scene.end.size(); ++p) scene.end[p] = scene.start[p] + Vec3{0, 0, -5};
  EXPECT_EQ(find(), 0U);
  EXPECT_EQ(query.counts().body_pairs, 0U);
  // A quarter of the plate's thickness of 10 mm, with a ball 1 mm above it.
  const Body& ball = scene.bodies.bodies()[1];
  for (const double shift : {0.0024, 0.0026}) {
    scene.end = scene.start;
    for (Index p = ball.points.begin; p < ball.points.end; ++p) {
      at(scene.start, p).z = at(scene.bodies.points_rest(), p).z - 0.149;
      at(scene.end, p) = at(scene.start, p) - Vec3{0, 0, shift};
    }
    const std::size_t found = find();
    EXPECT_EQ(found > 0, shift > 0.0025);
    EXPECT_EQ(query.counts().body_pairs, shift > 0.0025 ? 1U : 0U);
  }
  EXPECT_NEAR(query.counts().thinnest, 0.01, 1e-12);
}

TEST(SurfaceClusters, OwnsEachPointAndSideOnce) {
  Bodies bodies;
  bodies.add("sheet", test::box_mesh({5, 4, 1}, {0, 0, 0}, {0.1, 0.08, 0.002}));
  bodies.add("ball", test::ball_mesh(4, {1, 1, 1}, 0.1));
  const SurfaceClusters surface(bodies);
  const auto unique = [](const Rows& rows) {
    return std::set<Index>(rows.values.begin(), rows.values.end());
  };
  EXPECT_EQ(unique(surface.points).size(), surface.points.values.size());
  EXPECT_EQ(unique(surface.edges).size(), surface.edges.values.size());
  // Euler: V - E + F = 2 for each closed surface.
  EXPECT_EQ(surface.points.values.size() + bodies.triangles().size(), surface.edges.values.size() + 4);
}

TEST(LocalThickness, IsThatOfASheetAndAtMostAMeanEdge) {
  Bodies bodies;
  bodies.add("sheet", test::box_mesh({5, 4, 1}, {0, 0, 0}, {0.1, 0.08, 0.002}));
  bodies.add("box", test::box_mesh({4, 4, 4}, {1, 1, 1}, {1.4, 1.4, 1.4}));
  const LocalThickness thickness(bodies, SurfaceClusters(bodies).clusters);
  EXPECT_NEAR(thickness.of_body[0], 0.002, 1e-12);
  const double edge = 4.0 * rim_reach(bodies, 1);
  const Range triangles = bodies.bodies()[1].triangles;
  for (Index t = triangles.begin; t < triangles.end; ++t) {
    EXPECT_LE(at(thickness.of_triangle, t), edge);
    EXPECT_GE(at(thickness.of_triangle, t), 0.1);  // cells of 0.1, and the box is thicker
  }
}

TEST(LocalThickness, IsNotThatOfAFlatTetInAThickBody) {
  // The lowest cells of this box are a hundredth as high as the others.
  TetMesh mesh = test::box_mesh({4, 4, 4}, {0, 0, 0}, {0.4, 0.4, 0.4});
  for (Vec3& p : mesh.points)
    if (std::abs(p.z - 0.1) < 1e-9) p.z = 0.001;
  Bodies bodies;
  bodies.add("box", std::move(mesh));
  const LocalThickness thickness(bodies, SurfaceClusters(bodies).clusters);
  for (std::size_t t = 0; t < bodies.triangles().size(); ++t) {
    const std::array<Vec3, 3> x = corners_of(bodies.points_rest(), bodies.triangles()[t]);
    const bool is_below = x[0].z == 0.0 && x[1].z == 0.0 && x[2].z == 0.0;
    if (is_below) {
      EXPECT_GT(thickness.of_triangle[t], 0.1);
    }
  }
}

TEST(LocalThickness, OfAPointIsThatOfItsTriangles) {
  // A box of 20 cm, and beside it a sheet of 1 mm.
  const TetMesh box = test::box_mesh({2, 2, 2}, {0, 0, 0}, {0.2, 0.2, 0.2});
  const auto first = static_cast<Index>(box.points.size());
  Bodies bodies;
  bodies.add("box", test::joined(box, test::box_mesh({2, 2, 1}, {0.3, 0, 0}, {0.4, 0.1, 0.001})));
  const LocalThickness thickness(bodies, SurfaceClusters(bodies).clusters);
  for (Index p = 0; p < first; ++p) EXPECT_GT(at(thickness.of_point, p), 0.05) << p;
  for (Index p = first; p < std::ssize(bodies.points_rest()); ++p)
    EXPECT_NEAR(at(thickness.of_point, p), 0.001, 1e-9) << p;
}

TEST(LocalThickness, OfASingleTetIsItsHeight) {
  Bodies bodies;
  bodies.add("tet", TetMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0.25}}, {{0, 1, 2, 3}}});
  const LocalThickness thickness(bodies, SurfaceClusters(bodies).clusters);
  // Its legs are along the axes, so height = 6 volume / (2 area).
  const double slant = std::sqrt(1.0 / (1.0 + 1.0 + 16.0));
  EXPECT_NEAR(*std::ranges::min_element(thickness.of_triangle), slant, 1e-12);
  EXPECT_NEAR(*std::ranges::max_element(thickness.of_triangle), 4.0 * rim_reach(bodies, 0), 1e-12);
}

}  // namespace
}  // namespace palpate
