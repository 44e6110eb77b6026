// Oracle: rational arithmetic on the same doubles (tests/support/rational.hpp), which decides by solving
// linear systems.
#include "geometry/predicates.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>

#include "geometry/vector.hpp"
#include "support/random.hpp"
#include "support/rational.hpp"

namespace palpate {
namespace {

using test::Random;
using test::Rational;

int rational_sign(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const auto o = test::rational(a);
  return test::determinant(test::minus(test::rational(b), o), test::minus(test::rational(c), o),
                           test::minus(test::rational(d), o))
      .sign();
}

/// Corners that are hard for predicates: general, on a grid, nearly in a plane, far from the origin, tiny,
/// large, mixed.
Vec3 nasty_point(Random& random, int kind) {
  switch (kind) {
    case 0:
      return random.point(-1, 1);
    case 1:
      return random.grid_point(-2, 2, 1.0);
    case 2:
      return random.grid_point(-3, 3, 0.1);
    case 3: {  // the plane x + y + z = 1, off by a few units in the last place
      Vec3 p = random.point(-1, 1);
      p.z = 1.0 - p.x - p.y;
      if (random.chance(0.5)) p.z = std::nextafter(p.z, random.chance(0.5) ? 10.0 : -10.0);
      return p;
    }
    case 4:
      return random.point(1e6, 1e6 + 1e-3);
    case 5:
      return 1e-9 * random.point(-1, 1);
    case 6:
      return 1e-160 * random.grid_point(-3, 3, 1.0);  // products underflow
    case 7:                                           // at the limits of expansions of doubles
      return (random.chance(0.5) ? 1e89 : 1e92) * random.grid_point(-3, 3, 0.1);
    case 8:
      return (random.chance(0.5) ? 1e-88 : 1e-91) * random.grid_point(-3, 3, 0.1);
    default: {
      const double scale = std::pow(10.0, random.integer(-12, 12));
      return scale * random.point(-1, 1);
    }
  }
}

TEST(Orient3d, HasTheSignOfRationalArithmetic) {
  int zeros = 0;
  for (std::uint64_t seed = 0; seed < 20000; ++seed) {
    Random random(seed);
    const int kind = static_cast<int>(seed % 10);
    const Vec3 a = nasty_point(random, kind);
    const Vec3 b = nasty_point(random, kind);
    const Vec3 c = nasty_point(random, kind);
    const Vec3 d = nasty_point(random, kind);
    const int expected = rational_sign(a, b, c, d);
    zeros += expected == 0 ? 1 : 0;
    ASSERT_EQ(orient3d(a, b, c, d), expected) << "seed " << seed;
    ASSERT_EQ(orient3d(b, a, c, d), -expected) << "seed " << seed;
  }
  EXPECT_GT(zeros, 500) << "the degenerate kinds must really be degenerate";
}

TEST(Orient3d, UnitTetIsPositive) {
  EXPECT_EQ(orient3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}), 1);
}

TEST(PointInTet, AgreesWithRationalArithmetic) {
  int inside = 0;
  for (std::uint64_t seed = 0; seed < 20000; ++seed) {
    Random random(seed);
    const int kind = static_cast<int>(seed % 10);
    const Vec3 a = nasty_point(random, kind);
    const Vec3 b = nasty_point(random, kind);
    const Vec3 c = nasty_point(random, kind);
    const Vec3 d = nasty_point(random, kind);
    const Vec3 p = nasty_point(random, kind);
    const bool expected = test::rational_point_in_tet(p, a, b, c, d);
    inside += expected ? 1 : 0;
    ASSERT_EQ(point_in_tet(p, a, b, c, d), expected) << "seed " << seed;
    ASSERT_EQ(point_in_tet(p, b, a, c, d), expected) << "either orientation, seed " << seed;
  }
  EXPECT_GT(inside, 100);
}

TEST(PointInTet, BoundaryCountsAndNoVolumeContainsNothing) {
  const Vec3 a{0, 0, 0};
  const Vec3 b{1, 0, 0};
  const Vec3 c{0, 1, 0};
  const Vec3 d{0, 0, 1};
  EXPECT_TRUE(point_in_tet(a, a, b, c, d)) << "corner";
  EXPECT_TRUE(point_in_tet({0.5, 0, 0}, a, b, c, d)) << "edge";
  EXPECT_TRUE(point_in_tet({0.25, 0.25, 0}, a, b, c, d)) << "face";
  EXPECT_FALSE(point_in_tet({0.25, 0.25, -1e-300}, a, b, c, d)) << "the smallest step outside";
  EXPECT_FALSE(point_in_tet({0.25, 0.25, 0}, a, b, c, {0.3, 0.3, 0.0})) << "flat tet";
  EXPECT_FALSE(point_in_tet(a, a, a, a, a)) << "all corners in one place";
}

TEST(SegmentMeetsTriangle, AgreesWithRationalArithmetic) {
  int met = 0;
  for (std::uint64_t seed = 0; seed < 20000; ++seed) {
    Random random(seed);
    const int kind = static_cast<int>(seed % 10);
    const Vec3 a = nasty_point(random, kind);
    const Vec3 b = nasty_point(random, kind);
    const Vec3 t0 = nasty_point(random, kind);
    const Vec3 t1 = nasty_point(random, kind);
    const Vec3 t2 = nasty_point(random, kind);
    Rational t;
    const bool expected = test::rational_crossing(a, b, t0, t1, t2, t);
    ASSERT_EQ(segment_meets_triangle(a, b, t0, t1, t2), expected) << "seed " << seed;
    ASSERT_EQ(segment_meets_triangle(b, a, t2, t0, t1), expected) << "seed " << seed;
    if (expected) {
      ++met;
      const auto exact = static_cast<double>(t);
      ASSERT_NEAR(crossing_parameter(a, b, t0, t1, t2), exact, 3e-9 * std::min(exact, 1.0 - exact) + 1e-15)
          << "seed " << seed;
    }
  }
  EXPECT_GT(met, 500);
}

TEST(BarycentricWeights, GiveThePointBack) {
  for (std::uint64_t seed = 0; seed < 5000; ++seed) {
    Random random(seed);
    const Vec3 offset = random.chance(0.5) ? Vec3{} : random.point(-1e3, 1e3);
    std::array<Vec3, 4> t;
    for (Vec3& corner : t) corner = offset + random.point(-1, 1);
    if (std::abs(dot(t[1] - t[0], cross(t[2] - t[0], t[3] - t[0]))) < 1e-2) continue;
    std::array<double, 4> w{random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1),
                            random.uniform(0, 1)};
    if (random.chance(0.3)) w[static_cast<std::size_t>(random.integer(0, 3))] = 0.0;
    const double sum = w[0] + w[1] + w[2] + w[3];
    Vec3 p;
    for (std::size_t i = 0; i < 4; ++i) p += (w[i] / sum) * t[i];
    const auto found = barycentric_weights(p, t[0], t[1], t[2], t[3]);
    for (std::size_t i = 0; i < 4; ++i) ASSERT_NEAR(found[i], w[i] / sum, 1e-9) << "seed " << seed;
    ASSERT_NEAR(found[0] + found[1] + found[2] + found[3], 1.0, 1e-14);
  }
}

}  // namespace
}  // namespace palpate
