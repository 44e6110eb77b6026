// Edges near triangles in float (near_edges.hpp), on all SIMD targets of this processor. Oracles: the exact
// predicate, and distances of random places of edge and triangle.

#include "contact/near_edges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "contact/cluster_pairs.hpp"
#include "geometry/predicates.hpp"
#include "geometry/triangle.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"
#include "support/simd_targets.hpp"

namespace palpate {
namespace {

/// Two balls, deformed and flattened at random, near each other. Some edges and triangles have no size or
/// hardly any; some points and edges of the second ball are on a triangle of the first, but for rounding.
struct TwoBalls {
  explicit TwoBalls(std::uint64_t seed) : random(seed) {
    bodies.add("first", test::ball_mesh(3, {}, 1.0));
    bodies.add("second", test::ball_mesh(4, {}, 1.0));
    size = std::pow(10.0, random.integer(-9, 9));
    const Vec3 shift = random.chance(0.3) ? (1e3 * size) * random.point(-1, 1) : Vec3{};
    const Vec3 aside = random.uniform(0.0, 2.2) * size * random.point(-1, 1);
    const bool flat = random.chance(0.3);
    positions.assign(bodies.points_rest().begin(), bodies.points_rest().end());
    for (Index p = 0; p < std::ssize(positions); ++p) {
      Vec3& x = at(positions, p);
      x = size * (x + 0.2 * random.point(-1, 1));
      if (flat && random.chance(0.5)) x.z = 0.5 * size;
      if (p > 0 && random.chance(0.1)) {
        const double apart = random.chance(0.5) ? 0.0 : std::pow(10.0, random.integer(-16, -3)) * size;
        x = at(positions, p - 1) + apart * random.point(-1, 1);
      }
      if (p >= bodies.bodies()[0].points.end) x += aside;
      x += shift;
    }
    touch();
    const SurfaceClusters surface(bodies);
    for (const Cluster& cluster : surface.clusters.clusters) {
      Box& box = boxes.emplace_back();
      for (const Index p : surface.clusters.points_of(cluster)) box.extend(at(positions, p));
    }
  }
  void touch() {
    const Range& triangles = bodies.bodies()[0].triangles;
    const auto place = [&](bool on_side) {
      const Index triangle = random.integer(triangles.begin, triangles.end - 1);
      const auto [a, b, c] = corners_of(positions, at(bodies.triangles(), triangle));
      const double u = random.uniform(0.0, 1.0);
      const double v = on_side ? 0.0 : random.uniform(0.0, 1.0 - u);
      return a + u * (b - a) + v * (c - a);
    };
    const Range& edges = bodies.bodies()[1].edges;
    for (Index e = edges.begin; e < edges.end; ++e) {
      const Edge& ends = at(bodies.edges(), e);
      Vec3& x = at(positions, ends[1]);
      if (random.chance(0.1)) x = place(false);
      if (random.chance(0.1)) x = 2.0 * place(true) - at(positions, ends[0]);
    }
  }
  /// Least of some distances of an edge and a triangle.
  double sampled(Index edge, Index triangle) {
    const Edge& e = at(bodies.edges(), edge);
    const Vec3& a = at(positions, e[0]);
    const Vec3& b = at(positions, e[1]);
    const auto [t0, t1, t2] = corners_of(positions, at(bodies.triangles(), triangle));
    double least = std::numeric_limits<double>::infinity();
    for (int sample = 0; sample < 8; ++sample) {
      const double s = random.chance(0.3) ? random.integer(0, 1) : random.uniform(0.0, 1.0);
      const double u = random.uniform(0.0, 1.0);
      const double v = random.uniform(0.0, 1.0 - u);
      least = std::min(least, length((a + s * (b - a)) - (t0 + u * (t1 - t0) + v * (t2 - t0))));
    }
    return least;
  }
  [[nodiscard]] bool meet(Index edge, Index triangle) const {
    const Edge& e = at(bodies.edges(), edge);
    const auto [t0, t1, t2] = corners_of(positions, at(bodies.triangles(), triangle));
    return segment_meets_triangle(at(positions, e[0]), at(positions, e[1]), t0, t1, t2);
  }

  test::Random random;
  Bodies bodies;
  double size = 1.0;
  std::vector<Vec3> positions;
  std::vector<Box> boxes;
};

struct Counts {
  std::size_t met = 0;
  std::size_t surely = 0;    ///< of them said to meet
  std::size_t separate = 0;  ///< near, do not meet
  std::size_t said = 0;      ///< of them said not to meet
  std::size_t far = 0;       ///< of these with a bound above 0.3 of the least sampled distance
};

constexpr double rounding = 1e-9;

/// Checks what the kernel says of pairs: none that meets is said to be apart, and the reverse.
void check_gaps(TwoBalls& balls, const SurfaceFrame& frame, std::span<const NearEdge> list, Counts& counts) {
  WaitingPairs waiting(frame);
  const auto check = [&](std::size_t, const EdgeTriangle& pair, float gap) {
    if (balls.meet(pair.edge, pair.triangle)) {
      ++counts.met;
      counts.surely += gap < 0.0F ? 1 : 0;
      ASSERT_LE(gap, 0.0F) << "edge " << pair.edge << " triangle " << pair.triangle;
      return;
    }
    ++counts.separate;
    ASSERT_GE(gap, 0.0F) << "edge " << pair.edge << " triangle " << pair.triangle;
    if (gap == 0.0F) return;
    ++counts.said;
    const double sampled = balls.sampled(pair.edge, pair.triangle);
    ASSERT_LE(static_cast<double>(gap), sampled * (1.0 + rounding));
    counts.far += static_cast<double>(gap) > 0.3 * sampled ? 1 : 0;
  };
  for (const NearEdge& near : list) {
    if (!waiting.has_room(1)) waiting.test(check);
    waiting.add(near.pair.edge, near.pair.triangle);
  }
  waiting.test(check);
}

/// Checks the list of two clusters: all pairs within the margin are there, none nearer than its bound.
void check_pair(TwoBalls& balls, const SurfaceFrame& frame, FacingClusters& facing, const IndexPair& clusters,
                double margin, Counts& counts) {
  const SurfaceClusters& surface = frame.surface;
  std::vector<NearEdge> list;
  facing.list(clusters.first, clusters.second, margin, list);
  std::map<std::pair<Index, Index>, float> apart;
  for (const NearEdge& near : list)
    ASSERT_TRUE(apart.emplace(std::pair(near.pair.edge, near.pair.triangle), near.apart).second);
  for (const auto& [of_edges, of_triangles] : {clusters, IndexPair(clusters.second, clusters.first)}) {
    for (const Index edge : surface.edges[of_edges]) {
      for (const Index triangle :
           surface.clusters.primitives_of(at(surface.clusters.clusters, of_triangles))) {
        const auto near = apart.find({edge, triangle});
        if (balls.meet(edge, triangle)) {
          // A pair that meets is listed with no distance.
          ASSERT_TRUE(near != apart.end() && near->second == 0.0F)
              << "edge " << edge << " triangle " << triangle;
        } else if (near != apart.end() || balls.random.chance(0.05)) {
          const double sampled = balls.sampled(edge, triangle);
          const double bound = near != apart.end() ? static_cast<double>(near->second) : margin;
          ASSERT_GE(sampled, bound * (1.0 - rounding));
        }
      }
    }
  }
  check_gaps(balls, frame, list, counts);
}

/// \param unit  of lengths in float, in sizes of the balls
void check_two_balls(std::uint64_t seed, double unit, Counts& counts) {
  TwoBalls balls(seed);
  const SurfaceClusters surface(balls.bodies);
  const EdgeBlocks blocks(surface, balls.bodies);
  const double power = std::exp2(std::floor(std::log2(unit * balls.size)));
  const double margin = balls.random.chance(0.5) ? 0.0 : 0.2 * balls.size;
  test::for_each_simd_target([&](const char* target) {
    SCOPED_TRACE(target);
    const SurfaceFrame frame{balls.bodies, surface, blocks, balls.positions, balls.boxes, power};
    FacingClusters facing(frame);
    const Range of_second = surface.of_body[1];
    for (Index a = 0; a < surface.of_body[0].end; ++a)
      for (Index b = of_second.begin; b < of_second.end; ++b)
        check_pair(balls, frame, facing, {a, b}, margin, counts);
  });
}

TEST(NearEdges, NoneThatMeetsIsLeftOutWhereFloatsUnderflow) {
  Counts counts;
  for (const double exponent : {-30.0, 30.0, 64.0, 120.0, 130.0, 145.0, 200.0}) {
    SCOPED_TRACE(exponent);
    for (std::uint64_t seed = 0; seed < 2; ++seed) check_two_balls(seed, std::exp2(exponent), counts);
  }
  EXPECT_GT(counts.met, 300U);
}

TEST(NearEdges, NoneThatMeetsIsLeftOutAndNoneIsSaidToBeFurtherThanItIs) {
  Counts counts;
  for (std::uint64_t seed = 0; seed < 12; ++seed) check_two_balls(seed, 0.4, counts);
  EXPECT_GT(counts.met, 300U);
  EXPECT_GT(counts.surely, counts.met / 2) << "most that meet are told";
  EXPECT_GT(counts.said, counts.separate * 3 / 4) << "most that do not meet are told";
  EXPECT_GT(counts.far, counts.said / 4) << "and by much of how far they are apart";
}

}  // namespace
}  // namespace palpate
