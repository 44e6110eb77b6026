// Edges near triangles in float (near_edges.hpp), on all SIMD targets of this processor. Oracles: the exact
// predicate, and distances of random places of edge and triangle.

#include "contact/near_edges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

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
  std::size_t separate = 0;  ///< near, do not meet
  std::size_t said = 0;      ///< of them not touching
  std::size_t entries = 0;   ///< near, none touching
  std::size_t far = 0;       ///< entries whose bound is above 0.3 of the least sampled distance
};

void check_pair(TwoBalls& balls, const SurfaceClusters& surface, FacingClusters& facing, Index first,
                Index second, double margin, Counts& counts) {
  constexpr double rounding = 1e-9;
  facing.face(first, second);
  for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
    const Index of_edges = side == 0 ? first : second;
    const auto triangles =
        surface.clusters.primitives_of(at(surface.clusters.clusters, side == 0 ? second : first));
    const Index begin = at(surface.edges.begin, of_edges);
    const auto size = static_cast<std::size_t>(at(surface.edges.begin, of_edges + 1) - begin);
    std::vector<NearEdge> list;
    facing.list(margin, list);
    std::vector<NearEdge> by_place(size, NearEdge{});
    for (const NearEdge& near : list) {
      if (near.side != side) continue;
      ASSERT_LT(near.place, size);
      by_place[near.place] = near;
    }
    for (std::size_t place = 0; place < size; ++place) {
      const Index edge = at(surface.edges.values, begin + static_cast<Index>(place));
      NearEdge near = by_place[place];
      const auto check = [&] {
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t t = 0; t < triangles.size(); ++t) {
          const bool is_near = (near.near >> t & 1) != 0;
          const bool touches = (near.touching >> t & 1) != 0;
          if (balls.meet(edge, triangles[t])) {
            ++counts.met;
            ASSERT_TRUE(is_near && touches) << "edge " << edge << " triangle " << triangles[t];
          } else if (is_near) {
            ++counts.separate;
            counts.said += touches ? 0 : 1;
          }
          if (!is_near && !balls.random.chance(0.05)) continue;
          const double sampled = balls.sampled(edge, triangles[t]);
          if (is_near) least = std::min(least, sampled);
          ASSERT_TRUE(is_near || sampled >= margin * (1.0 - rounding));
        }
        if (near.near == 0) return;
        counts.entries += near.touching == 0 ? 1 : 0;
        ASSERT_LE(static_cast<double>(near.apart), least * (1.0 + rounding));
        counts.far += static_cast<double>(near.apart) > 0.3 * least ? 1 : 0;
      };
      check();
      if (near.near == 0) continue;
      const std::uint16_t all = near.near;
      facing.test_again(near);
      facing.finish();
      ASSERT_EQ(near.near, all);
      check();
    }
  }
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
    const FacingClusters::Frame frame{surface, blocks, balls.positions, balls.boxes, power};
    FacingClusters facing(frame);
    const Range of_second = surface.of_body[1];
    for (Index a = 0; a < surface.of_body[0].end; ++a)
      for (Index b = of_second.begin; b < of_second.end; ++b)
        check_pair(balls, surface, facing, a, b, margin, counts);
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
  EXPECT_GT(counts.said, counts.separate * 3 / 4) << "most that do not meet are told";
  EXPECT_GT(counts.far, counts.entries / 3) << "and by much of how far they are apart";
}

}  // namespace
}  // namespace palpate
