// Ten thousand shots; the ordinary tests have the first some hundred.
#include <gtest/gtest.h>

#include "sim/shots.hpp"

namespace palpate {
namespace {

test::Shots ten_thousand_shots(ContinuousDetection continuous) {
  const test::Shots shots = test::shoot_all(1000000, 10000, continuous);
  EXPECT_LE(shots.creeps, 2);
  EXPECT_LE(shots.turned, 3);
  EXPECT_EQ(shots.unseen, 0);
  EXPECT_EQ(shots.blown_up, 0);
  return shots;
}

TEST(SweptInTheLarge, OfTenThousandShotsNoneGoesThrough) {
  EXPECT_EQ(ten_thousand_shots(ContinuousDetection::full).through, 0);
}

TEST(SweptInTheLarge, OfTenThousandShotsNoneGoesThroughALimitedSearch) {
  EXPECT_EQ(ten_thousand_shots(ContinuousDetection::limited).through, 0);
}

/// Soft balls and sheets that drape over a thin or sharp obstacle can be pierced by it.
TEST(SweptInTheLarge, OfTenThousandShotsOfAnyTissueAndTimeStepFewGoThrough) {
  const test::Shots shots =
      test::shoot_all(2000000, 10000, ContinuousDetection::full, test::random_shot_of_any_tissue);
  EXPECT_LE(shots.through, 5);
  EXPECT_LE(shots.unseen, 2);
  EXPECT_LE(shots.creeps, 2);
  EXPECT_EQ(shots.blown_up, 0);
}

}  // namespace
}  // namespace palpate
