// Fibres between two ends of a body, in shapes with a known harmonic function.
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <string>

#include <palpate/error.hpp>
#include <palpate/fibres.hpp>

#include "fem/meshes.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem::test {
namespace {

constexpr double pi = 3.14159265358979323846;

/// Points of the mesh for which `where` holds.
std::vector<Index> points_where(const TetMesh& mesh, const std::function<bool(const Vec3&)>& where) {
  std::vector<Index> points;
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (where(mesh.points[i])) points.push_back(static_cast<Index>(i));
  return points;
}

/// Sine of the angle between two lines.
double sine(const Vec3& a, const Vec3& b) {
  return length(cross(a, b)) / (length(a) * length(b));
}

TEST(Fibres, OfAStraightBarRunAlongItsAxis) {
  const TetMesh bar = irregular_box_mesh({10, 4, 4}, {2.5, 0.5, 0.25}, 0.25);
  std::mt19937_64 random(3);
  const Matrix3 turn = random_rotation(random);
  TetMesh turned = bar;
  for (Vec3& p : turned.points) p = turn * p;
  const Vec3 axis = turn * Vec3{1.0, 0.0, 0.0};
  const auto from = points_where(bar, [](const Vec3& p) { return p.x == 0.0; });
  const auto to = points_where(bar, [](const Vec3& p) { return p.x == 2.5; });
  ASSERT_EQ(from.size(), 25U);
  ASSERT_EQ(to.size(), 25U);
  const std::vector<Vec3> fibres = fibres_between(single_body(turned), 0, from, to);
  ASSERT_EQ(fibres.size(), bar.tets.size());
  double worst = 0.0;
  for (const Vec3& fibre : fibres) worst = std::max(worst, length(fibre - axis));
  EXPECT_LT(worst, 1e-12);
}

/// Tets with all corners at one end have no gradient, and use that of their neighbours.
TEST(Fibres, RunOnThroughEndsThatAreThick) {
  const TetMesh bar = box_mesh({10, 2, 2}, {1.0, 0.2, 0.2});
  const auto from = points_where(bar, [](const Vec3& p) { return p.x < 0.35; });
  const auto to = points_where(bar, [](const Vec3& p) { return p.x > 0.95; });
  for (const Vec3& fibre : fibres_between(single_body(bar), 0, from, to))
    EXPECT_LT(length(fibre - Vec3{1.0, 0.0, 0.0}), 1e-12);
}

/// A quarter of a ring of radii 1 and 2 about the z axis.
TetMesh quarter_ring(int n) {
  TetMesh mesh = box_mesh({2 * n, n, n}, {1.0, 1.0, 1.0});
  for (Vec3& p : mesh.points) {
    const double angle = 0.5 * pi * p.x;
    const double radius = 1.0 + p.y;
    p = {radius * std::cos(angle), radius * std::sin(angle), p.z};
  }
  return mesh;
}

/// Root of the mean square of the angle to the circles about the axis.
double ring_error(int n) {
  const TetMesh box = box_mesh({2 * n, n, n}, {1.0, 1.0, 1.0});
  const TetMesh ring = quarter_ring(n);
  const auto from = points_where(box, [](const Vec3& p) { return p.x == 0.0; });
  const auto to = points_where(box, [](const Vec3& p) { return p.x == 1.0; });
  const Bodies bodies = single_body(ring);
  const std::vector<Vec3> fibres = fibres_between(bodies, 0, from, to);
  double sum = 0.0;
  for (std::size_t t = 0; t < fibres.size(); ++t) {
    Vec3 centre{};
    for (const Index corner : bodies.tets()[t]) centre += 0.25 * at(bodies.points_rest(), corner);
    const Vec3 around{-centre.y, centre.x, 0.0};
    EXPECT_GT(dot(fibres[t], around), 0.0);
    EXPECT_NEAR(length(fibres[t]), 1.0, 1e-14);
    sum += std::pow(sine(fibres[t], around), 2);
  }
  return std::sqrt(sum / static_cast<double>(fibres.size()));
}

/// The harmonic function is the angle about the axis; gradients of linear tets are of first order.
TEST(Fibres, OfAQuarterRingRunRoundIt) {
  const double coarse = ring_error(4);
  const double fine = ring_error(8);
  std::printf("quarter ring: %.2f, %.2f degrees\n", 180.0 / pi * coarse, 180.0 / pi * fine);
  EXPECT_LT(coarse, 0.1);
  EXPECT_GT(coarse / fine, 1.7);
}

std::string problem(const TetMesh& mesh, const std::vector<Index>& from, const std::vector<Index>& to) {
  try {
    static_cast<void>(fibres_between(single_body(mesh), 0, from, to));
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Fibres, RefuseEndsThatAreNone) {
  const TetMesh tet = unit_tet_mesh();
  EXPECT_EQ(problem(tet, {}, {1}), "fibres_between: from: found no point, expected one or more points");
  EXPECT_EQ(problem(tet, {0}, {4}), "fibres_between: to: found point 4, expected 0 to 3");
  EXPECT_EQ(
      problem(tet, {0, 2}, {1, 2}),
      "fibres_between: to: found point 2, which is in 'from' too, expected ends without a common point");
  EXPECT_EQ(problem(tet, {0, 0}, {1}), "");
  TetMesh two = tet;
  for (const Vec3& p : tet.points) two.points.push_back(p + Vec3{5.0, 0.0, 0.0});
  two.tets.push_back({4, 5, 6, 7});
  EXPECT_EQ(problem(two, {0}, {4}),
            "fibres_between: to: found no point of this end in the connected piece of the body with tet 0, "
            "expected "
            "points of both ends in each piece");
  EXPECT_EQ(problem(two, {0}, {1}),
            "fibres_between: from: found no point of this end in the connected piece of the body with tet 1, "
            "expected "
            "points of both ends in each piece");
  EXPECT_EQ(problem(two, {0, 4}, {1, 5}), "");
}

}  // namespace
}  // namespace palpate::fem::test
