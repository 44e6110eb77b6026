// Oracles: the definition (eq. 2) in rational arithmetic; a segment-box test in rational arithmetic over all
// cells.
#include "grid/lattice.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <set>

#include <palpate/error.hpp>

#include "support/random.hpp"
#include "support/rational.hpp"

namespace palpate {
namespace {

using test::Random;
using test::Rational;

TEST(Lattice, HasTheSizeAndIndexOfThePaper) {
  const Lattice lattice(Box{{-1, 0, 2}, {1, 3, 2.5}}, 0.5);
  EXPECT_EQ(lattice.size(), (Cell{4, 6, 1}));
  EXPECT_EQ(lattice.cell_count(), 24U);
  EXPECT_EQ(lattice.cell_of({-1, 0, 2}), (Cell{0, 0, 0}));
  EXPECT_EQ(lattice.cell_of({0.25, 1.6, 2.1}), (Cell{2, 3, 0}));
  EXPECT_EQ(lattice.linear_index({2, 3, 0}), 2U + 3U * 4U);
  EXPECT_EQ(lattice.cell_of({1, 3, 2.5}), (Cell{3, 5, 0})) << "the upper end belongs to the last cell";
  EXPECT_EQ(lattice.cell_of({-9, 99, 2}), (Cell{0, 5, 0})) << "outside: nearest cell";
}

TEST(Lattice, HoldsTwoToThe21CellsAlongAnAxisAndThenDoublesThem) {
  const Lattice most(Box{{0, 0, 0}, {2097152, 2097152, 2097152}}, 1.0);
  EXPECT_EQ(most.size(), (Cell{1 << 21, 1 << 21, 1 << 21}));
  EXPECT_EQ(most.doublings(), 0);
  EXPECT_EQ(most.cell_count(), std::uint64_t{1} << 63);
  const Cell last{(1 << 21) - 1, (1 << 21) - 1, (1 << 21) - 1};
  EXPECT_EQ(most.cell_of({2097152, 2097152, 2097152}), last);
  EXPECT_EQ(most.linear_index(last), (std::uint64_t{1} << 63) - 1);
  const Lattice more(Box{{0, 0, 0}, {2097153, 10, 10}}, 1.0);
  EXPECT_EQ(more.doublings(), 1);
  EXPECT_EQ(more.cell_size(), 2.0);
  EXPECT_EQ(more.size(), (Cell{1048577, 5, 5}));
  const Lattice far(Box{{-1e100, 0, 0}, {1e100, 1, 1}}, 1e-9);
  EXPECT_LE(far.size()[0], 1 << 21);
  EXPECT_EQ(far.cell_size(), std::ldexp(1e-9, far.doublings()));
}

TEST(Lattice, ADomainWithoutExtentHasOneCell) {
  const Lattice lattice(Box{{1, 1, 1}, {1, 1, 1}}, 0.1);
  EXPECT_EQ(lattice.cell_count(), 1U);
  EXPECT_EQ(lattice.cell_of({1, 1, 1}), (Cell{0, 0, 0}));
}

/// Whether a segment meets a closed cube, by clipping it in rational arithmetic.
bool meets_cell(const Vec3& a, const Vec3& b, const Cell& cell, const Vec3& lower, double size) {
  const auto p = test::rational(a);
  const auto q = test::rational(b);
  const auto o = test::rational(lower);
  Rational first = 0;
  Rational last = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Rational low = o[axis] + Rational(cell[axis]) * Rational(size);
    const Rational high = low + Rational(size);
    const Rational step = q[axis] - p[axis];
    if (step == 0) {
      if (p[axis] < low || p[axis] > high) return false;
      continue;
    }
    Rational t0 = (low - p[axis]) / step;
    Rational t1 = (high - p[axis]) / step;
    if (t0 > t1) std::swap(t0, t1);
    first = std::max(first, t0);
    last = std::min(last, t1);
  }
  return first <= last;
}

TEST(SegmentFootprint, HasEveryCellPassedAndFewOthers) {
  std::size_t passed = 0;
  std::size_t visited = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    Random random(seed);
    const Vec3 lower{-1, -2, 0.5};
    const double size = 0.25;
    const Lattice lattice(Box{lower, {1, 0, 2.5}}, size);
    const auto point = [&] {
      // Every other segment has its ends on cell corners, so that it runs along walls, edges and diagonals.
      if (seed % 2 == 0) {
        return Vec3{lower.x + size * random.integer(0, 8), lower.y + size * random.integer(0, 8),
                    lower.z + size * random.integer(0, 8)};
      }
      return Vec3{random.uniform(-1, 1), random.uniform(-2, 0), random.uniform(0.5, 2.5)};
    };
    const Vec3 a = point();
    const Vec3 b = point();
    std::set<Cell> cells;
    std::size_t calls = 0;
    lattice.for_each_cell_of_segment(a, b, [&](std::int32_t i, std::int32_t j, std::int32_t k) {
      cells.insert({i, j, k});
      ++calls;
    });
    ASSERT_EQ(calls, cells.size()) << "no cell twice, seed " << seed;
    for (std::int32_t k = 0; k < 8; ++k) {
      for (std::int32_t j = 0; j < 8; ++j) {
        for (std::int32_t i = 0; i < 8; ++i) {
          const bool meets = meets_cell(a, b, {i, j, k}, lower, size);
          passed += meets ? 1 : 0;
          ASSERT_TRUE(!meets || cells.contains({i, j, k}))
              << "seed " << seed << " cell " << i << " " << j << " " << k;
        }
      }
    }
    visited += cells.size();
  }
  EXPECT_LT(static_cast<double>(visited), 1.02 * static_cast<double>(passed));
}

TEST(Bounds, NamesTheFirstBadPoint) {
  const parallel::Threads threads(2);
  std::vector<Vec3> x(20000, Vec3{1, 2, 3});
  std::vector<std::uint8_t> used(x.size(), 1);
  std::vector<Box> scratch;
  x[5] = {-1, 7, 3};
  const Box box = bounds_of(threads, x, used, scratch);
  EXPECT_EQ(box.lower, (Vec3{-1, 2, 3}));
  EXPECT_EQ(box.upper, (Vec3{1, 7, 3}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {nan, std::numeric_limits<double>::infinity(), -1e200}) {
    x[19000].z = bad;
    x[12000].y = bad;
    used[12000] = 1;
    try {
      bounds_of(threads, x, used, scratch);
      FAIL() << bad;
    } catch (const Error& e) {
      EXPECT_EQ(e.where(), "point 12000");
    }
    used[12000] = 0;
    try {
      bounds_of(threads, x, used, scratch);
      FAIL() << bad;
    } catch (const Error& e) {
      EXPECT_EQ(e.where(), "point 19000");
    }
  }
}

}  // namespace
}  // namespace palpate
