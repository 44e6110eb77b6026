// The invariants that define L and C (paper 4.2), and when C and the keys are shared.
#include <algorithm>
#include <gtest/gtest.h>

#include "grid/structures.hpp"

namespace palpate {
namespace {

using test::Covered;

Covered points_in(const Vec3& extent, double cell_size, int count) {
  test::Random random(3);
  Covered covered;
  covered.lattice = Lattice(Box{{0, 0, 0}, extent}, cell_size);
  for (int p = 0; p < count; ++p) {
    const Vec3 x{random.uniform(0, extent.x), random.uniform(0, extent.y), random.uniform(0, extent.z)};
    covered.cells.push_back({covered.lattice.cell_of(x)});
  }
  return covered;
}

void expect_well_formed(const CompactGrid& grid) {
  ASSERT_TRUE(std::is_sorted(grid.entries().begin(), grid.entries().end()));
  ASSERT_EQ(grid.cell_begin().front(), 0U);
  ASSERT_EQ(grid.cell_begin().back(), grid.entries().size());
  for (std::size_t b = 0; b + 1 < grid.cell_begin().size(); ++b) {
    for (std::uint32_t e = grid.cell_begin()[b]; e < grid.cell_begin()[b + 1]; ++e)
      ASSERT_EQ(cell_key_of(grid.entries()[e]) >> grid.start_shift(), b);
  }
}

TEST(CompactGrid, HasAStartForEachCellWhileTheyAreInProportion) {
  for (const Order order : {Order::linear, Order::z}) {
    CompactGrid grid(order);
    test::build(grid, points_in({40, 40, 40}, 1.0, 100));
    EXPECT_EQ(grid.key_shift(), 0);
    EXPECT_EQ(grid.start_shift(), order == Order::linear ? 0 : 2) << "2^18 indices, 65536 starts";
    expect_well_formed(grid);
    test::build(grid, points_in({40, 40, 40}, 1.0, 40000));
    EXPECT_EQ(grid.start_shift(), 0) << "320000 starts";
    expect_well_formed(grid);
  }
  CompactGrid grid;
  test::build(grid, points_in({40, 40, 40}, 1.0, 100));
  EXPECT_EQ(grid.cell_begin().size(), 64001U);
}

TEST(CompactGrid, SharesStartsAndThenKeysInLargerDomains) {
  for (const Order order : {Order::linear, Order::z}) {
    CompactGrid grid(order);
    test::build(grid, points_in({1024, 1024, 1024}, 1.0, 1000));
    EXPECT_EQ(grid.key_shift(), 0);
    EXPECT_EQ(grid.start_shift(), 14) << "2^30 cells, 2^16 starts";
    expect_well_formed(grid);
    test::build(grid, points_in({2097152, 2097152, 2097152}, 1.0, 1000));
    EXPECT_EQ(grid.key_shift(), 32) << "63 bits into 31";
    EXPECT_EQ(grid.cell_begin().size(), 65537U);
    expect_well_formed(grid);
  }
}

}  // namespace
}  // namespace palpate
