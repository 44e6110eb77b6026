#include "scene/generators.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <set>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"
#include "scene/error_check.hpp"
#include "scene/load.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

constexpr double ball_volume = 4.0 / 3.0 * std::numbers::pi;

/// Each edge of a closed surface has two triangles, and Euler's number of a sphere is 2.
void expect_sphere_topology(const Bodies& bodies) {
  std::multiset<Edge> edges;
  std::set<Index> points;
  for (const Triangle& t : bodies.triangles()) {
    for (std::size_t i = 0; i < 3; ++i) {
      edges.insert({std::min(t[i], t[(i + 1) % 3]), std::max(t[i], t[(i + 1) % 3])});
      points.insert(t[i]);
    }
  }
  std::size_t unique_edges = 0;
  for (auto edge = edges.begin(); edge != edges.end(); edge = edges.upper_bound(*edge)) {
    EXPECT_EQ(edges.count(*edge), 2U);
    ++unique_edges;
  }
  EXPECT_EQ(points.size() + bodies.triangles().size(), unique_edges + 2);
}

TEST(MakeBox, FillsTheBoxWithConformingTets) {
  const auto bodies = test::single_body(make_box({3, 4, 2}, {0.3, 0.2, 0.5}));
  const auto statistics = mesh_statistics(bodies, bodies.points_rest());
  EXPECT_EQ(statistics.points, 4 * 5 * 3);
  EXPECT_EQ(statistics.tets, 5 * 24);
  EXPECT_EQ(statistics.triangles, 4 * (12 + 6 + 8));  // unmatched inner faces would add to it
  EXPECT_NEAR(statistics.volume, 0.03, 1e-15);
  EXPECT_EQ(statistics.lower, (Vec3{-0.15, -0.1, -0.25}));
  EXPECT_EQ(statistics.upper, (Vec3{0.15, 0.1, 0.25}));
  EXPECT_EQ(bodies.notes()[0].reoriented_tets, 0);
  expect_sphere_topology(bodies);
}

TEST(MakeBox, CutsACellInFiveWithAThirdInTheMiddle) {
  const auto mesh = make_box({2, 1, 1}, {2, 1, 1});
  const auto bodies = test::single_body(mesh);
  int middle_ones = 0;
  for (const Tet& tet : bodies.tets()) {
    const Vec3 a = at(mesh.points, tet[0]);
    const double volume =
        dot(at(mesh.points, tet[1]) - a, cross(at(mesh.points, tet[2]) - a, at(mesh.points, tet[3]) - a)) /
        6.0;
    if (std::abs(volume - 1.0 / 3.0) < 1e-12) {
      ++middle_ones;
    } else {
      EXPECT_NEAR(volume, 1.0 / 6.0, 1e-12);
    }
  }
  EXPECT_EQ(middle_ones, 2);
}

TEST(MakeBox, RefusesWhatIsNoBox) {
  EXPECT_EQ(message_of([] { make_box({1, 0, 1}, {1, 1, 1}); }), "box: cells: found 0, expected 1 or more");
  EXPECT_EQ(message_of([] {
              make_box({1, 1, 1}, {1, -1, 1});
            }),
            "box: size: found -1, expected a number > 0, 1e100 at most");
  EXPECT_EQ(message_of([] {
              make_box({1, 1, 1}, {1, 1, std::numeric_limits<double>::infinity()});
            }),
            "box: size: found inf, expected a number > 0, 1e100 at most");
  EXPECT_NE(message_of([] { make_box({1000000, 1000000, 1000000}, {1, 1, 1}); }), "no error");
}

TEST(MakeBall, HasTheCountsOfTheSubdividedIcosahedron) {
  for (const int n : {1, 2, 3, 5}) {
    const auto bodies = test::single_body(make_ball(1.0, n));
    const auto statistics = mesh_statistics(bodies, bodies.points_rest());
    int points = 1;
    for (int k = 1; k <= n; ++k) points += 10 * k * k + 2;
    EXPECT_EQ(statistics.points, points);
    EXPECT_EQ(statistics.tets, 20 * n * n * n);
    EXPECT_EQ(statistics.triangles, 20 * n * n);
    EXPECT_EQ(bodies.notes()[0].reoriented_tets, 0);
    EXPECT_EQ(bodies.notes()[0].unreferenced_points, 0);
    expect_sphere_topology(bodies);
  }
}

TEST(MakeBall, HasItsSurfacePointsAndNoOthersOnTheSphere) {
  constexpr double radius = 0.07;
  const auto bodies = test::single_body(make_ball(radius, 5));
  std::set<Index> surface;
  for (const Triangle& t : bodies.triangles()) surface.insert(t.begin(), t.end());
  for (Index p = 0; p < static_cast<Index>(bodies.points_rest().size()); ++p) {
    const double distance = length(at(bodies.points_rest(), p));
    if (surface.contains(p)) {
      EXPECT_NEAR(distance, radius, 1e-15);
    } else {
      EXPECT_LT(distance, 0.81 * radius);
    }
  }
  EXPECT_EQ(bodies.points_rest()[0], Vec3{});
}

TEST(MakeBall, ConvergesToTheBallWithSecondOrder) {
  double error_before = 0.0;
  for (const int n : {2, 4, 8, 16}) {
    const auto bodies = test::single_body(make_ball(2.0, n));
    const double error = 1.0 - mesh_statistics(bodies, bodies.points_rest()).volume / (8.0 * ball_volume);
    EXPECT_GT(error, 0.0);  // an inscribed polyhedron
    if (n > 2) {
      EXPECT_NEAR(error_before / error, 4.0, 0.3);
    }
    error_before = error;
  }
}

TEST(MakeBall, KeepsItsShapeQualityUnderRefinement) {
  for (const int n : {2, 5, 10, 20}) {
    const auto bodies = test::single_body(make_ball(1.0, n));
    const auto statistics = mesh_statistics(bodies, bodies.points_rest());
    EXPECT_GT(statistics.dihedral_angle.min, 35.0);
    EXPECT_LT(statistics.dihedral_angle.max, 130.0);
    EXPECT_LT(statistics.edge_length.max, 2.2 * statistics.edge_length.min);
  }
}

TEST(MakeBall, RefusesWhatIsNoBall) {
  EXPECT_EQ(message_of([] { make_ball(0.0, 3); }),
            "ball: radius: found 0, expected a number > 0, 1e100 at most");
  EXPECT_EQ(message_of([] { make_ball(1.0, 0); }), "ball: resolution: found 0, expected 1 to 256");
  EXPECT_EQ(message_of([] { make_ball(1.0, 257); }), "ball: resolution: found 257, expected 1 to 256");
}

TEST(StackingScene, IsThePapers) {
  const auto loaded = load_model(make_stacking_scene(), {});
  const auto statistics = mesh_statistics(loaded.bodies, loaded.bodies.points_rest());
  EXPECT_EQ(statistics.points, 4840);
  EXPECT_EQ(statistics.edges, 19620);
  EXPECT_EQ(statistics.triangles, 9600);
  EXPECT_EQ(statistics.tets, 10000);
  EXPECT_EQ(std::count(loaded.obstacles.begin(), loaded.obstacles.end(), 1), 1);
  EXPECT_EQ(loaded.obstacles[0], 1);
  EXPECT_EQ(std::count(loaded.fixed_points.begin(), loaded.fixed_points.end(), 1), 242);
}

TEST(StackingScene, LeavesTheGapBetweenMembranes) {
  const auto loaded = load_model(make_stacking_scene(), {});
  for (Index b = 1; b < loaded.bodies.body_count(); ++b) {
    const auto below = mesh_statistics(loaded.bodies, loaded.bodies.points_rest(), b - 1);
    const auto above = mesh_statistics(loaded.bodies, loaded.bodies.points_rest(), b);
    EXPECT_NEAR(above.lower.z - below.upper.z, 0.001, 1e-12);
  }
}

TEST(StackingScene, ShiftsAndTurnsWithinBoundsAndDifferently) {
  std::set<double> angles;
  const Scene scene = make_stacking_scene();
  for (std::size_t b = 1; b < scene.bodies.size(); ++b) {
    const Transform& transform = scene.bodies[b].transform;
    EXPECT_LE(std::abs(transform.translate.x), 0.003);
    EXPECT_LE(std::abs(transform.translate.y), 0.003);
    EXPECT_LE(std::abs(transform.rotate.angle), 2.0);
    angles.insert(transform.rotate.angle);
  }
  EXPECT_EQ(angles.size(), 19U);
  EXPECT_LT(*angles.begin(), -1.0);
  EXPECT_GT(*angles.rbegin(), 1.0);
  EXPECT_NE(write_scene(make_stacking_scene({.seed = 2})), write_scene(scene));
}

TEST(StackingScene, TakesOptions) {
  const StackingOptions options{.count = 3,
                                .cells = {4, 2, 1},
                                .size = {0.4, 0.2, 0.1},
                                .gap = 0.0,
                                .max_shift = 0.0,
                                .max_rotation = 0.0};
  const auto loaded = load_model(make_stacking_scene(options), {});
  const auto statistics = mesh_statistics(loaded.bodies, loaded.bodies.points_rest());
  EXPECT_EQ(statistics.tets, 3 * 8 * 5);
  EXPECT_NEAR(statistics.upper.x, 0.2, 1e-15);
  EXPECT_NEAR(statistics.lower.z, 0.0, 1e-15);
  EXPECT_NEAR(statistics.upper.z, 0.3, 1e-12);
  EXPECT_EQ(message_of([] { make_stacking_scene({.count = 0}); }),
            "make_stacking_scene: count: found 0.000000, expected 1 to 100000");
  EXPECT_NE(message_of([] { make_stacking_scene({.gap = -1.0}); }), "no error");
  EXPECT_NE(message_of([] { make_stacking_scene({.cells = {0, 1, 1}}); }), "no error");
}

}  // namespace
}  // namespace palpate
