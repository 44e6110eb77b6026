// Guarantees of clusters (each tet in one cluster, and limits) for boxes, balls, random tets and slivers.
#include "mesh/clusters.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <set>
#include <vector>

#include "geometry/box.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

double longest_side(const Box& box) {
  const Vec3 d = box.upper - box.lower;
  return std::max({d.x, d.y, d.z});
}

Bodies many_bodies(std::uint64_t seed) {
  test::Random random(seed);
  Bodies bodies;
  bodies.add("one tet", test::soup(1, [&] { return random.point(-1, 1); }));
  bodies.add("box", test::box_mesh({7, 5, 3}, {0, 0, 0}, {7, 5, 1}));
  bodies.add("strip", test::box_mesh({60, 1, 1}, {0, 0, 0}, {60, 1, 1}));
  bodies.add("ball", test::ball_mesh(4, {1, 2, 3}, 0.5));
  bodies.add("soup", test::soup(100, [&] { return random.point(-1, 1); }));
  bodies.add("grid soup", test::soup(100, [&] { return random.grid_point(-2, 2, 1.0); }));
  double size = 1.0;
  Vec3 centre;
  int corner = 0;
  bodies.add("far apart", test::soup(50, [&] {
               if (corner++ % 4 == 0) {
                 size = random.uniform(0.001, 1.0);
                 centre = random.point(-100, 100);
               }
               return centre + size * random.point(-1, 1);
             }));
  return bodies;
}

/// \param primitives  all tets or triangles; `range_of(body)` those of a body
template <class Primitive, class RangeOf>
void check_clusters(const Bodies& bodies, std::span<const Primitive> primitives, const Clusters& all,
                    RangeOf&& range_of) {
  std::vector<int> seen(primitives.size(), 0);
  for (const Cluster& cluster : all.clusters) {
    ASSERT_GE(cluster.size, 1);
    ASSERT_LE(cluster.size, Cluster::most_primitives);
    ASSERT_LE(cluster.points, Cluster::most_points);
    const auto members = all.primitives_of(cluster);
    const auto points = all.points_of(cluster);
    EXPECT_TRUE(std::is_sorted(members.begin(), members.end()));
    EXPECT_EQ(std::set<Index>(points.begin(), points.end()).size(), points.size()) << "each point once";
    Box box;
    double largest = 0.0;
    std::set<Index> used;
    for (std::size_t lane = 0; lane < Cluster::most_primitives; ++lane) {
      const Index t = members[lane < members.size() ? lane : 0];
      const Primitive& primitive = at(primitives, t);
      for (std::size_t c = 0; c < 4; ++c)
        ASSERT_EQ(points[cluster.corners[c][lane]], primitive[std::min(c, primitive.size() - 1)]);
      if (lane >= members.size()) continue;
      ++at(seen, t);
      EXPECT_TRUE(range_of(at(bodies.bodies(), cluster.body)).contains(t));
      used.insert(primitive.begin(), primitive.end());
      for (std::size_t i = 0; i < points.size(); ++i) {
        const bool is_corner = std::find(primitive.begin(), primitive.end(), points[i]) != primitive.end();
        const unsigned at_point = all.at_point[static_cast<std::size_t>(cluster.first_point) + i];
        EXPECT_EQ((at_point >> lane & 1U) != 0, is_corner);
        EXPECT_EQ(at_point >> members.size(), 0U);
      }
      const Box of_one = box_of(bodies.points_rest(), primitive);
      box.extend(of_one);
      largest = std::max(largest, longest_side(of_one));
    }
    EXPECT_EQ(used, std::set<Index>(points.begin(), points.end())) << "no point that none uses";
    EXPECT_LE(longest_side(box), most_cluster_extent * largest);
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(seen.size()));
}

TEST(Clusters, EachTetAndTriangleIsInOneOfItsBodyAndLimitsHold) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Bodies bodies = many_bodies(seed);
    check_clusters(bodies, bodies.tets(), make_tet_clusters(bodies),
                   [](const Body& body) { return body.tets; });
    check_clusters(bodies, bodies.triangles(), make_triangle_clusters(bodies),
                   [](const Body& body) { return body.triangles; });
  }
}

TEST(Clusters, FillUpWhereTetsLieTogether) {
  Bodies bodies;
  bodies.add("box", test::box_mesh({20, 20, 10}, {0, 0, 0}, {2, 2, 1}));  // 24000 tets
  const Clusters all = make_tet_clusters(bodies);
  EXPECT_EQ(all.clusters.size(), 1500U);
}

TEST(Clusters, SpanNoGapBetweenPartsButPutSmallPartsTogether) {
  // Layers so close that splitting by position alone puts them into one cluster, and single tets.
  TetMesh mesh;
  std::vector<int> layer_of_tet;
  const auto append = [&](const TetMesh& part, int layer) {
    const auto first = static_cast<Index>(mesh.points.size());
    mesh.points.insert(mesh.points.end(), part.points.begin(), part.points.end());
    for (Tet tet : part.tets) {
      for (Index& corner : tet) corner += first;
      mesh.tets.push_back(tet);
      layer_of_tet.push_back(layer);
    }
  };
  constexpr int layers = 4;
  for (int layer = 0; layer < layers; ++layer) {
    const double z = 0.11 * layer;
    append(test::box_mesh({10, 10, 1}, {0, 0, z}, {1, 1, z + 0.1}), layer);
  }
  test::Random random(5);
  const Vec3 corner{2, 2, 2};
  append(test::soup(64, [&] { return corner + random.point(-0.1, 0.1); }), layers);
  Bodies bodies;
  bodies.add("all", std::move(mesh));
  const Clusters all = make_tet_clusters(bodies);
  std::size_t of_soup = 0;
  for (const Cluster& cluster : all.clusters) {
    const auto tets = all.primitives_of(cluster);
    const int layer = at(layer_of_tet, tets.front());
    of_soup += layer == layers ? 1 : 0;
    for (const Index tet : tets) EXPECT_EQ(at(layer_of_tet, tet), layer);
  }
  EXPECT_LE(of_soup, 16U) << "8 tets of a soup have 32 points";
}

TEST(Clusters, AreTheSameForTheSameBodies) {
  const Clusters a = make_tet_clusters(many_bodies(3));
  const Clusters b = make_tet_clusters(many_bodies(3));
  EXPECT_EQ(a.primitives, b.primitives);
  EXPECT_EQ(a.points, b.points);
}

}  // namespace
}  // namespace palpate
