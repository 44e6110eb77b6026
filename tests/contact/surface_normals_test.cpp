// Normals of many points at once against those one by one, on every SIMD target: the same bits.
#include "contact/surface_normals.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

#include "geometry/vector.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"
#include "support/simd_targets.hpp"

namespace palpate {
namespace {

bool same_bits(const Vec3& a, const Vec3& b) {
  return std::bit_cast<std::array<std::uint64_t, 3>>(a) == std::bit_cast<std::array<std::uint64_t, 3>>(b);
}

TEST(SurfaceNormals, AreTheSameManyAtOnce) {
  test::Random random(5);
  Bodies bodies;
  bodies.add("box", test::box_mesh({3, 4, 2}, {-1, -1, -1}, {1, 1, 1}));
  bodies.add("ball", test::ball_mesh(6, {3, 0, 0}, 1.0));
  std::vector<Vec3> positions(bodies.points_rest().begin(), bodies.points_rest().end());
  for (Vec3& p : positions) p += random.point(-0.02, 0.02);
  // Triangles without area, and with points that are no numbers or overflow.
  for (const Index p : {3, 4, 5, 30}) at(positions, p) = at(positions, 3);
  at(positions, 17) = {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
  at(positions, 100) = {1e200, -1e200, 1e200};
  SurfaceNormals normals(bodies);
  normals.prepare(parallel::Threads(1), positions, {});
  std::vector<simd::PointOfTriangle> points;
  for (int i = 0; i < 3001; ++i) {
    const Index triangle = random.integer(0, static_cast<Index>(bodies.triangles().size()) - 1);
    const Triangle& t = at(bodies.triangles(), triangle);
    // Inside, on a side, at a corner and outside.
    std::array<double, 3> w{random.uniform(0.0, 1.0), random.uniform(0.0, 1.0), random.uniform(-0.1, 1.0)};
    if (random.chance(0.2)) w[0] = 0.0;
    if (random.chance(0.2)) w[1] = 0.0;
    Vec3 x;
    for (std::size_t k = 0; k < 3; ++k) x += (w[k] / (w[0] + w[1] + w[2])) * at(positions, t[k]);
    const double distance = random.chance(0.2) ? 0.0 : random.uniform(0.0, 0.05);
    points.push_back({triangle, x, random.chance(0.2) ? SurfaceNormals::far : distance});
  }
  test::for_each_simd_target([&](const char* target) {
    normals.prepare(parallel::Threads(1), positions, {});  // forgets what another target has computed
    for (const auto& point : points) normals.want(point.triangle);
    normals.prepare_wanted(parallel::Threads(1), positions);
    for (const std::size_t n : {std::size_t{0}, std::size_t{1}, std::size_t{63}, points.size()}) {
      std::vector<Vec3> found(n);
      std::vector<simd::Doubtful> scratch(n);
      normals.at_points(positions, std::span(points).first(n), found, scratch);
      for (std::size_t i = 0; i < n; ++i) {
        const auto& [triangle, x, distance] = points[i];
        const Vec3 one = normals.at_point_now(positions, triangle, x, distance);
        ASSERT_TRUE(same_bits(found[i], one)) << target << ", " << i << " of " << n;
        ASSERT_TRUE(same_bits(normals.at_point(positions, triangle, x, distance), one))
            << target << ", " << i;
      }
    }
  });
}

TEST(SurfaceNormals, OfCornersAreThoseOfTheTrianglesAround) {
  // Oracle: the sum over all triangles at the corner of a smooth body, in any order.
  Bodies bodies;
  bodies.add("ball", test::ball_mesh(6, {3, 0, 0}, 1.0));
  const std::span<const Vec3> x = bodies.points_rest();
  const SurfaceNormals normals(bodies);
  for (Index t = 0; t < static_cast<Index>(bodies.triangles().size()); ++t) {
    for (const Index corner : at(bodies.triangles(), t)) {
      Vec3 sum;
      for (const Triangle& other : bodies.triangles())
        if (std::find(other.begin(), other.end(), corner) != other.end())
          sum += cross(at(x, other[1]) - at(x, other[0]), at(x, other[2]) - at(x, other[0]));
      ASSERT_LT(length(normals.at_point_now(x, t, at(x, corner), 0.1) - normalized(sum)), 1e-13);
    }
  }
}

TEST(SurfaceNormals, OfHollowSurfacesAreThoseOfTheirTriangles) {
  // Half a tube of radii 1 and 1.5. Oracle: the gradient of the distance from its hollow side.
  TetMesh gutter = test::box_mesh({1, 8, 3}, {1.0, 0.0, 0.0}, {1.5, std::numbers::pi, 2.0});
  for (Vec3& p : gutter.points) p = {p.x * std::cos(p.y), p.x * std::sin(p.y), p.z};
  Bodies bodies;
  bodies.add("gutter", gutter);
  const std::span<const Vec3> x = bodies.points_rest();
  const SurfaceNormals normals(bodies);
  test::Random random(3);
  int inside = 0;
  double most_outside = 0.0;
  for (Index t = 0; t < static_cast<Index>(bodies.triangles().size()); ++t) {
    const std::array<Vec3, 3> corners = corners_of(x, at(bodies.triangles(), t));
    const Vec3 own = normalized(area_vector(corners));
    const double u = random.uniform(0.1, 0.8);
    const double v = random.uniform(0.1, 0.9 - u);
    const Vec3 place = u * corners[0] + v * corners[1] + (1.0 - u - v) * corners[2];
    const double away = length(normals.at_point_now(x, t, place, 1e-6) - own);
    const double outwards = dot(own, normalized({place.x, place.y, 0.0}));
    if (outwards < -0.9) {
      ++inside;
      ASSERT_LT(away, 1e-14);
    }
    if (outwards > 0.9) most_outside = std::max(most_outside, away);
    // On a side the triangle across has the same normal.
    for (std::size_t i = 0; i < 3; ++i) {
      const Index other = at(bodies.triangle_neighbors(), t)[i];
      const Vec3 between = 0.3 * corners[(i + 1) % 3] + 0.7 * corners[(i + 2) % 3];
      for (const double distance : {1e-3, SurfaceNormals::far}) {
        const Vec3 here = normals.at_point_now(x, t, between, distance);
        ASSERT_LT(length(here - normals.at_point_now(x, other, between, distance)), 1e-9);
      }
    }
  }
  EXPECT_EQ(inside, 2 * 8 * 3);
  EXPECT_GT(most_outside, 0.01) << "interpolated";
}

TEST(SurfaceNormals, TurnAtACreaseOverTheDistanceFromWhichTheyAreAskedFor) {
  Bodies bodies;
  bodies.add("box", test::box_mesh({2, 2, 2}, {0, 0, 0}, {2, 2, 2}));
  const std::span<const Vec3> x = bodies.points_rest();
  const SurfaceNormals normals(bodies);
  // At a place on the face with the outward normal `face`.
  const auto normal = [&](const Vec3& place, const Vec3& face, double distance) {
    for (Index t = 0; t < static_cast<Index>(bodies.triangles().size()); ++t) {
      const std::array<Vec3, 3> corners = corners_of(x, at(bodies.triangles(), t));
      const Vec3 area = area_vector(corners);
      const auto w = weights_in(corners, area, place);
      const Vec3 there = w[0] * corners[0] + w[1] * corners[1] + w[2] * corners[2];
      if (dot(normalized(area), face) > 0.9 && length(there - place) < 1e-12)
        return normals.at_point_now(x, t, place, distance);
    }
    return Vec3{};
  };
  const Vec3 up{0, 0, 1};
  const Vec3 aside{-1, 0, 0};
  for (const double distance : {1e-6, 1e-3, 0.02}) {
    const Vec3 at_edge = normal({0.0, 0.5, 2.0}, up, distance);
    EXPECT_LT(length(at_edge - normal({0.0, 0.5, 2.0}, aside, distance)), 1e-12) << "the same on both faces";
    EXPECT_LT(at_edge.z, 0.9);
    const Vec3 in_between = normal({0.5 * distance, 0.5, 2.0}, up, distance);
    EXPECT_GT(in_between.z, at_edge.z);
    EXPECT_LT(in_between.z, 1.0);
    EXPECT_EQ(normal({1.001 * distance, 0.5, 2.0}, up, distance), up);
  }
  EXPECT_LT(normal({0.049, 0.5, 2.0}, up, 10.0).z, 1.0) << "at most 5 % of the height of the triangle";
  EXPECT_EQ(normal({0.051, 0.5, 2.0}, up, 10.0), up);
  EXPECT_EQ(normal({1e-9, 0.5, 2.0}, up, 0.0), up);
}

}  // namespace
}  // namespace palpate
