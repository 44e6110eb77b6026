// Occupancy and retries of the cuckoo table; its failures, forced by tables that are too small.
#include <gtest/gtest.h>

#include <palpate/error.hpp>

#include "grid/structures.hpp"

namespace palpate {
namespace {

using test::Covered;

/// `count` primitives in as many cells, or in half as many with `sharing`: p and p + count / 2 share one.
Covered one_in_each_cell(int count, bool sharing = false) {
  Covered covered;
  covered.lattice = Lattice(Box{{0, 0, 0}, {100, 100, 100}}, 1.0);
  const int cells = sharing ? count / 2 : count;
  for (int p = 0; p < count; ++p) {
    const int c = p % cells;
    covered.cells.push_back({{c % 100, c / 100 % 100, c / 10000}});
  }
  return covered;
}

void expect_each_found_in_its_cell(const CuckooGrid& grid, const Covered& covered, bool sharing = false) {
  const std::size_t n = covered.cells.size();
  const std::size_t cells = sharing ? n / 2 : n;
  for (std::size_t p = 0; p < cells; ++p) {
    std::vector<Index> expected{static_cast<Index>(p)};
    if (sharing) expected.push_back(static_cast<Index>(p + cells));
    const Cell& cell = covered.cells[p][0];
    ASSERT_EQ(test::visits(grid, {cell, cell}), expected) << "primitive " << p;
  }
  const auto none = test::visits(grid, {{99, 99, 99}, {99, 99, 99}});
  ASSERT_TRUE(none.empty());
}

TEST(CuckooGrid, FillsSeventyOnePercentOfItsSlots) {
  CuckooGrid grid;
  for (const int count : {20000, 100000, 300000}) {
    test::build(grid, one_in_each_cell(count), 2);
    const CuckooCounts& s = grid.counts();
    EXPECT_EQ(s.cells, static_cast<std::size_t>(count));
    EXPECT_EQ(s.slots, s.buckets * 3 * 192);
    EXPECT_GT(s.occupancy(), 0.70) << count;
    EXPECT_LE(s.occupancy(), 0.7101) << count;
    EXPECT_EQ(s.redistributions, 0U) << count;
    EXPECT_EQ(s.growths, 0U) << count;
    EXPECT_LE(static_cast<double>(s.bucket_retries), 0.02 * static_cast<double>(s.buckets)) << count;
  }
}

TEST(CuckooGrid, KeepsCellsWithTheSame32BitHashApart) {
  // 450000 cells: about 24 pairs of them have the same first hash. Their primitives alternate, so they come
  // out mixed unless they are split.
  const Covered covered = one_in_each_cell(900000, true);
  CuckooGrid grid;
  test::build(grid, covered, 2);
  EXPECT_EQ(grid.counts().cells, 450000U);
  expect_each_found_in_its_cell(grid, covered, true);
}

CuckooParameters tiny() {
  CuckooParameters parameters;
  parameters.bucket_target = 4;
  parameters.bucket_capacity = 9;
  parameters.table_slots = 2;
  parameters.most_rounds = 4;
  parameters.most_functions = 3;
  parameters.most_distributions = 3;
  parameters.most_growths = 40;
  return parameters;
}

TEST(CuckooGrid, TakesNewFunctionsAndLargerTablesUntilAllCellsHaveAPlace) {
  std::size_t retries = 0;
  std::size_t redistributions = 0;
  std::size_t growths = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    CuckooParameters parameters = tiny();
    parameters.seed = seed;
    CuckooGrid grid(Order::z, parameters);
    for (const int count : {1, 7, 100, 1000}) {
      const Covered covered = one_in_each_cell(count);
      test::build(grid, covered, 3);
      ASSERT_NO_FATAL_FAILURE(expect_each_found_in_its_cell(grid, covered)) << "seed " << seed;
      retries += grid.counts().bucket_retries;
      redistributions += grid.counts().redistributions;
      growths += grid.counts().growths;
      CuckooGrid again(Order::z, parameters);
      test::build(again, covered, 1);
      ASSERT_EQ(again.counts().slots, grid.counts().slots) << "the same attempts for every thread count";
      ASSERT_EQ(again.counts().bucket_retries, grid.counts().bucket_retries);
    }
  }
  EXPECT_GT(retries, 1000U);
  EXPECT_GT(redistributions, 10U);
  EXPECT_GT(growths, 50U);
}

TEST(CuckooGrid, SaysWhenItsLimitsDoNotSufficeAndIsEmptyThen) {
  CuckooParameters parameters = tiny();
  parameters.table_slots = 1;  // three slots for each four keys
  parameters.most_growths = 0;
  CuckooGrid grid(Order::linear, parameters);
  EXPECT_THROW(test::build(grid, one_in_each_cell(400)), Error);
  EXPECT_TRUE(test::visits(grid, {{0, 0, 0}, {99, 99, 99}}).empty());
  EXPECT_TRUE(test::visits(grid, {{0, 0, 0}, {0, 0, 0}}).empty());
  const Covered small = one_in_each_cell(1);
  test::build(grid, small);
  expect_each_found_in_its_cell(grid, small);
}

}  // namespace
}  // namespace palpate
