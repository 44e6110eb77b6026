// Frames of piles in motion: two bodies have a contact exactly where their surfaces intersect or one is
// inside the other. Oracle: rational arithmetic, edge by edge and triangle by triangle.
#include <gtest/gtest.h>
#include <set>
#include <span>
#include <utility>

#include "geometry/box.hpp"
#include "sim/random_scenes.hpp"
#include "support/rational.hpp"

namespace palpate {
namespace {

using Pair = std::pair<Index, Index>;

Pair pair_of(Index a, Index b) {
  return {std::min(a, b), std::max(a, b)};
}

/// Pairs of bodies with a contact of a point or of an edge.
std::set<Pair> pairs_in_contact(const Simulation& simulation) {
  const Bodies& bodies = simulation.bodies();
  std::set<Pair> pairs;
  const Contacts& points = simulation.detector().contacts();
  for (std::size_t c = 0; c < points.size(); ++c)
    pairs.insert(pair_of(at(bodies.body_of_point(), points.point[c]), points.body[c]));
  const EdgeContacts& edges = simulation.detector().edge_contacts();
  for (std::size_t c = 0; c < edges.size(); ++c)
    pairs.insert(pair_of(bodies.body_of(at(bodies.edges(), edges.edge[c])), edges.body[c]));
  return pairs;
}

/// Whether an edge of a triangle of `a` meets a triangle of `b`, or a point of `a` is in a tet of `b`.
bool reaches(const Bodies& bodies, std::span<const Vec3> x, const Body& a, const Body& b) {
  for (Index s = a.triangles.begin; s < a.triangles.end; ++s) {
    const Triangle& own = at(bodies.triangles(), s);
    for (Index t = b.triangles.begin; t < b.triangles.end; ++t) {
      const Triangle& other = at(bodies.triangles(), t);
      if (!box_of(x, own).overlaps(box_of(x, other))) continue;
      for (std::size_t i = 0; i < 3; ++i) {
        test::Rational parameter;
        if (test::rational_crossing(at(x, own[i]), at(x, own[(i + 1) % 3]), at(x, other[0]), at(x, other[1]),
                                    at(x, other[2]), parameter))
          return true;
      }
    }
  }
  // Surfaces do not meet: all points of `a` are inside, or all are outside.
  const Vec3& p = at(x, a.points.begin);
  for (Index t = b.tets.begin; t < b.tets.end; ++t) {
    const Tet& tet = at(bodies.tets(), t);
    if (test::rational_point_in_tet(p, at(x, tet[0]), at(x, tet[1]), at(x, tet[2]), at(x, tet[3])))
      return true;
  }
  return false;
}

std::set<Pair> pairs_that_meet(const Bodies& bodies, std::span<const Vec3> x) {
  std::set<Pair> pairs;
  const auto box_of_body = [&](Index body) {
    const Range points = at(bodies.bodies(), body).points;
    Box box;
    for (Index p = points.begin; p < points.end; ++p) box.extend(at(x, p));
    return box;
  };
  for (Index a = 0; a < bodies.body_count(); ++a) {
    for (Index b = a + 1; b < bodies.body_count(); ++b) {
      if (!box_of_body(a).overlaps(box_of_body(b))) continue;
      const Body& first = at(bodies.bodies(), a);
      const Body& second = at(bodies.bodies(), b);
      if (reaches(bodies, x, first, second) || reaches(bodies, x, second, first)) pairs.insert({a, b});
    }
  }
  return pairs;
}

TEST(EdgeContactsOfPiles, AreThereWhereverSurfacesIntersectInAnyFrame) {
  constexpr int most_steps = 80;
  std::size_t met = 0;
  std::size_t frames_without_points = 0;
  for (const std::uint64_t seed : {1, 2, 3, 5, 8, 13}) {
    test::RandomScene scene(seed);
    Simulation simulation(std::move(scene.model), scene.settings, 1);
    for (int step = 0; step < most_steps; ++step) {
      simulation.step();
      const std::set<Pair> expected = pairs_that_meet(simulation.bodies(), simulation.positions());
      ASSERT_EQ(pairs_in_contact(simulation), expected) << "seed " << seed << ", step " << step;
      met += expected.size();
      if (!expected.empty() && simulation.detector().contacts().size() == 0) ++frames_without_points;
    }
  }
  EXPECT_GT(met, 300U);
  EXPECT_GT(frames_without_points, 0U) << "some frame whose only contacts are of edges";
}

}  // namespace
}  // namespace palpate
