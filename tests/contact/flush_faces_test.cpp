// Oracle: boxes, whose flush faces are known.
#include "contact/flush_faces.hpp"

#include <gtest/gtest.h>

#include "geometry/triangle.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

/// Two boxes side by side along x, with a gap; the second one is `higher` than the first.
Bodies two_boxes(double gap, double higher = 0.0) {
  Bodies bodies;
  bodies.add("left", test::box_mesh({3, 2, 2}, {-0.3, 0.0, 0.0}, {0.0, 0.2, 0.2}));
  bodies.add("right", test::box_mesh({2, 3, 4}, {gap, 0.0, 0.0}, {0.4, 0.2, 0.2 + higher}));
  return bodies;
}

int covered(const Bodies& bodies, const FlushFaces& flush, Index body) {
  int count = 0;
  const Range& range = bodies.bodies()[static_cast<std::size_t>(body)].triangles;
  for (Index t = range.begin; t < range.end; ++t) {
    if (!flush.covers(t)) continue;
    ++count;
    for (const Vec3& corner : corners_of(bodies.points_rest(), at(bodies.triangles(), t)))
      EXPECT_NEAR(corner.x, 0.0, 1e-4);
  }
  return count;
}

TEST(FlushFaces, AreThoseOfTheCommonSide) {
  const std::vector<std::uint8_t> still{1, 1};
  for (const double gap : {0.0, 1e-5}) {
    const Bodies bodies = two_boxes(gap);
    const FlushFaces flush(bodies, still, bodies.points_rest());
    EXPECT_EQ(covered(bodies, flush, 0), 2 * 2 * 2) << "two triangles for each cell of the side";
    EXPECT_EQ(covered(bodies, flush, 1), 2 * 3 * 4);
  }
}

TEST(FlushFaces, WhatIsHigherThanTheOtherIsFree) {
  const Bodies bodies = two_boxes(0.0, 0.2);
  const FlushFaces flush(bodies, std::vector<std::uint8_t>{1, 1}, bodies.points_rest());
  EXPECT_EQ(covered(bodies, flush, 0), 2 * 2 * 2);
  EXPECT_EQ(covered(bodies, flush, 1), 2 * 3 * 2) << "the lower half";
}

TEST(FlushFaces, AreNoneAcrossAGapAndOfBodiesThatMove) {
  const Bodies apart = two_boxes(0.01);
  const FlushFaces none(apart, std::vector<std::uint8_t>{1, 1}, apart.points_rest());
  EXPECT_EQ(covered(apart, none, 0) + covered(apart, none, 1), 0);
  const Bodies bodies = two_boxes(0.0);
  const FlushFaces moving(bodies, std::vector<std::uint8_t>{1, 0}, bodies.points_rest());
  EXPECT_EQ(covered(bodies, moving, 0) + covered(bodies, moving, 1), 0);
}

TEST(FlushFaces, ExitsLeadThroughThemOrNot) {
  const Bodies bodies = two_boxes(0.0);
  const auto x = bodies.points_rest();
  const FlushFaces flush(bodies, std::vector<std::uint8_t>{1, 1}, x);
  const Vec3 inside{0.01, 0.1, 0.19};
  EXPECT_TRUE(flush.leads_through(bodies, x, 1, inside, {-1, 0, 0}, 0.011));
  EXPECT_FALSE(flush.leads_through(bodies, x, 1, inside, {-1, 0, 0}, 0.005)) << "it ends before";
  EXPECT_FALSE(flush.leads_through(bodies, x, 1, inside, {0, 0, 1}, 0.01)) << "through the top";
  EXPECT_FALSE(flush.leads_through(bodies, x, 0, inside, {-1, 0, 0}, 0.011)) << "of the other body";
}

}  // namespace
}  // namespace palpate
