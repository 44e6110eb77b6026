// Oracle: the interleave written bit by bit.
#include "grid/z_order.hpp"

#include <gtest/gtest.h>

#include "grid/structures.hpp"

namespace palpate {
namespace {

std::uint64_t interleaved(const Cell& cell) {
  std::uint64_t index = 0;
  for (int bit = 0; bit < 21; ++bit) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto one = static_cast<std::uint64_t>((cell[axis] >> bit) & 1);
      index |= one << (3 * bit + static_cast<int>(axis));
    }
  }
  return index;
}

TEST(ZOrder, InterleavesTwentyOneBitsAnAxis) {
  constexpr std::int32_t most = 1 << 21;
  const ZOrder z({most, most, most});
  EXPECT_EQ(z.bits(), 63);
  EXPECT_EQ(z.index({0, 0, 0}), 0U);
  EXPECT_EQ(z.index({1, 0, 0}), 1U);
  EXPECT_EQ(z.index({0, 1, 0}), 2U);
  EXPECT_EQ(z.index({0, 0, 1}), 4U);
  EXPECT_EQ(z.index({2, 3, 0}), 0b11010U);
  EXPECT_EQ(z.index({most - 1, most - 1, most - 1}), (std::uint64_t{1} << 63) - 1);
  test::Random random(1);
  for (int n = 0; n < 20000; ++n) {
    const Cell cell = test::random_cell(random, {most, most, most});
    ASSERT_EQ(z.index(cell), interleaved(cell)) << n;
    ASSERT_EQ(z.cell_of(z.index(cell)), cell) << n;
  }
}

TEST(ZOrder, IsOneToOneAndGrowsWithEachCoordinateForEverySize) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    test::Random random(seed);
    const auto along = [&] { return random.integer(1, 1 << random.integer(0, 21)); };
    const Cell size{along(), along(), along()};
    const ZOrder z(size);
    double cells = 1.0;
    for (const std::int32_t s : size) cells *= s;
    EXPECT_LE(std::ldexp(1.0, z.bits()), 8.0 * cells);
    for (int n = 0; n < 200; ++n) {
      const Cell cell = test::random_cell(random, size);
      ASSERT_EQ(z.cell_of(z.index(cell)), cell);
      ASSERT_LT(z.index(cell), std::uint64_t{1} << z.bits());
      for (std::size_t axis = 0; axis < 3; ++axis) {
        Cell next = cell;
        next[axis] = random.integer(cell[axis], size[axis] - 1);
        ASSERT_GE(z.index(next), z.index(cell));
      }
    }
  }
}

TEST(ZOrder, AlignedIntervalsAreBoxes) {
  const ZOrder z({40, 3, 1000});
  for (int count = 0; count <= z.bits(); ++count) {
    const Cell first = z.cell_of(0);
    const Cell last = z.cell_of((std::uint64_t{1} << count) - 1);
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_EQ(last[axis] - first[axis] + 1, 1 << z.low_bits(axis, count)) << count << " bits";
  }
}

}  // namespace
}  // namespace palpate
