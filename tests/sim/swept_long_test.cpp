// Ten thousand shots; the ordinary tests have the first some hundred.
#include <gtest/gtest.h>

#include "sim/shots.hpp"

namespace palpate {
namespace {

TEST(SweptInTheLarge, ShotsOfTenThousandThatGoThroughAreAsFewAsKnown) {
  constexpr int count = 10000;
  const test::Shots shots = test::shoot_all(1000000, count);
  EXPECT_LE(shots.through, count / 1000);
  EXPECT_LE(shots.creeps, count / 1000);
  EXPECT_LE(shots.blown_up, count / 1000);
}

}  // namespace
}  // namespace palpate
