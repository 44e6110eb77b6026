// What is computed for many crossings, edges or contacts at a time, on every SIMD target, against the same
// one by one: the same bits, or for what only spares work, that nothing is missed.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "contact/border_edges.hpp"
#include "contact/crossing_parameters.hpp"
#include "contact/edge_exit.hpp"
#include "contact/nearest_surface.hpp"
#include "geometry/predicates.hpp"
#include "geometry/vector.hpp"
#include "simd/faces_within_reach.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"
#include "support/simd_targets.hpp"

namespace palpate {
namespace {

std::uint64_t bits(double x) {
  return std::bit_cast<std::uint64_t>(x);
}
std::array<std::uint64_t, 3> bits(const Vec3& v) {
  return {bits(v.x), bits(v.y), bits(v.z)};
}

/// Segments that meet surface triangles of a ball, as a detector would know them: contact e, its edge e, and
/// the triangle of each.
struct Segments {
  Bodies bodies;
  std::vector<Vec3> positions;
  Contacts contacts;
  std::vector<BorderEdge> border_edges;
  std::vector<EdgeInTriangle> found;

  /// So many tries; flat triangles, ends in the plane and at corners, and coordinates far from the origin are
  /// among them.
  explicit Segments(int tries) {
    test::Random random(11);
    bodies.add("ball", test::ball_mesh(4, {0, 0, 0}, 1.0));
    TetMesh ends;
    for (int t = 0; t < tries; ++t) {
      ends.points.insert(ends.points.end(), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
      ends.tets.push_back({4 * t, 4 * t + 1, 4 * t + 2, 4 * t + 3});
    }
    bodies.add("ends", ends);
    positions.assign(bodies.points_rest().begin(), bodies.points_rest().end());
    for (Index p = 0; p < bodies.bodies()[0].points.end; ++p)
      if (random.chance(0.3)) at(positions, p) = random.grid_point(-2, 2, 0.5);
    for (Vec3& p : positions) p += Vec3{1e3, 0, 0};
    const Index first = bodies.bodies()[1].points.begin;
    for (int t = 0; t < tries; ++t) {
      const auto triangle = random.integer(0, bodies.bodies()[0].triangles.end - 1);
      const auto& [i, j, k] = at(bodies.triangles(), triangle);
      const Vec3 middle = (1.0 / 3.0) * (at(positions, i) + at(positions, j) + at(positions, k));
      Vec3& a = at(positions, first + 4 * t);
      Vec3& b = at(positions, first + 4 * t + 1);
      const double length = std::ldexp(1.0, random.integer(-40, 1));
      a = middle + length * random.point(-1, 1);
      b = middle + (random.chance(0.5) ? 1.0 : 1e-7) * (middle - a);
      if (random.chance(0.1)) a = middle;
      if (random.chance(0.1)) b = at(positions, i);
      if (!segment_meets_triangle(a, b, at(positions, i), at(positions, j), at(positions, k))) continue;
      found.push_back({triangle, static_cast<Index>(border_edges.size())});
      border_edges.push_back({static_cast<Index>(contacts.point.size()), first + 4 * t + 1});
      contacts.point.push_back(first + 4 * t);
    }
  }
};

TEST(ManyAtOnce, CrossingParametersAreTheSame) {
  const Segments s(4000);
  ASSERT_GT(s.found.size(), 1000U);
  test::for_each_simd_target([&](const char* target) {
    for (const std::size_t n : {std::size_t{0}, std::size_t{1}, std::size_t{65}, s.found.size()}) {
      std::vector<Crossing> crossings(n);
      find_parameters(parallel::Threads(2), s.bodies, s.positions, {s.contacts, s.border_edges},
                      std::span(s.found).first(n), crossings);
      for (std::size_t c = 0; c < n; ++c) {
        const BorderEdge& edge = at(s.border_edges, s.found[c].border_edge);
        const auto& [i, j, k] = at(s.bodies.triangles(), s.found[c].triangle);
        const double one = crossing_parameter(at(s.positions, at(s.contacts.point, edge.contact)),
                                              at(s.positions, edge.free_point), at(s.positions, i),
                                              at(s.positions, j), at(s.positions, k));
        ASSERT_EQ(crossings[c].border_edge, s.found[c].border_edge);
        ASSERT_EQ(crossings[c].triangle, s.found[c].triangle);
        ASSERT_EQ(bits(crossings[c].parameter), bits(one)) << target << ", " << c << " of " << n;
      }
    }
  });
}

TEST(ManyAtOnce, ExitsOfEdgesAreTheSame) {
  test::Random random(12);
  Bodies bodies;
  bodies.add("box", test::box_mesh({3, 4, 2}, {-1, -1, -1}, {1, 1, 1}));
  bodies.add("ball", test::ball_mesh(6, {3, 0, 0}, 1.0));
  std::vector<Vec3> positions(bodies.points_rest().begin(), bodies.points_rest().end());
  for (Vec3& p : positions) p += random.point(-0.02, 0.02);
  for (const Index p : {3, 4, 5, 30}) at(positions, p) = at(positions, 3);  // triangles without area
  SurfaceNormals normals(bodies);
  normals.update(parallel::Threads(1), bodies, positions, std::vector<std::uint8_t>{1, 1});
  const auto last_point = static_cast<Index>(positions.size()) - 1;
  std::vector<CrossedEdge> edges;
  for (int i = 0; i < 3001; ++i) {
    // The interpolation does not ask whether the crossing is in the triangle.
    double parameter = random.uniform(0.0, 1.0);
    if (random.chance(0.1)) parameter = random.chance(0.5) ? 0.0 : 1e-16;
    if (random.chance(0.1)) parameter = 1.0;
    edges.push_back({random.integer(0, last_point), random.integer(0, last_point),
                     random.integer(0, static_cast<Index>(bodies.triangles().size()) - 1), parameter});
  }
  test::for_each_simd_target([&](const char* target) {
    for (const std::size_t n : {std::size_t{0}, std::size_t{1}, std::size_t{63}, edges.size()}) {
      std::vector<EdgeExit> exits(n);
      find_exits(bodies, positions, normals, std::span(edges).first(n), exits);
      for (std::size_t e = 0; e < n; ++e) {
        const auto& [point, free_point, triangle, parameter] = edges[e];
        const Vec3 edge = at(positions, free_point) - at(positions, point);
        const Vec3 x = at(positions, point) + parameter * edge;
        const EdgeExit one(edge, {0, triangle, parameter}, normals.at_point(bodies, positions, triangle, x));
        // Sums begin with zero: it makes no difference whether -0 or 0 is added.
        ASSERT_EQ(bits(exits[e].weight), bits(one.weight)) << target << ", " << e;
        ASSERT_EQ(bits(exits[e].depth + 0.0), bits(one.depth + 0.0)) << target << ", " << e;
        ASSERT_EQ(bits(exits[e].normal + Vec3{}), bits(one.normal + Vec3{})) << target << ", " << e;
        ASSERT_EQ(bits(exits[e].nearest), bits(one.nearest)) << target << ", " << e;
        ASSERT_EQ(bits(exits[e].distance), bits(one.distance)) << target << ", " << e;
        ASSERT_EQ(exits[e].at_point, one.at_point) << target << ", " << e;
      }
    }
  });
}

TEST(ManyAtOnce, FacesOutOfReachAreNotFoundByAWalk) {
  test::Random random(13);
  Bodies bodies;
  bodies.add("ball", test::ball_mesh(6, {0, 0, 0}, 1.0));
  std::vector<Vec3> positions(bodies.points_rest().begin(), bodies.points_rest().end());
  for (Vec3& p : positions) p += random.point(-0.02, 0.02);
  for (const Index p : {3, 4, 5, 30}) at(positions, p) = at(positions, 3);
  at(positions, 17) = {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
  ExitSearch search;
  test::for_each_simd_target([&](const char* target) {
    std::array<std::size_t, 2> counts{};
    for (int round = 0; round < 200; ++round) {
      simd::ReachingPoints points;
      std::array<Index, simd::ReachingPoints::most> tets;
      std::array<Vec3, simd::ReachingPoints::most> places;
      const auto n = static_cast<std::size_t>(random.integer(1, 64));
      for (std::size_t i = 0; i < n; ++i) {
        tets[i] = random.integer(0, static_cast<Index>(bodies.tets().size()) - 1);
        const Tet& tet = at(bodies.tets(), tets[i]);
        std::array<double, 4> w{random.uniform(0.0, 1.0), random.uniform(0.0, 1.0), random.uniform(0.0, 1.0),
                                random.uniform(0.0, 1.0)};
        const double sum = w[0] + w[1] + w[2] + w[3];
        places[i] = {};
        for (std::size_t k = 0; k < 4; ++k) {
          places[i] += (w[k] / sum) * at(positions, tet[k]);
          points.corner[k].put(at(positions, tet[k]), i);
        }
        points.point.put(places[i], i);
        points.reach[i] = random.uniform(0.0, 0.1);
        if (random.chance(0.05)) points.reach[i] = std::numeric_limits<double>::infinity();
      }
      simd::find_faces_within_reach(points, n);
      for (std::size_t i = 0; i < n; ++i) {
        // All planes far enough in plain double arithmetic, of faces counter-clockwise from outside.
        constexpr int faces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
        const Tet& tet = at(bodies.tets(), tets[i]);
        bool all_beyond = true;
        for (const auto& face : faces) {
          const Vec3& a = at(positions, at(tet, face[0]));
          const Vec3 normal = cross(at(positions, at(tet, face[1])) - a, at(positions, at(tet, face[2])) - a);
          const double height = dot(a - places[i], normal);
          all_beyond = all_beyond && normal != Vec3{} &&
                       height * height >= points.reach[i] * points.reach[i] * squared_length(normal);
        }
        ASSERT_EQ(points.meets[i], all_beyond ? 0.0 : 1.0) << target;
        ++counts[all_beyond ? 0 : 1];
        if (!all_beyond) continue;
        search.for_each_face(bodies, positions, tets[i], places[i], -1, points.reach[i],
                             [&](Index, std::size_t, const Vec3&, double) { ADD_FAILURE() << target; });
      }
    }
    EXPECT_GT(counts[0], 500U);
    EXPECT_GT(counts[1], 500U);
  });
}

TEST(BorderEdges, PartTheEdgesOfPointsInContact) {
  test::Random random(14);
  Bodies bodies;
  bodies.add("a", test::box_mesh({4, 4, 3}, {0, 0, 0}, {1, 1, 1}));
  bodies.add("b", test::box_mesh({5, 4, 4}, {0.4, 0.3, 0.5}, {1.5, 1.4, 1.3}));
  bodies.add("c", test::ball_mesh(5, {0.8, 0.8, 0.8}, 0.45));
  std::vector<Vec3> positions(bodies.points_rest().begin(), bodies.points_rest().end());
  for (Vec3& p : positions) p += random.point(-0.01, 0.01);
  Detector detector(bodies, {}, {}, 1);
  detector.detect(positions);
  const Contacts& found = detector.contacts();
  std::vector<PointInTet> pairs;
  for (std::size_t c = 0; c < found.size(); ++c) pairs.push_back({found.point[c], found.tet[c]});
  for (const int threads : {1, 2}) {
    ContactTable table;
    table.assign(parallel::Threads(threads), bodies, positions, pairs);
    BorderEdges edges(bodies);
    edges.find(parallel::Threads(threads), bodies, positions, table);
    std::size_t border = 0;
    std::size_t links = 0;
    for (std::size_t c = 0; c < found.size(); ++c) {
      Index link = edges.ranges_of_links()[c].begin;
      for (const Index edge : bodies.point_edges()[found.point[c]]) {
        const Index other = bodies.other_end(edge, found.point[c]);
        Index neighbor = -1;  // by looking through all
        for (std::size_t d = 0; d < found.size(); ++d)
          if (found.point[d] == other && found.body[d] == found.body[c]) neighbor = static_cast<Index>(d);
        if (neighbor >= 0) {
          ASSERT_LT(link, edges.ranges_of_links()[c].end);
          ASSERT_EQ(at(edges.links(), link++), neighbor);
          ++links;
        } else {
          ASSERT_LT(border, edges.edges().size());
          ASSERT_EQ(edges.edges()[border].contact, static_cast<Index>(c));
          ASSERT_EQ(edges.edges()[border++].free_point, other);
        }
      }
      ASSERT_EQ(link, edges.ranges_of_links()[c].end);
    }
    ASSERT_EQ(border, edges.edges().size());
    EXPECT_GT(border, 100U);
    EXPECT_GT(links, 100U);
  }
}

}  // namespace
}  // namespace palpate
