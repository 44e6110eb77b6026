// Touches of two primitives within a step. Oracles: touches made by construction with exact numbers, roots of
// cubics of integer coordinates, and distances in 80-bit arithmetic (swept_oracle.hpp).
#include <cmath>
#include <gtest/gtest.h>

#include "contact/swept_oracle.hpp"
#include "contact/swept_pair.hpp"
#include "support/random.hpp"

namespace palpate {
namespace {

using test::Long;
using test::Random;

constexpr double touch_tolerance = 1e-6;

struct Kind {
  bool edges;
  std::size_t first;  ///< corners of the first primitive
  [[nodiscard]] std::optional<SweptTouch> find(const SweptPoints& points) const {
    return edges ? edge_meets_edge(points, touch_tolerance) : point_meets_triangle(points, touch_tolerance);
  }
  [[nodiscard]] Long distance(const SweptPoints& points, Long time) const {
    const auto x = test::places(points, time);
    return edges ? test::edge_edge_distance(x) : test::point_triangle_distance(x);
  }
  [[nodiscard]] test::Answer answer(const SweptPoints& points) const {
    return edges ? test::answer(points, true, test::least_parameter)
                 : test::answer(points, false, test::least_weight);
  }
};
constexpr Kind point_triangle{false, 1};
constexpr Kind edge_edge{true, 2};

/// What each reported touch must be: near at its time, and apart along its direction.
void check_touch(const Kind& kind, const SweptPoints& points, const SweptTouch& touch) {
  const double within = swept_tolerance(points, touch_tolerance);
  ASSERT_LE(kind.distance(points, touch.time), within * (1.0 + 1e-9));
  ASSERT_GE(touch.time, 0.0);
  ASSERT_LE(touch.time, 1.0);
  if (touch.direction == Vec3{}) {
    ASSERT_EQ(touch.time, 0.0);
    return;
  }
  ASSERT_NEAR(length(touch.direction), 1.0, 1e-14);
  ASSERT_GT(test::gap_along(test::places(points, touch.time), kind.first, touch.direction), 0.0);
}

/// Weights in eighths whose sum is one; often at a corner or side.
std::array<double, 3> eighths(Random& random) {
  const int a = random.chance(0.4) ? 8 * random.integer(0, 1) : random.integer(0, 8);
  const int b = random.chance(0.3) ? 0 : random.integer(0, 8 - a);
  return {a / 8.0, b / 8.0, (8 - a - b) / 8.0};
}

Vec3 moved(const Vec3& p, const Vec3& by, double time) {
  return p + time * by;
}

/// Motions at whose time `when` (in 16ths) the primitives touch, without a rounded bit. Degenerate ones are
/// frequent: no motion, motion in the plane, parallel edges, no area or length, thin by 2^-20.
struct Made {
  SweptPoints points;
  double when = 0.0;
};

Made made(const Kind& kind, Random& random) {
  Made result;
  result.when = random.integer(0, 16) / 16.0;
  const double thin = random.chance(0.2) ? 0x1p-20 : 1.0;
  const auto whole = [&] {
    Vec3 p = random.grid_point(-8, 8, 1.0);
    p.z *= thin;
    return p;
  };
  std::array<Vec3, 4> there;
  std::array<Vec3, 4> velocity;
  for (Vec3& p : there) p = whole();
  for (Vec3& v : velocity) v = random.chance(0.1) ? Vec3{} : whole();
  if (random.chance(0.2)) velocity.fill(velocity[1]);
  if (random.chance(0.1))
    for (std::size_t i = 0; i < 4; ++i) there[i].z = velocity[i].z = 0.0;  // all in a plane
  if (kind.edges) {
    if (random.chance(0.2)) there[3] = there[2] + (random.chance(0.5) ? 2.0 : -1.0) * (there[1] - there[0]);
    const double s = eighths(random)[0];
    const double r = eighths(random)[0];
    const Vec3 gap = (there[2] + r * (there[3] - there[2])) - (there[0] + s * (there[1] - there[0]));
    there[0] += gap;
    there[1] += gap;
  } else {
    if (random.chance(0.1)) there[3] = there[1] + 2.0 * (there[2] - there[1]);
    if (random.chance(0.05)) there[2] = there[3] = there[1];
    const auto w = eighths(random);
    there[0] = w[0] * there[1] + w[1] * there[2] + w[2] * there[3];
  }
  for (std::size_t i = 0; i < 4; ++i) {
    result.points.start[i] = moved(there[i], velocity[i], -result.when);
    result.points.end[i] = moved(there[i], velocity[i], 1.0 - result.when);
  }
  return result;
}

void find_every_made_touch(const Kind& kind) {
  Random random(kind.edges ? 11 : 12);
  for (int i = 0; i < 200000; ++i) {
    Made one = made(kind, random);
    // Elsewhere and of another size: exact still.
    const double size = std::ldexp(1.0, random.integer(-12, 4));
    const Vec3 place = random.chance(0.5) ? Vec3{} : size * random.grid_point(-4096, 4096, 1.0);
    for (std::size_t k = 0; k < 4; ++k) {
      one.points.start[k] = place + size * one.points.start[k];
      one.points.end[k] = place + size * one.points.end[k];
    }
    const auto touch = kind.find(one.points);
    ASSERT_TRUE(touch) << "missed, number " << i;
    ASSERT_LE(touch->time, one.when) << "later than it touches, number " << i;
    ASSERT_NO_FATAL_FAILURE(check_touch(kind, one.points, *touch)) << "number " << i;
  }
}

TEST(SweptPair, FindsEveryPointThatIsMadeToTouchATriangle) {
  find_every_made_touch(point_triangle);
}
TEST(SweptPair, FindsEveryEdgeThatIsMadeToTouchAnEdge) {
  find_every_made_touch(edge_edge);
}

void agree_with_roots(const Kind& kind) {
  Random random(kind.edges ? 21 : 22);
  int touching = 0;
  int missing = 0;
  for (int i = 0; i < 200000; ++i) {
    const int range = random.chance(0.5) ? 4 : 100;
    SweptPoints points;
    for (Vec3& p : points.start) p = random.grid_point(-range, range, 1.0);
    for (Vec3& p : points.end) p = random.grid_point(-range, range, 1.0);
    const test::Answer answer = kind.answer(points);
    const auto touch = kind.find(points);
    if (touch) {
      ASSERT_NO_FATAL_FAILURE(check_touch(kind, points, *touch)) << "number " << i;
    }
    if (answer.verdict == test::Verdict::touches) {
      ++touching;
      ASSERT_TRUE(touch) << "missed, number " << i;
      ASSERT_LE(touch->time, answer.time + 1e-15L);
    }
    missing += answer.verdict == test::Verdict::misses && !touch ? 1 : 0;
  }
  EXPECT_GT(touching, 3000);
  EXPECT_GT(missing, 100000);
}

TEST(SweptPair, PointsAgainstTrianglesAgreeWithTheRootsOfTheirCubics) {
  agree_with_roots(point_triangle);
}
TEST(SweptPair, EdgesAgainstEdgesAgreeWithTheRootsOfTheirCubics) {
  agree_with_roots(edge_edge);
}

TEST(SweptPair, TellsTheTimeThePlaceAndTheSide) {
  const SweptPoints falls{{Vec3{0.25, 0.25, 3}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                          {Vec3{0.25, 0.25, -1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  const auto above = point_meets_triangle(falls, touch_tolerance);
  ASSERT_TRUE(above);
  EXPECT_NEAR(above->time, 0.75, 1e-6);
  EXPECT_LE(above->time, 0.75);
  EXPECT_NEAR(above->weights[0], 0.5, 1e-6);
  EXPECT_NEAR(above->weights[1], 0.25, 1e-6);
  EXPECT_NEAR(length(above->direction - Vec3{0, 0, 1}), 0.0, 1e-6);
  const SweptPoints crosses{{Vec3{-1, 0, 2}, {3, 0, 2}, {0, -1, 0}, {0, 3, 0}},
                            {Vec3{-1, 0, -2}, {3, 0, -2}, {0, -1, 0}, {0, 3, 0}}};
  const auto over = edge_meets_edge(crosses, touch_tolerance);
  ASSERT_TRUE(over);
  EXPECT_NEAR(over->time, 0.5, 1e-6);
  EXPECT_NEAR(over->weights[0], 0.25, 1e-6);
  EXPECT_NEAR(over->weights[1], 0.25, 1e-6);
  EXPECT_NEAR(length(over->direction - Vec3{0, 0, 1}), 0.0, 1e-6);
}

/// What slides past within a few tolerances is no touch, however long it takes.
TEST(SweptPair, WhatSlidesPastDoesNotTouch) {
  for (const double gap : {3.0 * touch_tolerance, 1e-3, 0.1}) {
    const SweptPoints slides{{Vec3{-1, 0.1, gap}, {0, 0, 0}, {9, 0, 0}, {0, 9, 0}},
                             {Vec3{8, 0.1, gap}, {0, 0, 0}, {9, 0, 0}, {0, 9, 0}}};
    EXPECT_FALSE(point_meets_triangle(slides, touch_tolerance)) << gap;
    const SweptPoints along{{Vec3{-9, 0, gap}, {-8, 0, gap}, {0, 0, 0}, {1, 0, 0}},
                            {Vec3{9, 0, gap}, {10, 0, gap}, {0, 0, 0}, {1, 0, 0}}};
    EXPECT_FALSE(edge_meets_edge(along, touch_tolerance)) << gap;
  }
}

}  // namespace
}  // namespace palpate
