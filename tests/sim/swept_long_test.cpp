// Ten thousand shots; the ordinary tests have the first some hundred.
#include <gtest/gtest.h>

#include "sim/shots.hpp"

namespace palpate {
namespace {

TEST(SweptInTheLarge, OfTenThousandShotsNoneGoesThrough) {
  constexpr int count = 10000;
  const test::Shots shots = test::shoot_all(1000000, count, ContinuousDetection::full);
  EXPECT_EQ(shots.through, 0);
  EXPECT_LE(shots.creeps, 2);
  EXPECT_EQ(shots.blown_up, 0);
}

TEST(SweptInTheLarge, OfTenThousandShotsFewGoThroughALimitedSearchAndAreCounted) {
  constexpr int count = 10000;
  const test::Shots shots = test::shoot_all(1000000, count, ContinuousDetection::limited);
  EXPECT_LE(shots.through, 10);
  EXPECT_EQ(shots.unseen, 0);
  EXPECT_LE(shots.creeps, 2);
  EXPECT_LE(shots.blown_up, 1);
}

}  // namespace
}  // namespace palpate
