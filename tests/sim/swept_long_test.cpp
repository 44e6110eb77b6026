// Ten thousand shots; the ordinary tests have the first some hundred.
#include <gtest/gtest.h>

#include "sim/shots.hpp"

namespace palpate {
namespace {

test::Shots ten_thousand_shots(ContinuousDetection continuous) {
  const test::Shots shots = test::shoot_all(1000000, 10000, continuous);
  EXPECT_LE(shots.creeps, 2);
  EXPECT_EQ(shots.blown_up, 0);
  return shots;
}

TEST(SweptInTheLarge, OfTenThousandShotsNoneGoesThrough) {
  EXPECT_EQ(ten_thousand_shots(ContinuousDetection::full).through, 0);
}

TEST(SweptInTheLarge, OfTenThousandShotsFewGoThroughALimitedSearchAndAreCounted) {
  const test::Shots shots = ten_thousand_shots(ContinuousDetection::limited);
  EXPECT_LE(shots.through, 10);
  EXPECT_EQ(shots.unseen, 0);
}

}  // namespace
}  // namespace palpate
