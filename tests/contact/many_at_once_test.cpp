// What is computed for many crossings, edges or contacts at a time, on every SIMD target, against the same
// one by one: the same bits, or for what only spares work, that nothing is missed.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <limits>
#include <numeric>
#include <vector>

#include "contact/border_edges.hpp"
#include "contact/crossing_parameters.hpp"
#include "contact/edge_exit.hpp"
#include "contact/near_faces.hpp"
#include "contact/nearest_surface.hpp"
#include "contact/surface_normals.hpp"
#include "geometry/predicates.hpp"
#include "geometry/vector.hpp"
#include "simd/face_distances.hpp"
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

TEST(ManyAtOnce, PlanesOfCrossingsAreTheSame) {
  test::Random random(12);
  Bodies bodies;
  bodies.add("box", test::box_mesh({3, 4, 2}, {-1, -1, -1}, {1, 1, 1}));
  bodies.add("ball", test::ball_mesh(6, {3, 0, 0}, 1.0));
  std::vector<Vec3> positions(bodies.points_rest().begin(), bodies.points_rest().end());
  for (Vec3& p : positions) p += random.point(-0.02, 0.02);
  for (const Index p : {3, 4, 5, 30}) at(positions, p) = at(positions, 3);  // triangles without area
  const auto last_point = static_cast<Index>(positions.size()) - 1;
  std::vector<Index> points;
  std::vector<BorderEdge> edges;
  std::vector<Crossing> crossings;
  for (Index i = 0; i < 3001; ++i) {
    // The interpolation does not ask whether the crossing is in the triangle.
    double parameter = random.uniform(0.0, 1.0);
    if (random.chance(0.1)) parameter = random.chance(0.5) ? 0.0 : 1e-16;
    if (random.chance(0.1)) parameter = 1.0;
    points.push_back(random.integer(0, last_point));
    edges.push_back({i, random.integer(0, last_point)});
    crossings.push_back({i, random.integer(0, static_cast<Index>(bodies.triangles().size()) - 1), parameter});
  }
  constexpr double shortest = 0.01;
  SurfaceNormals normals(bodies);
  test::for_each_simd_target([&](const char* target) {
    normals.prepare(parallel::Threads(1), positions, crossings);
    for (const std::size_t n : {std::size_t{0}, std::size_t{1}, std::size_t{63}, crossings.size()}) {
      std::vector<simd::WeightedPlane> planes(n);
      std::vector<simd::Doubtful> doubtful(n);
      const std::size_t count =
          simd::find_planes({points, edges, shortest, EdgeExit::here, 1.0 - link_weight},
                            normals.smooth(positions), std::span(crossings).first(n), planes, doubtful);
      std::vector<int> is_valid(n, 1);
      for (const simd::Doubtful& d : std::span(doubtful).first(count)) is_valid[d.item] = 0;
      EXPECT_LE(std::ranges::count(is_valid, 0), static_cast<std::ptrdiff_t>(n / 2 + 1));
      for (std::size_t e = 0; e < n; ++e) {
        const auto& [border_edge, triangle, parameter] = crossings[e];
        const Vec3& p = at(positions, points[e]);
        const Vec3 edge = at(positions, edges[e].free_point) - p;
        const Vec3 normal = normals.at_point(positions, triangle, p + parameter * edge, SurfaceNormals::far);
        const EdgeExit one(bodies, positions, edge, std::span(crossings).subspan(e, 1), {&normal, 1});
        if (one.at_point || squared_length(edge) < shortest) {
          ASSERT_EQ(is_valid[e], 0) << target;
        }
        if (is_valid[e] == 0) continue;
        const double inverse = 1.0 / squared_length(edge);
        // Sums begin with zero: it makes no difference whether -0 or 0 is added.
        const auto& [depth, x, y, z, weight, inverse_of_plane] = planes[e].sums;
        ASSERT_EQ(bits(weight), bits(inverse * one.weight)) << target << ", " << e;
        ASSERT_EQ(bits(depth + 0.0), bits(inverse * one.depth + 0.0)) << target << ", " << e;
        ASSERT_EQ(bits(Vec3{x, y, z} + Vec3{}), bits(inverse * one.normal + Vec3{})) << target << ", " << e;
        ASSERT_EQ(bits(inverse_of_plane), bits(inverse)) << target << ", " << e;
        ASSERT_EQ(bits(planes[e].distance), bits(one.distance)) << target << ", " << e;
        ASSERT_EQ(planes[e].special, 0.0);
      }
    }
  });
}

/// Points in tets of a ball, with reaches.
struct PointsInABall {
  Bodies bodies;
  std::vector<Vec3> positions;
  std::vector<Vec3> places;
  std::vector<NearFaces::Point> points;

  PointsInABall(int n, std::uint64_t seed) {
    test::Random random(seed);
    bodies.add("ball", test::ball_mesh(6, {0, 0, 0}, 1.0));
    positions.assign(bodies.points_rest().begin(), bodies.points_rest().end());
    for (Vec3& p : positions) p += random.point(-0.02, 0.02);
    for (int i = 0; i < n; ++i) {
      const Index number = random.integer(0, static_cast<Index>(bodies.tets().size()) - 1);
      const Tet& tet = at(bodies.tets(), number);
      std::array<double, 4> w{random.uniform(0.0, 1.0), random.uniform(0.0, 1.0), random.uniform(0.0, 1.0),
                              random.uniform(0.0, 1.0)};
      const double sum = w[0] + w[1] + w[2] + w[3];
      Vec3 x;
      for (std::size_t k = 0; k < 4; ++k) x += (w[k] / sum) * at(positions, tet[k]);
      places.push_back(x);
      points.push_back({number, random.chance(0.2) ? tet[0] : -1, random.uniform(0.0, 0.2)});
    }
  }
};

TEST(ManyAtOnce, DistancesFromFacesAreThoseOfTriangles) {
  const PointsInABall all(500, 13);
  std::vector<simd::PointAndTet> pairs;
  test::Random random(15);
  for (std::uint32_t i = 0; i < all.places.size(); ++i) {  // its own tet, and another
    pairs.push_back({i, all.points[i].tet, 0});
    pairs.push_back({i, random.integer(0, static_cast<Index>(all.bodies.tets().size()) - 1), 0});
  }
  std::vector<std::array<double, 4>> first;
  test::for_each_simd_target([&](const char* target) {
    for (const std::size_t n : {std::size_t{0}, std::size_t{1}, std::size_t{63}, pairs.size()}) {
      std::vector<std::array<double, 4>> squared(n);
      std::vector<std::uint32_t> which(n);
      std::iota(which.rbegin(), which.rend(), 0U);
      simd::find_face_distances(all.positions, all.bodies.tets(), all.places, pairs, which, squared);
      for (std::size_t i = 0; i < n; ++i) {
        const Tet& tet = at(all.bodies.tets(), pairs[i].tet);
        const Vec3& p = all.places[pairs[i].point];
        for (std::size_t k = 0; k < 4; ++k) {
          const auto corner = [&](std::size_t j) { return at(all.positions, tet[(k + j) % 4]); };
          const double distance = length(nearest_on_triangle(p, {corner(1), corner(2), corner(3)}) - p);
          ASSERT_NEAR(std::sqrt(squared[i][k]), distance, 1e-14) << target << ", " << i;
        }
      }
      if (first.size() < n) first = squared;
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t k = 0; k < 4; ++k)
          ASSERT_EQ(bits(squared[i][k]), bits(first[i][k])) << target << ", " << i;
    }
  });
}

TEST(ManyAtOnce, NearFacesAreThoseOfWalksOneByOne) {
  ExitSearch search;
  NearFaces near;
  std::size_t faces = 0;
  std::size_t given_up = 0;
  for (std::uint64_t round = 0; round < 50; ++round) {
    const PointsInABall all(64, 100 + round);
    near.find({all.bodies, all.positions, all.places, all.points, 1e-15});
    std::vector<std::vector<NearFaces::Face>> found(64);
    for (const NearFaces::Face& face : near.found()) found[face.point].push_back(face);
    for (std::uint32_t i = 0; i < 64; ++i) {
      if (near.gave_up(i)) {
        ++given_up;
        continue;
      }
      // The same faces in the same order.
      std::size_t next = 0;
      const auto& [tet, without, reach] = all.points[i];
      search.for_each_face(all.bodies, all.positions, tet, all.places[i], without, reach,
                           [&](Index of, std::size_t opposite, const Vec3& x, double distance) {
                             ASSERT_LT(next, found[i].size()) << round << ", " << i;
                             const NearFaces::Face& face = found[i][next++];
                             ASSERT_EQ(face.triangle, all.bodies.triangle_of_face(of, opposite));
                             ASSERT_EQ(bits(face.distance), bits(distance));
                             ASSERT_EQ(bits(face.x), bits(x));
                           });
      ASSERT_EQ(next, found[i].size()) << round << ", " << i;
      faces += next;
    }
  }
  EXPECT_GT(faces, 2000U);
  EXPECT_GT(given_up, 0U);
  EXPECT_LT(given_up, 1000U);
}

TEST(ManyAtOnce, NearestFacesAreThoseOfSearchesOneByOne) {
  ExitSearch search;
  NearFaces near;
  test::Random random(16);
  std::size_t beyond_reach = 0;
  std::size_t ended_early = 0;
  std::size_t without_face = 0;
  for (std::uint64_t round = 0; round < 50; ++round) {
    const PointsInABall all(64, 200 + round);
    const NearFaces::Frame frame{all.bodies, all.positions, all.places, all.points, 1e-15};
    near.find(frame);
    std::vector<NearFaces::Search> searches;
    for (std::uint32_t i = 0; i < 64; ++i) {
      if (near.gave_up(i) || random.chance(0.3)) continue;
      searches.push_back({i, random.uniform(0.0, 0.3), random.chance(0.3) ? random.uniform(0.0, 0.1) : 0.0});
    }
    near.search(frame, searches);
    for (const auto& [i, bound, enough] : searches) {
      if (near.gave_up(i)) continue;
      const auto& [tet, without, reach] = all.points[i];
      const double one =
          search.nearest(all.bodies, all.positions, tet, all.places[i], without, bound, -1.0).distance;
      // Whatever ends the search, it is no nearer than the nearest face.
      ASSERT_GE(near.nearest(i), one) << round << ", " << i;
      if (one > enough) {
        ASSERT_EQ(bits(near.nearest(i)), bits(one)) << round << ", " << i;
      } else {
        ASSERT_LE(near.nearest(i), std::max(enough, one)) << round << ", " << i;
      }
      beyond_reach += one > reach && one < bound ? 1 : 0;
      ended_early += one <= enough ? 1 : 0;
      without_face += one == bound ? 1 : 0;
    }
  }
  EXPECT_GT(beyond_reach, 100U);
  EXPECT_GT(ended_early, 100U);
  EXPECT_GT(without_face, 100U);
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
