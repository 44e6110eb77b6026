// The search of the tet that contains a position, in a body with a concave corner. Oracle: the exact
// predicate of a point in a tet, for each tet.
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <span>

#include "contact/nearest_surface.hpp"
#include "geometry/predicates.hpp"
#include "geometry/vector.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"

namespace palpate {
namespace {

/// Two cells thick and four wide, less the tets in a part of the square.
template <class IsOut>
Bodies cut_plate(IsOut&& is_out) {
  TetMesh mesh = test::box_mesh({4, 4, 2}, {-1, -1, -0.5}, {1, 1, 0.5});
  std::erase_if(mesh.tets, [&](const Tet& t) {
    Vec3 middle;
    for (const Index corner : t) middle += 0.25 * at(mesh.points, corner);
    return is_out(middle);
  });
  return test::single_body(std::move(mesh));
}

Vec3 in_tet(const Bodies& bodies, Index tet, test::Random& random) {
  std::array<double, 4> weights{};
  double sum = 0.0;
  for (double& w : weights) sum += w = random.uniform(0.01, 1.0);
  Vec3 place;
  for (std::size_t i = 0; i < 4; ++i)
    place += (weights[i] / sum) * at(bodies.points_rest(), at(bodies.tets(), tet)[i]);
  return place;
}

bool contains(const Bodies& bodies, Index tet, const Vec3& x) {
  const Tet& t = at(bodies.tets(), tet);
  const std::span<const Vec3> p = bodies.points_rest();
  return point_in_tet(x, at(p, t[0]), at(p, t[1]), at(p, t[2]), at(p, t[3]));
}

TEST(ExitSearch, FindsTheTetOfAPositionAroundACorner) {
  const Bodies bodies = cut_plate([](const Vec3& m) { return m.x > 0.0 && m.y > 0.0; });
  ExitSearch search;
  test::Random random(7);
  int around = 0;
  for (int i = 0; i < 2000; ++i) {
    const Index from = random.integer(0, static_cast<int>(bodies.tets().size()) - 1);
    const Vec3 p = in_tet(bodies, from, random);
    const Vec3 x = in_tet(bodies, random.integer(0, static_cast<int>(bodies.tets().size()) - 1), random);
    const Index found = search.tet_of(bodies, bodies.points_rest(), from, p, x);
    ASSERT_GE(found, 0) << i;
    ASSERT_TRUE(contains(bodies, found, x)) << i;
    around +=
        exit_ahead(bodies, bodies.points_rest(), from, p, normalized(x - p), length(x - p)).leaves() ? 1 : 0;
  }
  EXPECT_GT(around, 200);
}

TEST(ExitSearch, FindsNoTetBeyondAGap) {
  const Bodies bodies = cut_plate([](const Vec3& m) { return m.x > -0.5 && m.x < 0.5 && m.y > -0.5; });
  ExitSearch search;
  test::Random random(8);
  int tried = 0;
  for (int i = 0; i < 2000; ++i) {
    const Index from = random.integer(0, static_cast<int>(bodies.tets().size()) - 1);
    const Vec3 p = in_tet(bodies, from, random);
    // In the other arm, too far from the bridge for a way within the distance; or in no tet at all.
    const Vec3 x{-p.x, p.y, p.z};
    if (std::abs(p.x) < 0.5 || p.y < 0.75) continue;
    ASSERT_EQ(search.tet_of(bodies, bodies.points_rest(), from, p, {0.0, p.y, p.z}), -1) << i;
    if (std::abs(p.x) > 0.6) continue;
    ASSERT_EQ(search.tet_of(bodies, bodies.points_rest(), from, p, x), -1) << i;
    ++tried;
  }
  EXPECT_GT(tried, 10);
}

}  // namespace
}  // namespace palpate
