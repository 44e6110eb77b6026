// Oracle: edges and thicknesses of boxes, by hand.
#include "scene/coarse_pairs.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "support/meshes.hpp"

namespace palpate {
namespace {

/// A sheet of 10 cm, 4 mm thin, over another one.
Bodies two_sheets(int cells, int cells_of_other) {
  Bodies bodies;
  bodies.add("low", test::box_mesh({cells, cells, 1}, {0, 0, 0}, {0.1, 0.1, 0.004}));
  bodies.add("high", test::box_mesh({cells_of_other, cells_of_other, 1}, {0, 0, 0.2}, {0.1, 0.1, 0.204}));
  return bodies;
}

TEST(CoarsePairs, NamesThinBodiesOfLongEdges) {
  const std::vector<CoarsePair> pairs = coarse_pairs(two_sheets(4, 5), {});
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].bodies, (std::array<Index, 2>{0, 1}));
  for (const double thickness : pairs[0].thickness) EXPECT_NEAR(thickness, 0.004, 1e-9);
  // Most triangles are halves of square cells.
  const double of_cell = (2.0 + std::sqrt(2.0)) / 3.0;
  EXPECT_NEAR(pairs[0].edges[0], 0.025 * of_cell, 0.004);
  EXPECT_NEAR(pairs[0].edges[1], 0.02 * of_cell, 0.003);
}

TEST(CoarsePairs, OneFineMeshIsEnoughForBoth) {
  EXPECT_TRUE(coarse_pairs(two_sheets(4, 20), {}).empty());
}

TEST(CoarsePairs, AThickBodyIsFineEnough) {
  Bodies bodies = two_sheets(4, 4);
  bodies.add("block", test::box_mesh({2, 2, 2}, {0, 0, 0.4}, {0.1, 0.1, 0.5}));
  EXPECT_EQ(coarse_pairs(bodies, {}).size(), 1U) << "the two sheets";
}

TEST(CoarsePairs, LeavesOutWhatCannotMove) {
  const std::vector<std::uint8_t> rigid{1, 1};
  EXPECT_TRUE(coarse_pairs(two_sheets(4, 4), rigid).empty());
  const std::vector<std::uint8_t> one{1, 0};
  EXPECT_EQ(coarse_pairs(two_sheets(4, 4), one).size(), 1U);
}

}  // namespace
}  // namespace palpate
