// One suite over all structures. Oracle: all primitives, all their cells, compared with the range one by one.
#include "grid/structures.hpp"

#include <algorithm>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using test::Covered;
using test::Random;
using test::random_cell;

constexpr int kinds = 11;

Cell moved(Cell cell, const Cell& by, const Cell& size) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    cell[axis] = std::clamp(cell[axis] + by[axis], 0, size[axis] - 1);
  return cell;
}

Box box_of_kind(int kind, Random& random) {
  switch (kind) {
    case 6:  // negative coordinates
      return {{-9, -7, -8}, {-5, -6, -2}};
    case 7:  // as large as it gets: an index of 63 bits
      return {{0, 0, 0}, {524288, 524288, 524288}};
    case 8:  // flat: 42 bits
      return {{0, 0, 0}, {524288, 524288, 0.25}};
    case 9:  // long: 21 bits
      return {{0, 0, 0}, {0.25, 524288, 0.25}};
    case 10:  // more cells than starts, but keys that fit 32 bits
      return {{0, 0, 0}, {100, 60, 90}};
    default:
      return {{0, 0, 0}, {random.uniform(0.3, 6), random.uniform(0.3, 6), random.uniform(0.3, 6)}};
  }
}

std::vector<Cell> cells_of_segment(const Lattice& lattice, const Vec3& a, const Vec3& b) {
  std::vector<Cell> cells;
  lattice.for_each_cell_of_segment(a, b, [&](std::int32_t i, std::int32_t j, std::int32_t k) {
    cells.push_back({i, j, k});
  });
  return cells;
}

std::vector<Cell> cells_of_box(const CellRange& range) {
  std::vector<Cell> cells;
  for (std::int32_t k = range.lower[2]; k <= range.upper[2]; ++k)
    for (std::int32_t j = range.lower[1]; j <= range.upper[1]; ++j)
      for (std::int32_t i = range.lower[0]; i <= range.upper[0]; ++i) cells.push_back({i, j, k});
  return cells;
}

/// Primitives of one kind; everything follows from the seed.
Covered make_covered(int kind, std::uint64_t seed) {
  Random random(seed * kinds + static_cast<std::uint64_t>(kind));
  Covered covered;
  const Box box = box_of_kind(kind, random);
  covered.lattice = Lattice(box, 0.25);
  const Lattice& lattice = covered.lattice;
  const Cell& size = lattice.size();
  const auto point = [&] {
    return Vec3{random.uniform(box.lower.x, box.upper.x), random.uniform(box.lower.y, box.upper.y),
                random.uniform(box.lower.z, box.upper.z)};
  };
  const int count = kind == 3 ? random.integer(0, 1) * 20 : random.integer(1, 250);
  const Cell centre = random_cell(random, size);
  for (int p = 0; p < count; ++p) {
    switch (kind) {
      case 1:  // segments, half of them between corners of cells
        covered.cells.push_back(random.chance(0.5) ? cells_of_segment(lattice, point(), point())
                                                   : cells_of_segment(lattice, random.grid_point(0, 8, 0.25),
                                                                      random.grid_point(0, 8, 0.25)));
        break;
      case 2: {  // boxes of triangles
        const Vec3 a = point();
        Box triangle;
        for (int corner = 0; corner < 3; ++corner) triangle.extend(a + random.point(-0.4, 0.4));
        covered.cells.push_back(cells_of_box(lattice.cells_of(triangle)));
        break;
      }
      case 3:  // nothing at all, or primitives without a cell
        covered.cells.emplace_back();
        break;
      case 4:  // all in one cell, except one primitive in the next cell
        covered.cells.push_back({p == count / 2 ? moved(centre, {1, 0, 0}, size) : centre});
        break;
      case 5: {  // corners, edges and walls of the domain
        const auto end = [&](std::size_t axis) { return random.chance(0.5) ? 0 : size[axis] - 1; };
        Cell cell = random_cell(random, size);
        for (std::size_t axis = 0; axis < 3; ++axis) cell[axis] = random.chance(0.7) ? end(axis) : cell[axis];
        covered.cells.push_back({cell});
        break;
      }
      case 10: {  // clusters, of points and segments
        const Vec3 a = lattice.domain().lower + Vec3{10.0 * (p % 3), 20.0 * (p % 2), 40.0 * (p % 2)};
        covered.cells.push_back(
            cells_of_segment(lattice, a + random.point(0, 2), a + random.point(0, p % 4)));
        break;
      }
      default:
        covered.cells.push_back({lattice.cell_of(point())});
        break;
    }
  }
  return covered;
}

CellRange range_between(const Cell& a, const Cell& b) {
  CellRange range{a, a};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    range.lower[axis] = std::min(a[axis], b[axis]);
    range.upper[axis] = std::max(a[axis], b[axis]);
  }
  return range;
}

std::vector<CellRange> make_ranges(const Covered& covered, std::uint64_t seed) {
  Random random(seed);
  const Cell& size = covered.lattice.size();
  const Cell last{size[0] - 1, size[1] - 1, size[2] - 1};
  std::vector<CellRange> ranges{{{0, 0, 0}, last}, {{0, 0, 0}, {0, 0, 0}}, {last, last}};
  const auto stride = [&] { return random.integer(-2, 2); };
  for (int n = 0; n < 30; ++n) {
    const Cell cell = random_cell(random, size);
    ranges.push_back(range_between(cell, random_cell(random, size)));
    ranges.push_back(range_between(cell, moved(cell, {stride(), stride(), stride()}, size)));
    if (covered.cells.empty()) continue;
    const auto& cells = at(covered.cells, random.integer(0, static_cast<int>(covered.cells.size()) - 1));
    if (cells.empty()) continue;
    ranges.push_back({cells[0], cells[0]});
    ranges.push_back(range_between(moved(cells[0], {stride(), stride(), stride()}, size), cells.back()));
  }
  return ranges;
}

/// Each primitive as often as it covers a cell of the range, in ascending order.
std::vector<Index> expected_visits(const Covered& covered, const CellRange& range) {
  std::vector<Index> expected;
  for (std::size_t p = 0; p < covered.cells.size(); ++p) {
    for (const Cell& cell : covered.cells[p]) {
      bool in = true;
      for (std::size_t axis = 0; axis < 3; ++axis)
        in = in && range.lower[axis] <= cell[axis] && cell[axis] <= range.upper[axis];
      if (in) expected.push_back(static_cast<Index>(p));
    }
  }
  return expected;
}

template <class Grid>
void expect_found(const Grid& grid, const Covered& covered, const CellRange& range) {
  std::vector<Index> expected = expected_visits(covered, range);
  std::vector<Index> visited = test::visits(grid, range);
  std::sort(visited.begin(), visited.end());
  if (test::exact(grid)) {
    ASSERT_EQ(visited, expected);
    return;
  }
  expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
  ASSERT_TRUE(std::includes(visited.begin(), visited.end(), expected.begin(), expected.end()));
  for (auto p = visited.begin(); p != visited.end();) {  // beside the range, but no entry twice
    const auto next = std::upper_bound(p, visited.end(), *p);
    ASSERT_LE(next - p, std::max<std::ptrdiff_t>(1, std::ssize(at(covered.cells, *p)))) << "primitive " << *p;
    p = next;
  }
}

template <class Grid>
class StructureOf : public ::testing::Test {};

using Structures =
    ::testing::Types<test::In<UniformGrid, Order::linear>, test::In<UniformGrid, Order::z>,
                     test::In<CompactGrid, Order::linear>, test::In<CompactGrid, Order::z>, HashGrid,
                     test::In<CuckooGrid, Order::linear>, test::In<CuckooGrid, Order::z>, BruteForce>;

class Name {
 public:
  template <class Grid>
  static std::string GetName(int index) {
    constexpr const char* names[] = {"UniformLinear", "UniformZ",     "CompactLinear", "CompactZ",
                                     "Hash",          "CuckooLinear", "CuckooZ",       "Brute"};
    return names[index];
  }
};

TYPED_TEST_SUITE(StructureOf, Structures, Name);

TYPED_TEST(StructureOf, FindsWhatCoversTheCellsOfARange) {
  TypeParam grid;  // one for all: it must forget what it held
  EXPECT_TRUE(test::visits(grid, {{0, 0, 0}, {3, 3, 3}}).empty()) << "before the first build";
  for (std::uint64_t seed = 0; seed < 25; ++seed) {
    for (int kind = 0; kind < kinds; ++kind) {
      SCOPED_TRACE("kind " + std::to_string(kind) + ", seed " + std::to_string(seed));
      const Covered covered = make_covered(kind, seed);
      test::build(grid, covered);
      for (const CellRange& range : make_ranges(covered, seed))
        ASSERT_NO_FATAL_FAILURE(expect_found(grid, covered, range));
    }
  }
}

TYPED_TEST(StructureOf, HoldsMoreThan65536PrimitivesInACell) {
  Covered covered;
  covered.lattice = Lattice(Box{{0, 0, 0}, {5, 5, 5}}, 1.0);
  covered.cells.assign(70000, {{2, 3, 1}});
  covered.cells[12345] = {{2, 3, 2}};
  TypeParam grid;
  test::build(grid, covered, 2);
  for (const CellRange& range : {CellRange{{2, 3, 1}, {2, 3, 1}}, CellRange{{2, 3, 2}, {2, 3, 2}},
                                 CellRange{{0, 0, 0}, {4, 4, 4}}, CellRange{{0, 0, 0}, {1, 4, 4}}})
    expect_found(grid, covered, range);
}

TYPED_TEST(StructureOf, VisitsInTheSameOrderForEveryThreadCount) {
  Random random(5);
  Covered covered;
  covered.lattice = Lattice(Box{{0, 0, 0}, {40, 40, 40}}, 1.0);
  for (int p = 0; p < 60000; ++p) {
    const Vec3 a = random.point(1, 39);
    covered.cells.push_back(cells_of_segment(covered.lattice, a, a + random.point(-1, 1)));
  }
  std::vector<CellRange> ranges;
  for (int n = 0; n < 100; ++n) {
    const Cell cell = random_cell(random, covered.lattice.size());
    ranges.push_back(range_between(cell, moved(cell, {2, 1, 1}, covered.lattice.size())));
  }
  TypeParam one;
  test::build(one, covered);
  for (const int threads : {2, 3, 5}) {
    TypeParam grid;
    test::build(grid, covered, threads);
    for (const CellRange& range : ranges) ASSERT_EQ(test::visits(grid, range), test::visits(one, range));
  }
}

}  // namespace
}  // namespace palpate
