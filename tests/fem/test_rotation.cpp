#include <Eigen/SVD>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "fem/meshes.hpp"
#include "fem/rotation.hpp"

namespace palpate::fem::test {
namespace {

/// Oracle: U diag(1, 1, det(U V^T)) V^T by Eigen's two-sided Jacobi SVD, which does not square the condition
/// number.
Eigen::Matrix3d svd_rotation(const Eigen::Matrix3d& f) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1.0, 1.0, 1.0);
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) signs[2] = -1.0;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

/// diag(stretches) with random rotations on both sides.
Matrix3 stretched(std::mt19937_64& random, double a, double b, double c) {
  const Eigen::Matrix3d u = to_eigen(random_rotation(random));
  const Eigen::Matrix3d v = to_eigen(random_rotation(random));
  return from_eigen(u * Eigen::Vector3d(a, b, c).asDiagonal() * v.transpose());
}

void expect_rotation(const Matrix3& r) {
  const Eigen::Matrix3d m = to_eigen(r);
  EXPECT_TRUE(m.allFinite()) << m;
  EXPECT_LT((m.transpose() * m - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-14) << m;
  EXPECT_GT(m.determinant(), 0.0) << m;
}

TEST(NearestRotation, IsExactlyTheIdentityAtRest) {
  EXPECT_EQ(nearest_rotation(identity()), identity());
}

TEST(NearestRotation, MatchesSvdWhereItIsUnique) {
  std::mt19937_64 random(1);
  const double stretches[][3] = {{1, 1, 1},       {2, 1, 0.5},    {1, 0.9, 0.01},  {1, 0.5, 1e-6},
                                 {1, 0.5, 1e-14}, {1, 0.5, 0},    {1, 0.6, -0.3},  {1, 0.9, -0.1},
                                 {5, 1, -1e-9},   {100, 1, 0.2},  {1, 0.5, -0.45}, {0.3, 0.2, 0.1},
                                 {1, 0.22, 0.05}, {1, 0.21, 0.05}};
  for (const auto& s : stretches) {
    for (int trial = 0; trial < 200; ++trial) {
      const Matrix3 f = stretched(random, s[0], s[1], s[2]);
      const Matrix3 r = nearest_rotation(f);
      expect_rotation(r);
      const double condition = s[0] / (s[1] + s[2]);
      EXPECT_LT((to_eigen(r) - svd_rotation(to_eigen(f))).cwiseAbs().maxCoeff(), 4e-15 * (3.0 + condition))
          << s[0] << ' ' << s[1] << ' ' << s[2];
    }
  }
}

TEST(NearestRotation, DoesNotDependOnUnits) {
  std::mt19937_64 random(2);
  for (const double scale : {1e-300, 1e-160, 1e-9, 1e9, 1e150, 1e300}) {
    for (const double last : {0.4, -0.2}) {
      const Matrix3 f = stretched(random, 1.0, 0.7, last);
      Matrix3 scaled = f;
      for (double& value : scaled.values) value *= scale;
      const Matrix3 r = nearest_rotation(scaled);
      EXPECT_LT((to_eigen(r) - to_eigen(nearest_rotation(f))).cwiseAbs().maxCoeff(), 1e-14) << scale;
    }
  }
}

/// No rotation is nearer than the returned one, also if several are equally near.
TEST(NearestRotation, IsANearestRotationForDegenerateInput) {
  std::mt19937_64 random(3);
  const double stretches[][3] = {{1, 1, -1},          {1, 1, 0},        {1, 0, 0},       {0, 0, 0},
                                 {2, 1, -1},          {1, 1e-3, -1e-3}, {1, 1e-9, 1e-9}, {1, 1e-17, 0},
                                 {1e-320, 1e-320, 0}, {-1, -1, -1}};
  for (const auto& s : stretches) {
    for (int trial = 0; trial < 50; ++trial) {
      const Matrix3 f =
          trial == 0 ? Matrix3{{s[0], 0, 0, 0, s[1], 0, 0, 0, s[2]}} : stretched(random, s[0], s[1], s[2]);
      const Matrix3 r = nearest_rotation(f);
      expect_rotation(r);
      // max tr(R^T F) over rotations, with the absolute values sorted by size and the sign of det F on the
      // smallest.
      Eigen::JacobiSVD<Eigen::Matrix3d> svd(to_eigen(f));
      const double sign = s[0] * s[1] * s[2] < 0.0 ? -1.0 : 1.0;
      const Eigen::Vector3d sizes = svd.singularValues();
      const double best = sizes[0] + sizes[1] + sign * sizes[2];
      EXPECT_NEAR(inner(r, f), best, 1e-14 * (sizes[0] + sizes[1]) + 1e-321)
          << s[0] << ' ' << s[1] << ' ' << s[2];
    }
  }
  EXPECT_EQ(nearest_rotation(Matrix3{}), identity());
}

TEST(NearestRotation, GivesARotationForValuesThatAreNotFinite) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    Matrix3 f = identity();
    f(1, 2) = bad;
    EXPECT_EQ(nearest_rotation(f), identity());
  }
  Matrix3 huge;
  huge.values.fill(std::numeric_limits<double>::max());
  expect_rotation(nearest_rotation(huge));
  Matrix3 tiny;
  tiny.values.fill(std::numeric_limits<double>::denorm_min());
  expect_rotation(nearest_rotation(tiny));
}

/// While an element flattens and inverts, the rotation changes no faster than its conditioning allows: it
/// does not jump between the two algorithms or at det F = 0.
TEST(NearestRotation, IsContinuousThroughInversion) {
  std::mt19937_64 random(4);
  const Matrix3 u = random_rotation(random);
  const Matrix3 v = random_rotation(random);
  const auto f_at = [&](double s) {
    Matrix3 shear{{1.0, 0.2, 0.0, 0.0, 0.8, 0.1 * s, 0.05, 0.0, s}};
    return from_eigen(to_eigen(u) * to_eigen(shear) * to_eigen(v));
  };
  constexpr double step = 1e-4;
  Matrix3 previous = nearest_rotation(f_at(1.0));
  for (double s = 1.0 - step; s > -0.4; s -= step) {
    const Matrix3 r = nearest_rotation(f_at(s));
    EXPECT_LT((to_eigen(r) - to_eigen(previous)).norm(), 10.0 * step) << s;
    previous = r;
  }
}

}  // namespace
}  // namespace palpate::fem::test
