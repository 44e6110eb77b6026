// Oracles: the definition (K different cells of the range, all of them in the long run), and the chi-squared
// statistic.
#include "grid/cell_slots.hpp"

#include <gtest/gtest.h>
#include <map>
#include <set>

namespace palpate {
namespace {

std::vector<Cell> cells_of(const CellSlots& slots, std::uint64_t primitive, const CellRange& range) {
  std::vector<Cell> cells;
  slots.for_each_range(primitive, range, [&](const CellRange& part) {
    for (std::int32_t k = part.lower[2]; k <= part.upper[2]; ++k) {
      for (std::int32_t j = part.lower[1]; j <= part.upper[1]; ++j) {
        for (std::int32_t i = part.lower[0]; i <= part.upper[0]; ++i) cells.push_back({i, j, k});
      }
    }
  });
  return cells;
}

const CellRange range{{2, -1, 5}, {4, 2, 6}};  // 3 x 4 x 2 = 24 cells

TEST(CellSlots, AllCellsWhereTheyFit) {
  for (const int k : {0, 24, 27}) {
    EXPECT_EQ(cells_of(CellSlots(k, 3), 7, range).size(), 24U) << k;
    EXPECT_EQ(CellSlots(k, 3).left_out(24), 0U);
  }
  EXPECT_TRUE(CellSlots().exact());
}

TEST(CellSlots, KDifferentCellsOfTheRangeWhereTheyDoNot) {
  for (const int k : {1, 8, 23}) {
    for (std::uint64_t primitive = 0; primitive < 200; ++primitive) {
      const CellSlots slots(k, primitive / 10);
      const auto cells = cells_of(slots, primitive, range);
      ASSERT_EQ(cells.size(), static_cast<std::size_t>(k));
      ASSERT_EQ(std::set<Cell>(cells.begin(), cells.end()).size(), cells.size());
      for (const Cell& c : cells) ASSERT_TRUE(range.contains(c));
      ASSERT_EQ(slots.left_out(24), 24U - static_cast<std::uint64_t>(k));
    }
  }
}

TEST(CellSlots, EachCellIsEquallyLikelyOverStepsAndPrimitives) {
  for (const bool by_step : {true, false}) {
    std::map<Cell, int> chosen;
    const int draws = 24000;
    for (int n = 0; n < draws; ++n) {
      const auto number = static_cast<std::uint64_t>(n);
      for (const Cell& c : cells_of(CellSlots(8, by_step ? number : 0), by_step ? 5 : number, range))
        ++chosen[c];
    }
    ASSERT_EQ(chosen.size(), 24U);
    const double expected = draws * 8.0 / 24.0;
    double chi_squared = 0.0;
    for (const auto& [cell, count] : chosen)
      chi_squared += (count - expected) * (count - expected) / expected;
    EXPECT_LT(chi_squared, 50.0) << "23 degrees of freedom: beyond 49.7 once in a thousand";
  }
}

TEST(CellSlots, TheSameForTheSameStepOnly) {
  EXPECT_EQ(cells_of(CellSlots(8, 1), 5, range), cells_of(CellSlots(8, 1), 5, range));
  EXPECT_NE(cells_of(CellSlots(8, 1), 5, range), cells_of(CellSlots(8, 2), 5, range));
  EXPECT_NE(cells_of(CellSlots(8, 1), 5, range), cells_of(CellSlots(8, 1), 6, range));
}

TEST(CellSlots, HugeRangesCostNothing) {
  const CellRange huge{{0, 0, 0}, {2000000, 2000000, 2000000}};
  EXPECT_EQ(cells_of(CellSlots(27, 1), 5, huge).size(), 27U);
}

}  // namespace
}  // namespace palpate
