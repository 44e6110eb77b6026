// Oracles: volumes and topology of balls, rings and boxes; the bounds that Labelle and Shewchuk prove.
#include "anatomy/stuffing.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include <palpate/error.hpp>

#include "anatomy/fit.hpp"
#include "anatomy/largest_part.hpp"
#include "anatomy/plate.hpp"
#include "anatomy/shapes.hpp"
#include "anatomy/surface.hpp"
#include "support/random.hpp"

namespace palpate::anatomy {
namespace {

constexpr double pi = std::numbers::pi;

StuffingOptions around(double reach, double cell) {
  return {{-reach, -reach, -reach}, {reach, reach, reach}, cell};
}

MeshStatistics statistics_of(const Bodies& bodies) {
  return mesh_statistics(bodies, bodies.points_rest());
}

double ring_distance(const Vec3& p) {
  return std::hypot(std::hypot(p.x, p.y) - 2.0, p.z) - 0.7;
}

TEST(Stuffing, ABallIsClosedRoundAndAsLargeAsItShouldBe) {
  double last_error = 1.0;
  for (const double cell : {0.5, 0.25}) {
    const TetMesh mesh = stuff(ball({0.1, 0.2, -0.1}, 1.0), around(1.5, cell));
    const Bodies bodies = test::single_body(mesh);
    const test::SurfaceCheck surface = test::surface_check(bodies, 0);
    EXPECT_TRUE(surface.closed);
    EXPECT_EQ(surface.odd_edges, 0);
    EXPECT_EQ(surface.euler, 2) << "a sphere";
    const double error = 1.0 - statistics_of(bodies).volume / (4.0 / 3.0 * pi);
    EXPECT_GT(error, 0.0) << "chords lie inside";
    EXPECT_LT(error, 0.35 * last_error) << "second order in the cell";
    last_error = error;
    for (const Triangle& t : bodies.triangles()) {
      for (const Index p : t)
        EXPECT_NEAR(length(at(bodies.points_rest(), p) - Vec3{0.1, 0.2, -0.1}), 1.0, 1e-9);
    }
  }
  EXPECT_LT(last_error, 0.02);
}

TEST(Stuffing, ARingHasItsHole) {
  const Bodies bodies = test::single_body(stuff(ring_distance, around(3.0, 0.4)));
  const test::SurfaceCheck surface = test::surface_check(bodies, 0);
  EXPECT_TRUE(surface.closed);
  EXPECT_EQ(surface.euler, 0) << "a torus";
  EXPECT_NEAR(statistics_of(bodies).volume, 2.0 * pi * pi * 2.0 * 0.7 * 0.7,
              0.05 * 2.0 * pi * pi * 2.0 * 0.49);
}

TEST(Stuffing, AnglesKeepTheBoundsWhereverTheSurfaceLies) {
  test::Random random(7);
  for (int i = 0; i < 40; ++i) {
    const auto coordinate = [&] { return random.uniform(-0.5, 0.5); };
    const Vec3 center{coordinate(), coordinate(), coordinate()};
    const Vec3 normal{coordinate(), coordinate(), 0.3 + coordinate()};
    const Distance shape = without(ball(center, random.uniform(1.0, 2.0)), half_space(center, normal), -0.3);
    const Bodies bodies = test::single_body(stuff(shape, around(3.0, random.uniform(0.4, 0.7))));
    const Spread angles = statistics_of(bodies).dihedral_angle;
    EXPECT_GT(angles.min, 10.7) << i;
    EXPECT_LT(angles.max, 164.8) << i;
    EXPECT_TRUE(test::surface_check(bodies, 0).closed) << i;
    EXPECT_EQ(test::surface_check(bodies, 0).odd_edges, 0) << i;
  }
}

TEST(Stuffing, OnlyTheLargestPartStays) {
  const Distance two = united({ball({-1.5, 0.0, 0.0}, 1.2), ball({1.5, 0.0, 0.0}, 0.8)});
  const Bodies bodies = test::single_body(stuff(two, around(3.0, 0.4)));
  EXPECT_LT(statistics_of(bodies).upper.x, 0.0);
  EXPECT_TRUE(largest_part({}).tets.empty());
}

TEST(Stuffing, PartsThatMeetInAnEdgeAreTakenApart) {
  // Two tets that share the edge 0-1 and no face, and a third beside the first.
  TetMesh mesh{{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}, {0, 1, 0}},
               {{0, 1, 2, 3}, {0, 1, 4, 5}, {0, 1, 3, 6}}};
  EXPECT_EQ(test::surface_check(test::single_body(mesh), 0).odd_edges, 1);
  mesh = largest_part(without_pinched_edges(mesh));
  EXPECT_EQ(mesh.tets.size(), 2U);
  EXPECT_EQ(test::surface_check(test::single_body(mesh), 0).odd_edges, 0);
}

TEST(Stuffing, RefusesWhatItCannotMesh) {
  EXPECT_THROW(stuff(ball({}, 1.0), around(2.0, 0.0)), Error);
  EXPECT_THROW(stuff(ball({}, 1.0), around(2.0, 1e-4)), Error);
  EXPECT_THROW(stuff(ball({}, 1.0), {{1, 1, 1}, {-1, 1, 1}, 0.5}), Error);
  EXPECT_THROW(stuff(ball({9.0, 0.0, 0.0}, 1.0), around(2.0, 0.5)), Error) << "nothing there";
}

TEST(Fit, BringsTheSurfaceToTheShapeAndKeepsTheAngle) {
  // A plate of 0.6 cells: stuffing alone tears it; stuffing a wider shape and fitting it does not.
  const Distance plate = box({-2.0, -2.0, -0.15}, {2.0, 2.0, 0.15});
  const Bodies bodies = test::single_body(stuff_fitted(plate, grown(plate, 0.25), around(3.0, 0.5)));
  EXPECT_GE(statistics_of(bodies).dihedral_angle.min, 10.0 - 1e-9);
  EXPECT_NEAR(statistics_of(bodies).volume, 16.0 * 0.3, 0.12 * 16.0 * 0.3);
  const test::SurfaceCheck surface = test::surface_check(bodies, 0);
  EXPECT_TRUE(surface.closed);
  EXPECT_EQ(surface.euler, 2) << "no holes";
  double sum = 0.0;
  for (const Triangle& t : bodies.triangles()) sum += std::abs(plate(at(bodies.points_rest(), t[0])));
  EXPECT_LT(sum / static_cast<double>(bodies.triangles().size()), 0.02) << "mean distance from the shape";
}

TEST(Plate, HasItsHolesAndFollowsTheSurface) {
  const Bodies bodies =
      test::single_body(make_plate({.cells = {7, 5},
                                    .cell = 2.0,
                                    .thickness = 0.5,
                                    .start = {1.0, 2.0, 0.0},
                                    .bottom = [](double x, double y) { return 0.1 * x - 0.2 * y; }}));
  constexpr int holes = 6;
  EXPECT_EQ(bodies.tets().size(), 5U * (35U - holes));
  EXPECT_EQ(test::surface_check(bodies, 0).euler, 2 - 2 * holes);
  EXPECT_NEAR(statistics_of(bodies).volume, (35 - holes) * 4.0 * 0.5, 1e-9);
  for (const Vec3& p : bodies.points_rest()) {
    const double height = p.z - (0.1 * p.x - 0.2 * p.y);
    EXPECT_TRUE(std::abs(height) < 1e-12 || std::abs(height - 0.5) < 1e-12) << height;
  }
}

/// Distances along random rays: the shape's value at a point t beyond its surface is about t.
TEST(Shapes, AreDistancesNearTheirSurface) {
  const std::vector<std::pair<Distance, double>> exact{
      {ball({}, 2.0), 1e-6},
      {round_cone({0, -1, 0}, {0, 2, 0}, 1.5, 0.5), 1e-6},
      {box({-1, -2, -0.5}, {1, 1.5, 0.8}), 1e-6},
      {ellipsoid({}, {2.0, 1.5, 1.2}), 0.03},
      {tube({{{0, -1, 0}, {1, 0, 0}, 0.8, 0.5}, {{0, 2, 0}, {1, 0, 0}, 0.8, 0.5}}), 0.05}};
  test::Random random(3);
  for (const auto& [shape, tolerance] : exact) {
    for (int i = 0; i < 50; ++i) {
      // From outside, walk along the gradient to the surface: the path is as long as the value.
      Vec3 p{random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)};
      const double value = shape(p);
      if (std::abs(value) > 0.3 || value < 0.0) continue;
      const Vec3 start = p;
      for (int k = 0; k < 30; ++k) {
        constexpr double h = 1e-6;
        const auto slope = [&](const Vec3& e) { return (shape(p + h * e) - shape(p - h * e)) / (2.0 * h); };
        const Vec3 gradient{slope({1, 0, 0}), slope({0, 1, 0}), slope({0, 0, 1})};
        p -= (shape(p) / squared_length(gradient)) * gradient;
      }
      EXPECT_NEAR(length(p - start), value, tolerance);
    }
  }
}

}  // namespace
}  // namespace palpate::anatomy
