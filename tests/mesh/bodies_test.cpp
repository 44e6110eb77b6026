// Oracles: hand-counted small meshes; Euler's formula; each face, edge and neighbour looked up by brute
// force.
#include <algorithm>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <set>

#include <palpate/error.hpp>
#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

TetMesh two_tets() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}, {{0, 1, 2, 3}, {1, 2, 3, 4}}};
}

std::string message_of(TetMesh mesh) {
  try {
    check_mesh(mesh, "m");
  } catch (const Error& e) {
    return e.what();
  }
  return "accepted";
}

TEST(CheckMesh, TurnsInvertedTetsAround) {
  TetMesh mesh = two_tets();
  std::swap(mesh.tets[0][0], mesh.tets[0][1]);
  const MeshNotes notes = check_mesh(mesh, "m");
  EXPECT_EQ(notes.reoriented_tets, 1);
  EXPECT_EQ(notes.unreferenced_points, 0);
  for (const Tet& t : mesh.tets)
    EXPECT_EQ(
        orient3d(at(mesh.points, t[0]), at(mesh.points, t[1]), at(mesh.points, t[2]), at(mesh.points, t[3])),
        1);
}

TEST(CheckMesh, CountsUnreferencedPoints) {
  TetMesh mesh = two_tets();
  mesh.points.push_back({9, 9, 9});
  EXPECT_EQ(check_mesh(mesh, "m").unreferenced_points, 1);
}

TEST(CheckMesh, RefusesWithIndexFoundAndExpected) {
  TetMesh mesh = two_tets();
  mesh.tets[1][2] = 5;
  EXPECT_EQ(message_of(mesh), "m: tet 1: found point index 5, expected 0 to 4");
  mesh.tets[1][2] = -1;
  EXPECT_EQ(message_of(mesh), "m: tet 1: found point index -1, expected 0 to 4");
  mesh.tets[1][2] = 1;
  EXPECT_EQ(message_of(mesh),
            "m: tet 1: found point 1 twice in (1, 2, 1, 4), expected four different points");
  mesh = two_tets();
  mesh.points[4] = {1, 0, 0};
  mesh.points[4].y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message_of(mesh), "m: point 4: found coordinates (1, nan, 0), expected finite numbers");
  mesh.points[4] = {0.5, 0.25, 0.25};
  EXPECT_EQ(
      message_of(mesh),
      "m: tet 1: found zero volume, points (1, 2, 3, 4), expected four points that are not in one plane");
  mesh = two_tets();
  for (Vec3& point : mesh.points) point = {1e-151 * point.x, 1e-151 * point.y, 1e-151 * point.z};
  EXPECT_EQ(message_of(mesh),
            "m: tets: found a size of at most 1e-151, expected 1e-150 or more of the largest one");
  EXPECT_EQ(message_of({}), "m: found no points, expected at least 4 points");
  EXPECT_EQ(message_of({{{0, 0, 0}}, {}}), "m: found no tets, expected at least one tet");
}

TEST(CheckMesh, LeavesARefusedMeshAsItWas) {
  TetMesh mesh = two_tets();
  std::swap(mesh.tets[0][0], mesh.tets[0][1]);
  mesh.tets[1][0] = 7;
  const TetMesh before = mesh;
  EXPECT_THROW(check_mesh(mesh, "m"), Error);
  EXPECT_EQ(mesh.tets, before.tets);
}

TEST(Bodies, TwoTetsByHand) {
  Bodies bodies;
  EXPECT_EQ(bodies.add("pair", two_tets()), 0);
  EXPECT_EQ(bodies.edges().size(), 9U);
  EXPECT_EQ(bodies.triangles().size(), 6U);
  EXPECT_EQ(bodies.tet_neighbors()[0], (std::array<Index, 4>{1, -1, -1, -1}));
  EXPECT_EQ(bodies.tet_neighbors()[1], (std::array<Index, 4>{-1, -1, -1, 0}));
}

TEST(Bodies, RefusesAFaceOfThreeTets) {
  TetMesh mesh = two_tets();
  mesh.points.push_back({2, 2, 2});
  mesh.tets.push_back({1, 2, 3, 5});
  Bodies bodies;
  bodies.add("first", two_tets());
  try {
    bodies.add("fan", mesh);
    FAIL();
  } catch (const Error& e) {
    EXPECT_STREQ(
        e.what(),
        "fan: tet 2: found a face that tets 0 and 1 have already, expected at most two tets on a face");
  }
  EXPECT_EQ(bodies.body_count(), 1);
  EXPECT_EQ(bodies.points_rest().size(), 5U);
  EXPECT_EQ(bodies.tets().size(), 2U);
}

TEST(Bodies, RefusesTetsOnTheSameSideOfAFace) {
  const auto message = [](TetMesh mesh) -> std::string {
    try {
      Bodies().add("m", std::move(mesh));
    } catch (const Error& e) {
      return e.what();
    }
    return "accepted";
  };
  TetMesh twice = two_tets();
  twice.tets[1] = twice.tets[0];
  EXPECT_EQ(message(twice),
            "m: tet 1: found the same side of a face as tet 0: they overlap, expected tets on both sides of "
            "a face");
  TetMesh folded = two_tets();
  folded.points[4] = {0.1, 0.1, 0.2};  // now on the side of corner 0
  EXPECT_NE(message(folded), "accepted");
  EXPECT_EQ(message(two_tets()), "accepted");
}

/// A box and a ball as two bodies: everything checked against brute force over the tets.
class BoxAndBall : public ::testing::Test {
 protected:
  BoxAndBall() {
    bodies.add("box", test::box_mesh({3, 2, 4}, {0, 0, 0}, {3, 2, 4}));
    bodies.add("ball", test::ball_mesh(4, {10, 0, 0}, 1.5));
  }
  Bodies bodies;
};

TEST_F(BoxAndBall, RangesTileTheArrays) {
  const Body& box = bodies.bodies()[0];
  const Body& ball = bodies.bodies()[1];
  EXPECT_EQ(box.points.size(), 4 * 3 * 5);
  EXPECT_EQ(box.tets.size(), 6 * 24);
  EXPECT_EQ(box.triangles.size(), 2 * 2 * (3 * 2 + 3 * 4 + 2 * 4));
  EXPECT_EQ(ball.points.begin, box.points.end);
  EXPECT_EQ(ball.points.end, static_cast<Index>(bodies.points_rest().size()));
  EXPECT_EQ(ball.edges.end, static_cast<Index>(bodies.edges().size()));
  EXPECT_EQ(ball.triangles.end, static_cast<Index>(bodies.triangles().size()));
  EXPECT_EQ(ball.tets.end, static_cast<Index>(bodies.tets().size()));
  for (const Tet& t : bodies.tets().subspan(static_cast<std::size_t>(ball.tets.begin))) {
    for (const Index corner : t) EXPECT_EQ(at(bodies.body_of_point(), corner), 1);
  }
}

TEST_F(BoxAndBall, EulersFormulaHolds) {
  for (const Body& b : bodies.bodies()) {
    const Index faces = (4 * b.tets.size() + b.triangles.size()) / 2;
    EXPECT_EQ(b.points.size() - b.edges.size() + faces - b.tets.size(), 1)
        << b.name << ": a solid ball has 1";
  }
}

TEST_F(BoxAndBall, EdgesAndRowsAreThoseOfTheTets) {
  std::set<Edge> expected;
  std::map<Index, std::set<Index>> tets_at;
  for (std::size_t t = 0; t < bodies.tets().size(); ++t) {
    for (const Index a : bodies.tets()[t]) {
      tets_at[a].insert(static_cast<Index>(t));
      for (const Index b : bodies.tets()[t]) {
        if (a < b) expected.insert({a, b});
      }
    }
  }
  EXPECT_EQ(std::set<Edge>(bodies.edges().begin(), bodies.edges().end()), expected);
  EXPECT_EQ(bodies.edges().size(), expected.size());
  for (Index p = 0; p < static_cast<Index>(bodies.points_rest().size()); ++p) {
    const auto tets = bodies.point_tets()[p];
    EXPECT_EQ(std::set<Index>(tets.begin(), tets.end()), tets_at[p]);
    EXPECT_EQ(tets.size(), tets_at[p].size());
    std::size_t edges = 0;
    for (const Edge& e : expected) edges += e[0] == p || e[1] == p ? 1 : 0;
    EXPECT_EQ(bodies.point_edges()[p].size(), edges);
    for (const Index e : bodies.point_edges()[p]) {
      const Edge& edge = at(bodies.edges(), e);
      EXPECT_TRUE(edge[0] == p || edge[1] == p);
      EXPECT_EQ(bodies.other_end(e, p), edge[0] == p ? edge[1] : edge[0]);
    }
  }
}

TEST_F(BoxAndBall, SurfaceIsClosedAndPointsOutward) {
  // Closed: each directed side once, its reverse once. Outward: the divergence theorem gives the volume of
  // the tets.
  std::map<Edge, int> sides;
  std::array<double, 2> volume{};
  for (const Triangle& t : bodies.triangles()) {
    for (std::size_t i = 0; i < 3; ++i) ++sides[{t[i], t[(i + 1) % 3]}];
    const auto x = bodies.points_rest();
    at(volume, bodies.body_of(t)) += dot(at(x, t[0]), cross(at(x, t[1]), at(x, t[2]))) / 6.0;
  }
  for (const auto& [side, count] : sides) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ((sides.count({side[1], side[0]})), 1U);
  }
  EXPECT_NEAR(volume[0], 24.0, 1e-12);
  EXPECT_NEAR(volume[1], mesh_statistics(bodies, bodies.points_rest(), 1).volume, 1e-9);
}

TEST_F(BoxAndBall, NeighborsShareTheFace) {
  for (std::size_t t = 0; t < bodies.tets().size(); ++t) {
    for (std::size_t i = 0; i < 4; ++i) {
      const Index n = bodies.tet_neighbors()[t][i];
      if (n < 0) continue;
      const Tet& other = at(bodies.tets(), n);
      for (std::size_t j = 0; j < 4; ++j) {
        const int expected = j == i ? 0 : 1;
        EXPECT_EQ(std::count(other.begin(), other.end(), bodies.tets()[t][j]), expected);
      }
      const auto& back = at(bodies.tet_neighbors(), n);
      EXPECT_EQ(std::count(back.begin(), back.end(), static_cast<Index>(t)), 1);
    }
  }
}

/// Two tets that share an edge alone: four triangles meet there.
TEST_F(BoxAndBall, TrianglesAreConnectedAtTheirEdges) {
  bodies.add("hinge", {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}, {0, 0, -1}},
                       {{0, 1, 2, 3}, {1, 0, 4, 5}}});
  std::map<Edge, std::vector<Index>> triangles_at;
  for (std::size_t t = 0; t < bodies.triangles().size(); ++t) {
    const Triangle& corners = bodies.triangles()[t];
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(corners[(i + 1) % 3], corners[(i + 2) % 3]);
      triangles_at[{low, high}].push_back(static_cast<Index>(t));
      EXPECT_EQ(at(bodies.edges(), bodies.triangle_edges()[t][i]), (Edge{low, high}));
    }
  }
  int at_the_hinge = 0;
  for (std::size_t e = 0; e < bodies.edges().size(); ++e) {
    const std::vector<Index>& there = triangles_at[bodies.edges()[e]];
    const auto& [first, second] = bodies.edge_triangles()[e];
    EXPECT_EQ(first, there.empty() ? -1 : there[0]);
    EXPECT_EQ(second, there.empty() ? -1 : there[1]);
    for (const Index t : there) {
      const auto& edges = at(bodies.triangle_edges(), t);
      const auto side = std::find(edges.begin(), edges.end(), static_cast<Index>(e)) - edges.begin();
      const Index across = at(at(bodies.triangle_neighbors(), t), side);
      EXPECT_EQ(across, there.size() > 2 ? -1 : there[0] == t ? there[1] : there[0]);
      at_the_hinge += across < 0 ? 1 : 0;
    }
  }
  EXPECT_EQ(at_the_hinge, 4);
  for (Index t = 0; t < static_cast<Index>(bodies.tets().size()); ++t) {
    for (std::size_t i = 0; i < 4; ++i) {
      if (at(bodies.tet_neighbors(), t)[i] >= 0) continue;
      const Index triangle = bodies.triangle_of_face(t, i);
      EXPECT_EQ(at(bodies.triangle_tets(), triangle), t);
      const Triangle& corners = at(bodies.triangles(), triangle);
      EXPECT_EQ(std::count(corners.begin(), corners.end(), at(bodies.tets(), t)[i]), 0);
    }
  }
}

TEST(MeshStatistics, OfARegularTet) {
  Bodies bodies;
  bodies.add("regular", {{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}, {{0, 1, 2, 3}}});
  const MeshStatistics s = mesh_statistics(bodies, bodies.points_rest());
  EXPECT_NEAR(s.edge_length.min, std::sqrt(8.0), 1e-15);
  EXPECT_NEAR(s.edge_length.max, std::sqrt(8.0), 1e-15);
  EXPECT_NEAR(s.dihedral_angle.min, 70.528779365509, 1e-9);
  EXPECT_NEAR(s.dihedral_angle.max, 70.528779365509, 1e-9);
  EXPECT_NEAR(s.volume, 8.0 / 3.0, 1e-14);
  EXPECT_EQ(s.lower, (Vec3{-1, -1, -1}));
  EXPECT_EQ(s.upper, (Vec3{1, 1, 1}));
}

}  // namespace
}  // namespace palpate
