// The clustered query on every SIMD target of this processor and as plain C++, against all pairs: in rational
// arithmetic for small scenes, with the exact predicate for large ones.
#include "contact/cluster_query.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <set>
#include <string>

#include "contact/all_pairs.hpp"
#include "contact/scenes.hpp"
#include "geometry/predicates.hpp"
#include "support/rational.hpp"
#include "support/simd_targets.hpp"

namespace palpate {
namespace {

using test::ContactScene;
using test::InTet;
using test::Pairs;
using test::Random;

struct Case {
  ContactScene scene;
  std::vector<std::uint8_t> self_collision;
  double cell_size = 1.0;
  Order order = Order::linear;
};

struct Answer {
  Pairs in_order_found;
  Pairs pairs;  ///< sorted
  QueryTally tally;
};

Answer ask(const Case& c, const simd::ClusterKernels& kernels, int thread_count) {
  const std::span<const Vec3> positions = c.scene.positions;
  const std::size_t n = positions.size();
  const parallel::Threads threads(thread_count);
  Box bounds;
  for (const Vec3& p : positions) bounds.extend(p);
  const Lattice lattice(bounds, c.cell_size);
  std::vector<std::uint8_t> marks(n);
  for (std::size_t p = 0; p < n; ++p) marks[p] = at(c.scene.immovable, c.scene.bodies.body_of_point()[p]);
  FixedPositions fixed(std::vector<std::uint8_t>(n, 1), marks);
  EXPECT_TRUE(FixedPositions::represents(lattice));
  fixed.place(threads, lattice, positions);
  PointGrid grid(c.order);
  grid.build(threads, lattice, fixed);
  ClusterQuery query(c.scene.bodies, kernels);
  query.find(threads, c.scene.bodies, positions, PairFilter{c.scene.immovable, c.self_collision}, grid,
             fixed);
  Answer answer;
  for (const PointInTet& found : query.found()) answer.in_order_found.emplace_back(found.point, found.tet);
  answer.pairs = answer.in_order_found;
  std::sort(answer.pairs.begin(), answer.pairs.end());
  answer.tally = query.tally();
  return answer;
}

Answer all_pairs(const Case& c, InTet in_tet) {
  const test::AllPairs all =
      test::all_pairs(c.scene.bodies, c.scene.positions, {c.scene.immovable, c.self_collision}, in_tet);
  Answer answer;
  answer.pairs = all.pairs;
  answer.tally.folded_pairs = all.folded;
  return answer;
}

/// Compares all targets, the twin in plain C++ and several threads with all pairs; returns how many there
/// are.
std::size_t check(const Case& c, InTet in_tet, const std::vector<int>& thread_counts) {
  const Answer expected = all_pairs(c, in_tet);
  const Answer twin = ask(c, simd::scalar::cluster_kernels(), 1);
  const auto compare = [&](const Answer& answer, const std::string& name) {
    EXPECT_EQ(answer.pairs, expected.pairs) << name;
    EXPECT_EQ(answer.tally.folded_pairs, expected.tally.folded_pairs) << name;
    EXPECT_EQ(answer.in_order_found, twin.in_order_found) << name << ": in another order";
    EXPECT_EQ(answer.tally.candidates, twin.tally.candidates) << name;
  };
  compare(twin, "plain C++");
  int targets = 0;
  test::for_each_simd_target([&](const char* target) {
    ++targets;
    for (const int threads : thread_counts)
      compare(ask(c, simd::cluster_kernels(), threads), std::string(target) + ", " + std::to_string(threads));
  });
  EXPECT_GT(targets, 0);
  EXPECT_GE(twin.tally.candidates, expected.pairs.size());
  return expected.pairs.size() + expected.tally.folded_pairs;
}

void draw_settings(Case& c, Random& random, double unit) {
  for (std::size_t b = 0; b < c.scene.bodies.bodies().size(); ++b)
    c.self_collision.push_back(random.chance(0.4) ? 1 : 0);
  c.cell_size = unit * std::pow(10.0, random.uniform(-3, 1));
  c.order = random.chance(0.5) ? Order::linear : Order::z;
}

class ClusterQueryScenes : public ::testing::TestWithParam<int> {};

TEST_P(ClusterQueryScenes, FindWhatRationalArithmeticFinds) {
  std::size_t pairs = 0;
  for (std::uint64_t seed = 9000; seed < 9040; ++seed) {
    Random random(seed);
    Case c{test::make_contact_scene(GetParam(), seed), {}};
    draw_settings(c, random, GetParam() == 6 ? 1e-9 : 1.0);
    SCOPED_TRACE("seed " + std::to_string(seed));
    pairs += check(c, test::rational_point_in_tet, {1});
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(pairs, 100U) << "the scenes must have contacts";
}

INSTANTIATE_TEST_SUITE_P(Scenes, ClusterQueryScenes, ::testing::Range(0, test::contact_scene_kinds),
                         [](const auto& p) { return test::identifier(test::contact_scene_name(p.param)); });

class ClusterQueryInTheLarge : public ::testing::TestWithParam<int> {};

TEST_P(ClusterQueryInTheLarge, FindsWhatAllPairsGive) {
  // Cells from so small that blocks have more rows than room, to one for all points, which are more than a
  // block has room for.
  for (const double scale : {1e-3, 0.05, 0.3, 1e4}) {
    Random random(7);
    Case c{test::make_large_scene(GetParam(), 1), {0, 1, 0}};
    c.cell_size = scale;
    c.order = scale == 0.3 ? Order::z : Order::linear;
    SCOPED_TRACE("cell size " + std::to_string(scale));
    EXPECT_GT(check(c, point_in_tet, {1, 3}), 10U);
    ASSERT_FALSE(HasFailure());
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, ClusterQueryInTheLarge, ::testing::Range(0, test::large_scene_kinds),
                         [](const auto& p) { return test::identifier(test::large_scene_name(p.param)); });

/// Points of one soup lie as near as doubles can to faces, edges and corners of a mesh: what the float filter
/// says there must be what its bound allows.
TEST(ClusterQuery, PointsNextToFaces) {
  std::size_t pairs = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Random random(seed);
    Case c;
    const double far = random.chance(0.5) ? 0.0 : std::pow(10.0, random.uniform(0, 4));
    TetMesh box = test::box_mesh({2, 2, 2}, {0, 0, 0}, {1, 1, 1});
    for (Vec3& p : box.points) p += random.point(-0.08, 0.08) + Vec3{far, -far, 0.5 * far};
    const auto near_face = [&] {
      const Tet& tet = box.tets[static_cast<std::size_t>(random.integer(0, 47))];
      std::array<double, 4> weights{};
      double sum = 0.0;
      const int corners = random.integer(1, 3);
      for (int k = 0; k < corners; ++k) sum += weights.at(static_cast<std::size_t>(k)) = random.uniform(0, 1);
      Vec3 x{};
      for (std::size_t k = 0; k < 4; ++k) x += weights.at(k) / sum * at(box.points, tet.at(k));
      return x + std::ldexp(1.0, random.integer(-60, -18)) * random.point(-1, 1);
    };
    TetMesh points = test::soup(100, near_face);
    if (random.chance(0.3)) points.points[0] += random.point(-5000, 5000);  // a large domain: coarse numbers
    c.scene.bodies.add("box", std::move(box));
    c.scene.bodies.add("points", std::move(points));
    const auto rest = c.scene.bodies.points_rest();
    c.scene.positions.assign(rest.begin(), rest.end());
    c.scene.immovable.assign(2, 0);
    c.self_collision.assign(2, 0);
    c.cell_size = std::pow(10.0, random.uniform(-2, 0.5));
    SCOPED_TRACE("seed " + std::to_string(seed));
    pairs += check(c, point_in_tet, {1});
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(pairs, 2000U);
}

TEST(FixedPositions, HaveTheCellsOfTheLattice) {
  Random random(11);
  for (int round = 0; round < 300; ++round) {
    const Vec3 offset = std::pow(10.0, random.uniform(-12, 12)) * random.point(-1, 1);
    const double size = std::pow(10.0, random.uniform(-12, 12));
    std::vector<Vec3> positions(50);
    Box bounds;
    for (Vec3& p : positions) {
      p = offset + size * random.point(-1, 1);
      if (random.chance(0.3)) p = offset + size * random.grid_point(-1, 1, 1.0);
      bounds.extend(p);
    }
    const Lattice lattice(bounds, size * std::pow(10.0, random.uniform(-8, 1)));
    const std::vector<std::uint8_t> all(positions.size(), 1);
    FixedPositions fixed(all, all);
    fixed.place(parallel::Threads(1), lattice, positions);
    for (std::size_t p = 0; p < positions.size(); ++p) {
      ASSERT_EQ(fixed.cell_of(fixed.points()[p]), lattice.cell_of(positions[p])) << round;
      ASSERT_EQ(simd::index_of_name(fixed.points()[p].name), static_cast<Index>(p));
    }
  }
}

}  // namespace
}  // namespace palpate
