// Crossings of closed bodies whose tets do not overlap, on random and degenerate meshes. Oracle: all border
// edges against all triangles in rational arithmetic, and the theorem that each border edge has a crossing.
#include <algorithm>
#include <gtest/gtest.h>
#include <set>
#include <tuple>

#include <palpate/detection.hpp>

#include "geometry/box.hpp"
#include "geometry/vector.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"
#include "support/rational.hpp"

namespace palpate {
namespace {

/// Some tets of a box: closed, perhaps in parts that meet in edges or corners only.
TetMesh part_of(const TetMesh& whole, test::Random& random, double kept) {
  TetMesh part;
  part.points = whole.points;
  for (const Tet& tet : whole.tets) {
    if (random.chance(kept)) part.tets.push_back(tet);
  }
  if (part.tets.empty()) part.tets.push_back(whole.tets.front());
  return part;
}

/// A small mesh of one of several kinds. Coordinates on a grid of quarters make edges end exactly on faces,
/// edges and corners, and run in faces; shaking by a tenth of an edge keeps each tet in its place.
TetMesh make_mesh(int kind, test::Random& random) {
  const Vec3 lower = random.grid_point(-4, 0, 0.25);
  const Vec3 size{random.integer(1, 4) * 0.25, random.integer(1, 4) * 0.25, random.integer(1, 4) * 0.25};
  TetMesh mesh = test::box_mesh({random.integer(1, 2), random.integer(1, 2), 1}, lower, lower + 2.0 * size);
  switch (kind) {
    case 0:
      return mesh;
    case 1:
      return part_of(mesh, random, 0.6);
    case 2:  // sheared by whole numbers: still on the grid
      for (Vec3& p : mesh.points) p = {p.x + p.z, p.y - p.x, p.z};
      return part_of(mesh, random, 0.8);
    case 3:
      for (Vec3& p : mesh.points) p += 0.02 * random.point(-1, 1);
      return part_of(mesh, random, 0.8);
    case 4:  // thin as a leaf
      for (Vec3& p : mesh.points) p.z *= 1e-9;
      return mesh;
    default:
      for (Vec3& p : mesh.points) p = 0.1 * p;  // tenths: neighbours agree only as far as rounding does
      return mesh;
  }
}

constexpr int kinds = 6;

class CrossingsOf : public ::testing::TestWithParam<int> {};

TEST_P(CrossingsOf, ClosedBodiesAreThoseOfRationalArithmeticAndNoBorderEdgeLacksOne) {
  std::size_t border_edges = 0;
  std::size_t at_ends = 0;
  for (std::uint64_t seed = 0; seed < 700; ++seed) {
    test::Random random(1000 * static_cast<std::uint64_t>(GetParam()) + seed);
    Bodies bodies;
    bodies.add("a", make_mesh(GetParam(), random));
    bodies.add("b", make_mesh(random.integer(0, kinds - 1), random));
    const std::span<const Vec3> x = bodies.points_rest();
    Detector detector(bodies, {}, {}, 1);
    detector.detect(x);
    std::set<std::pair<Index, Index>> found;
    for (const Crossing& c : detector.crossings()) found.insert({c.border_edge, c.triangle});
    std::set<std::pair<Index, Index>> expected;
    std::set<Index> crossed;
    for (Index e = 0; e < static_cast<Index>(detector.border_edges().size()); ++e) {
      const BorderEdge& edge = at(detector.border_edges(), e);
      const Index in = at(detector.contacts().point, edge.contact);
      const Range triangles = at(bodies.bodies(), at(detector.contacts().body, edge.contact)).triangles;
      for (Index t = triangles.begin; t < triangles.end; ++t) {
        const Triangle& c = at(bodies.triangles(), t);
        if (!box_of(x, c).overlaps(box_of(x, std::array{in, edge.free_point}))) continue;
        test::Rational parameter;
        if (!test::rational_crossing(at(x, in), at(x, edge.free_point), at(x, c[0]), at(x, c[1]), at(x, c[2]),
                                     parameter))
          continue;
        expected.insert({e, t});
        crossed.insert(e);
        at_ends += parameter == 0 ? 1 : 0;
        ASSERT_NE(parameter, 1) << "the free end is in the closed body";
      }
    }
    ASSERT_EQ(found, expected) << "seed " << seed;
    ASSERT_EQ(crossed.size(), detector.border_edges().size()) << "seed " << seed;
    ASSERT_EQ(detector.counts().border_edges_without_crossing, 0U) << "seed " << seed;
    border_edges += crossed.size();
  }
  EXPECT_GT(border_edges, 1000U);
  EXPECT_TRUE(at_ends > 100 || GetParam() >= 3) << "edges that start exactly on the surface";
}

INSTANTIATE_TEST_SUITE_P(Kinds, CrossingsOf, ::testing::Range(0, kinds));

}  // namespace
}  // namespace palpate
