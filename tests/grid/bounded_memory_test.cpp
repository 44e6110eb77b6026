// 1 mm elements scattered over 1 km: memory follows the number of primitives, and queries stay queries.
#include <cstdio>
#include <gtest/gtest.h>

#include "grid/structures.hpp"

namespace palpate {
namespace {

constexpr int count = 20000;
constexpr double domain = 1000.0;
constexpr double element = 1e-3;

/// Places of the elements: all over the domain, in a hundred clusters of 20 cm, or in one plane.
std::vector<Vec3> places(const std::string& layout) {
  test::Random random(7);
  std::vector<Vec3> clusters;
  for (int c = 0; c < 100; ++c) clusters.push_back(random.point(1, domain - 1));
  std::vector<Vec3> x;
  for (int p = 0; p < count; ++p) {
    if (layout == "clustered") {
      x.push_back(clusters[static_cast<std::size_t>(p % 100)] + random.point(0.0, 0.2));
    } else {
      x.push_back(random.point(0.0, domain - element));
      if (layout == "flat") x.back().z = 0.5 * element;
    }
  }
  return x;
}

struct Cost {
  double bytes;       ///< per primitive
  double candidates;  ///< per pair
};

/// Puts the points into the grid and asks for those in the box of each element.
template <class Grid>
Cost cost_of(const std::string& layout) {
  test::Covered covered;
  const std::vector<Vec3> x = places(layout);
  const double height = layout == "flat" ? element : domain;
  covered.lattice = Lattice(Box{{0, 0, 0}, {domain, domain, height}}, element);
  EXPECT_EQ(covered.lattice.doublings(), 0);
  for (const Vec3& p : x) covered.cells.push_back({covered.lattice.cell_of(p)});
  Grid grid;
  test::build(grid, covered, 2);
  std::size_t candidates = 0;
  for (std::size_t p = 0; p < x.size(); ++p) {
    const Vec3 half{element / 2, element / 2, element / 2};
    bool itself = false;
    grid.for_each(covered.lattice.cells_of({x[p] - half, x[p] + half}), [&](Index q) {
      ++candidates;
      itself = itself || q == static_cast<Index>(p);
    });
    EXPECT_TRUE(itself) << p;
  }
  return {static_cast<double>(grid.bytes()) / count, static_cast<double>(candidates) / count / count};
}

template <class Grid>
void expect_in_proportion(const char* name, double most_bytes, double most_candidates) {
  for (const std::string layout : {"scattered", "clustered", "flat"}) {
    const Cost cost = cost_of<Grid>(layout);
    EXPECT_LE(cost.bytes, most_bytes) << name << ", " << layout << ": bytes per primitive";
    EXPECT_LE(cost.candidates, most_candidates) << name << ", " << layout << ": candidates per pair";
    ::testing::Test::RecordProperty(std::string(name) + "_" + layout + "_bytes", std::to_string(cost.bytes));
    ::testing::Test::RecordProperty(std::string(name) + "_" + layout + "_candidates",
                                    std::to_string(cost.candidates));
  }
}

// A hundred clusters: a structure that cannot tell the cells of a cluster apart proposes a hundredth of all
// pairs.
constexpr double a_cluster = 0.0101;
// One that tells all cells apart proposes little more than each element itself.
constexpr double few = 1.1 / count;

TEST(BoundedMemory, OfTheCompactGrid) {
  expect_in_proportion<test::In<CompactGrid, Order::linear>>("compact_linear", 8 + 8 * 4 + 1, 0.001);
  expect_in_proportion<test::In<CompactGrid, Order::z>>("compact_z", 8 + 8 * 4 + 1, a_cluster);
}
TEST(BoundedMemory, OfTheUniformGrid) {
  expect_in_proportion<test::In<UniformGrid, Order::linear>>("uniform_linear", 8 * 24 + 40, a_cluster);
  expect_in_proportion<test::In<UniformGrid, Order::z>>("uniform_z", 8 * 24 + 40, a_cluster);
}
TEST(BoundedMemory, OfTheHashGrid) {
  expect_in_proportion<HashGrid>("hash", 4 * 4 + 2 * 16, few);
}
TEST(BoundedMemory, OfTheCuckooGrid) {
  expect_in_proportion<test::In<CuckooGrid, Order::linear>>("cuckoo_linear", 80, few);
  expect_in_proportion<test::In<CuckooGrid, Order::z>>("cuckoo_z", 80, few);
}

/// The rows of docs/structures.md. Points: 100000, one for each cell on average; edges: 100000 of them about
/// a cell long, in 2.5 cells on average.
template <class Grid>
void print_bytes(const char* name) {
  test::Random random(9);
  test::Covered points;
  test::Covered edges;
  constexpr int n = 100000;
  points.lattice = edges.lattice = Lattice(Box{{0, 0, 0}, {46, 46, 47}}, 1.0);
  std::size_t entries = 0;
  for (int p = 0; p < n; ++p) {
    const Vec3 a = random.point(1, 45);
    points.cells.push_back({points.lattice.cell_of(a)});
    edges.cells.emplace_back();
    edges.lattice.for_each_cell_of_segment(a, a + random.point(-1, 1),
                                           [&](std::int32_t i, std::int32_t j, std::int32_t k) {
                                             edges.cells.back().push_back({i, j, k});
                                             ++entries;
                                           });
  }
  Grid of_points;
  Grid of_edges;
  test::build(of_points, points);
  test::build(of_edges, edges);
  const auto each = [](const Grid& grid) { return static_cast<double>(grid.bytes()) / n; };
  std::printf("%-15s points %6.1f  edges (%.2f cells) %6.1f bytes each\n", name, each(of_points),
              static_cast<double>(entries) / n, each(of_edges));
  EXPECT_GT(each(of_points), 4.0);
  EXPECT_LT(each(of_points), 120.0);
  EXPECT_LT(each(of_edges), 120.0 * static_cast<double>(entries) / n);
}

TEST(BytesPerPrimitive, AreAsDocumented) {
  print_bytes<test::In<UniformGrid, Order::linear>>("uniform linear");
  print_bytes<test::In<UniformGrid, Order::z>>("uniform z");
  print_bytes<test::In<CompactGrid, Order::linear>>("compact linear");
  print_bytes<test::In<CompactGrid, Order::z>>("compact z");
  print_bytes<HashGrid>("hash");
  print_bytes<test::In<CuckooGrid, Order::linear>>("cuckoo");
}

TEST(BoundedMemory, AUniformGridGivesBackWhatWanderersLeftBehind) {
  // 2000 points that go together through 1000 cells would leave 2000 places in each.
  test::In<UniformGrid, Order::linear> grid;
  test::Covered covered;
  covered.lattice = Lattice(Box{{0, 0, 0}, {1000, 1, 1}}, 1.0);
  std::size_t most = 0;
  for (int frame = 0; frame < 1000; ++frame) {
    covered.cells.assign(2000, {{frame, 0, 0}});
    test::build(grid, covered);
    ASSERT_EQ(test::visits(grid, {{frame, 0, 0}, {frame, 0, 0}}).size(), 2000U);
    most = std::max(most, grid.bytes());
  }
  EXPECT_LT(most, std::size_t{65536 + 2 * 2048} * sizeof(Index) + 1000 * 100);
}

}  // namespace
}  // namespace palpate
