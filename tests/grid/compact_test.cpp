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

// With slots, L has the same size whatever the footprints; what is visited is what build() visits.
TEST(CompactGrid, HasAStaticArrayOfSlotsOfWhichTheUnusedComeLastAndAreNeverVisited) {
  constexpr std::size_t slots = 8;
  for (const Order order : {Order::linear, Order::z}) {
    for (const double extent :
         {3.0, 40.0, 5000.0}) {  // a start for each key; for several; several cells a key
      test::Random random(4);
      Covered covered;
      covered.lattice = Lattice(Box{{0, 0, 0}, {extent, extent, extent}}, 0.25);
      std::size_t covers = 0;
      for (int p = 0; p < 1000; ++p) {
        covered.cells.emplace_back();
        const Vec3 a = random.point(0, extent);
        covered.lattice.for_each_cell_of_segment(a, a + random.point(-0.4, 0.4),
                                                 [&](std::int32_t i, std::int32_t j, std::int32_t k) {
                                                   if (covered.cells.back().size() < slots && p % 7 != 0)
                                                     covered.cells.back().push_back({i, j, k});
                                                 });
        covers += covered.cells.back().size();
      }
      ASSERT_LT(covers, slots * covered.cells.size()) << "some slots are unused";
      CompactGrid with_slots(order);
      CompactGrid grid(order);
      with_slots.build_slots(parallel::Threads(3), covered.lattice, covered.cells.size(), slots,
                             covered.footprint());
      test::build(grid, covered);
      ASSERT_EQ(grid.entries().size(), covers);
      ASSERT_EQ(with_slots.entries().size(), slots * covered.cells.size());
      ASSERT_TRUE(std::equal(grid.entries().begin(), grid.entries().end(), with_slots.entries().begin()));
      const std::uint32_t unused = cell_key_of(with_slots.entries().back());
      for (const Entry entry : with_slots.entries().subspan(covers)) ASSERT_EQ(cell_key_of(entry), unused);
      ASSERT_LT(cell_key_of(grid.entries().back()), unused);
      const Cell& size = covered.lattice.size();
      const Cell last{size[0] - 1, size[1] - 1, size[2] - 1};
      std::vector<CellRange> ranges{{{0, 0, 0}, last}, {last, last}, {{0, 0, last[2]}, last}};
      for (const auto& cells : covered.cells) {
        if (!cells.empty()) ranges.push_back({cells.front(), cells.front()});
      }
      for (const CellRange& range : ranges)
        ASSERT_EQ(test::visits(with_slots, range), test::visits(grid, range));
    }
  }
}

}  // namespace
}  // namespace palpate
