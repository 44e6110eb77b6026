// Oracles: analytic depths of boxes, balls and planes.
#include "contact/depth.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include <palpate/detection.hpp>

#include "contact/border_edges.hpp"
#include "contact/crossings_of.hpp"
#include "contact/nearest_surface.hpp"
#include "geometry/vector.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"

namespace palpate {
namespace {

TEST(Depth, IsExactForFlatOnFlat) {
  // The lower box is wider: every border edge of the upper one leaves through the flat top.
  for (const double overlap : {0.25, 0.01, 1e-6}) {
    Bodies bodies;
    bodies.add("lower", test::box_mesh({6, 6, 2}, {-3, -3, -2}, {3, 3, 0}));
    bodies.add("upper", test::box_mesh({3, 3, 2}, {-1.01, -0.97, -overlap}, {1.03, 1.02, 2 - overlap}));
    Detector detector(bodies, {});
    detector.detect(bodies.points_rest());
    const Contacts& contacts = detector.contacts();
    std::size_t bottom = 0;
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      if (at(bodies.body_of_point(), contacts.point[c]) != 1) continue;
      ++bottom;
      EXPECT_NEAR(contacts.depth[c], overlap, 1e-15);
      EXPECT_NEAR(contacts.direction[c].z, 1.0, 1e-15);
    }
    EXPECT_EQ(bottom, 16U);
    EXPECT_EQ(detector.counts().depth_fallbacks, 0U);
  }
}

TEST(Depth, PropagatesExactlyThroughLayers) {
  // Three layers of points of the upper box are inside: their depths are those of the flat surface.
  Bodies bodies;
  bodies.add("lower", test::box_mesh({6, 6, 2}, {-30, -29, -40}, {33, 28, 0}));
  bodies.add("upper", test::box_mesh({3, 3, 8}, {-1.01, -0.97, -2.5}, {1.03, 1.02, 5.5}));
  Detector detector(bodies, {});
  detector.detect(bodies.points_rest());
  const Contacts& contacts = detector.contacts();
  ASSERT_EQ(contacts.size(), 3U * 16U);
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    EXPECT_NEAR(contacts.depth[c], -at(bodies.points_rest(), contacts.point[c]).z, 1e-13);
    EXPECT_NEAR(contacts.direction[c].z, 1.0, 1e-14);
  }
}

/// Two oblique boxes that overlap, with all lengths multiplied by a factor.
Contacts contacts_in_unit(double factor, double offset) {
  Bodies bodies;
  for (int b = 0; b < 2; ++b) {
    TetMesh mesh = test::box_mesh({4, 5, 3}, {-1, -1, -1}, {1, 1, 1});
    for (Vec3& p : mesh.points) {
      const Vec3 oblique{p.x + 0.3 * b * p.y, p.y - 0.2 * b * p.z, p.z + 0.1 * p.x};
      p = factor * (oblique + b * Vec3{offset, 0.9 * offset, 1.1 * offset});
    }
    bodies.add("box", std::move(mesh));
  }
  Detector detector(bodies, {});
  detector.detect(bodies.points_rest());
  return detector.contacts();
}

// Factors of two are exact, so all results must be the same in every bit.
TEST(Depth, DoesNotDependOnTheUnitOfLength) {
  for (const double offset : {0.1, 0.4, 0.7, 1.0}) {
    const Contacts meters = contacts_in_unit(1.0, offset);
    ASSERT_GT(meters.size(), 5U);
    for (const int exponent : {-20, 10, 20}) {
      const double factor = std::ldexp(1.0, exponent);
      const Contacts other = contacts_in_unit(factor, offset);
      ASSERT_EQ(other.point, meters.point);
      EXPECT_EQ(other.direction, meters.direction) << "2^" << exponent;
      EXPECT_EQ(other.certainty, meters.certainty) << "2^" << exponent;
      for (std::size_t c = 0; c < meters.size(); ++c) ASSERT_EQ(other.depth[c], factor * meters.depth[c]);
    }
  }
}

/// Largest relative error of depth and angle of a ball's points in a half-space, over points deeper than a
/// tenth.
double ball_in_plane_error(int cells) {
  Bodies bodies;
  bodies.add("plane", test::box_mesh({4, 4, 1}, {-8, -8, -4}, {8, 8, 0}));
  bodies.add("ball", test::ball_mesh(cells, {0.013, -0.017, 0.6}, 1.0));
  Detector detector(bodies, {});
  detector.detect(bodies.points_rest());
  const Contacts& contacts = detector.contacts();
  double worst = 0.0;
  std::size_t checked = 0;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (contacts.body[c] != 0) continue;
    const double expected = -at(bodies.points_rest(), contacts.point[c]).z;
    worst = std::max(worst, std::abs(contacts.depth[c] - expected));
    ++checked;
  }
  EXPECT_GT(checked, 3U);
  return worst;
}

TEST(Depth, OfABallInAPlaneIsExactBecauseThePlaneIsFlat) {
  EXPECT_LT(ball_in_plane_error(8), 1e-14);
}

/// A flat-bottomed box pressed into a ball: the surface is curved, so the estimate has an error that must
/// fall with h.
double box_in_ball_error(int cells) {
  Bodies bodies;
  bodies.add("ball", test::ball_mesh(cells, {0, 0, 0}, 1.0));
  bodies.add("box", test::box_mesh({cells, cells, 2 * cells}, {-0.21, -0.19, 0.9}, {0.2, 0.22, 2.9}));
  Detector detector(bodies, {});
  detector.detect(bodies.points_rest());
  const Contacts& contacts = detector.contacts();
  double worst = 0.0;
  std::size_t checked = 0;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (contacts.body[c] != 0) continue;
    const Vec3& p = at(bodies.points_rest(), contacts.point[c]);
    worst = std::max(worst, std::abs(contacts.depth[c] - (1.0 - length(p))));
    ++checked;
  }
  EXPECT_GT(checked, 3U);
  return worst;
}

TEST(Depth, ConvergesWithRefinementOnACurvedSurface) {
  const double coarse = box_in_ball_error(4);
  const double middle = box_in_ball_error(8);
  const double fine = box_in_ball_error(16);
  EXPECT_LT(middle, 0.6 * coarse);
  EXPECT_LT(fine, 0.6 * middle);
  EXPECT_LT(fine, 0.01) << "a tenth of the overlap";
}

TEST(Depth, OfASwallowedBodyIsTheDistanceToTheSurface) {
  Bodies bodies;
  bodies.add("big", test::box_mesh({4, 4, 4}, {-2, -2, -2}, {2, 2, 2}));
  bodies.add("small", test::box_mesh({1, 1, 1}, {1.1, -0.1, -0.1}, {1.3, 0.1, 0.1}));
  Detector detector(bodies, {});
  detector.detect(bodies.points_rest());
  const Contacts& contacts = detector.contacts();
  ASSERT_EQ(contacts.size(), 8U);
  EXPECT_EQ(detector.counts().depth_fallbacks, 8U);
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    EXPECT_NEAR(contacts.depth[c], 2.0 - at(bodies.points_rest(), contacts.point[c]).x, 1e-14);
    EXPECT_NEAR(contacts.direction[c].x, 1.0, 1e-14);
  }
}

TEST(Depth, OfADeepPointIsFinite) {
  // A long needle of many layers: its tip is far from any border edge, and nearest to the top all the same.
  Bodies bodies;
  bodies.add("big", test::box_mesh({2, 2, 2}, {-31, -32, -40}, {30, 29, 0}));
  bodies.add("needle", test::box_mesh({1, 1, 40}, {-0.1, -0.12, -19.5}, {0.11, 0.1, 20.5}));
  Detector detector(bodies, {});
  detector.detect(bodies.points_rest());
  const Contacts& contacts = detector.contacts();
  ASSERT_EQ(contacts.size(), 4U * 20U);
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    EXPECT_NEAR(contacts.depth[c], -at(bodies.points_rest(), contacts.point[c]).z, 1e-12);
  }
}

TEST(Depth, OfAPointExactlyOnTheSurfaceIsZero) {
  Bodies bodies;
  bodies.add("lower", test::box_mesh({4, 4, 1}, {-2, -2, -1}, {2, 2, 0}));
  bodies.add("upper", test::box_mesh({2, 2, 1}, {-1, -1, 0}, {1, 1, 1}));
  Detector detector(bodies, {});
  detector.detect(bodies.points_rest());
  const Contacts& contacts = detector.contacts();
  std::size_t upper = 0;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    EXPECT_EQ(contacts.depth[c], 0.0);
    if (contacts.body[c] != 0)
      continue;  // points of the lower box lie on corners of the upper: no one normal
    ++upper;
    EXPECT_NEAR(contacts.direction[c].z, 1.0, 1e-14);
  }
  EXPECT_EQ(upper, 9U);
}

TEST(Depth, WeighsCrossingsByTheInverseSquareOfTheirDistance) {
  // The corner of one cube is in another: of the corner's edges three leave it, through x = 1, y = 1 and z =
  // 1, at 0.7, 0.7 and 0.1 of their length 1. Weights by hand: 1 / t^2 - 0.9, so 99.1 and twice 1.1408.
  const auto cube = [](const Vec3& lower) {
    TetMesh mesh;
    for (int corner = 0; corner < 8; ++corner) {
      mesh.points.push_back({lower.x + (corner & 1), lower.y + ((corner >> 1) & 1), lower.z + (corner >> 2)});
    }
    mesh.tets = {{0, 1, 2, 4}, {3, 2, 1, 7}, {5, 4, 7, 1}, {6, 7, 4, 2}, {1, 2, 4, 7}};
    return mesh;
  };
  Bodies bodies;
  bodies.add("lower", cube({0, 0, 0}));
  bodies.add("upper", cube({0.3, 0.3, 0.9}));
  Detector detector(bodies, {});
  detector.detect(bodies.points_rest());
  const Contacts& contacts = detector.contacts();
  const auto corner = std::find(contacts.point.begin(), contacts.point.end(), 8) - contacts.point.begin();
  ASSERT_LT(corner, static_cast<std::ptrdiff_t>(contacts.size()));
  const double near = 1.0 / 0.01 - 0.9;
  const double far = 1.0 / 0.49 - 0.9;
  EXPECT_NEAR(at(contacts.depth, corner), (near * 0.1 + 2.0 * far * 0.7) / (near + 2.0 * far), 1e-12);
  const Vec3 direction = normalized(Vec3{far, far, near});
  EXPECT_NEAR(length(at(contacts.direction, corner) - direction), 0.0, 1e-12);
}

TEST(BorderEdges, OfClosedBodiesAllCross) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    test::Random random(seed);
    Bodies bodies;
    // Grid-aligned boxes every other time: edges in faces, points on faces, edges and corners.
    const bool aligned = seed % 2 == 0;
    const Vec3 shift = aligned ? random.grid_point(-4, 4, 0.25) : random.point(-1, 1);
    bodies.add("box", test::box_mesh({3, 3, 3}, {-1, -1, -1}, {1, 1, 1}));
    if (aligned)
      bodies.add("other", test::box_mesh({2, 2, 2}, shift, shift + Vec3{1, 1, 1}));
    else
      bodies.add("ball", test::ball_mesh(4, shift, 0.8));
    Detector detector(bodies, {});
    detector.detect(bodies.points_rest());
    std::vector<int> crossed(detector.border_edges().size(), 0);
    for (const Crossing& c : detector.crossings()) at(crossed, c.border_edge) = 1;
    EXPECT_EQ(std::count(crossed.begin(), crossed.end(), 0), 0) << "seed " << seed;
  }
}

TEST(Depth, IsNeverLessThanTheDistanceToTheSurface) {
  // Oracle: the nearest of all surface triangles, by their planes and sides.
  std::size_t checked = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    test::Random random(seed);
    Bodies bodies;
    bodies.add("ball", test::ball_mesh(6, {0, 0, 0}, 1.0));
    bodies.add("bar", test::box_mesh({2, 2, 9}, random.point(-0.6, -0.1), random.point(0.1, 0.9)));
    Detector detector(bodies, {});
    detector.detect(bodies.points_rest());
    const Contacts& contacts = detector.contacts();
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      const double nearest = nearest_surface_point(bodies, bodies.points_rest(), contacts.body[c],
                                                   at(bodies.points_rest(), contacts.point[c]))
                                 .distance;
      EXPECT_GE(contacts.depth[c], nearest * (1.0 - 1e-6)) << "seed " << seed << " contact " << c;
      checked += nearest > 0.05 ? 1 : 0;
    }
  }
  EXPECT_GT(checked, 500U);
}

/// The contacts that a detector finds, with depths as they are when the deadline passes before they are
/// refined.
Contacts with_rough_depths(const Bodies& bodies, DepthCounts& counts) {
  const std::span<const Vec3> positions = bodies.points_rest();
  Detector detector(bodies, {});
  detector.detect(positions);
  std::vector<PointInTet> found;
  for (std::size_t c = 0; c < detector.contacts().size(); ++c)
    found.push_back({detector.contacts().point[c], detector.contacts().tet[c]});
  const parallel::Threads threads(1);
  ContactTable table;
  table.assign(threads, bodies, positions, found);
  BorderEdges border_edges(bodies);
  border_edges.find(threads, bodies, positions, table);
  const Crossings crossings = test::crossings_of(bodies, positions, table, border_edges);
  counts = DepthEstimate(bodies).compute(threads, bodies, positions, table, border_edges, crossings, {},
                                         Deadline(Deadline::Clock::now()));
  return table.contacts();
}

TEST(Depth, WithoutTimeToRefineItIsExactWhereTheSurfaceIsFlat) {
  Bodies bodies;
  bodies.add("lower", test::box_mesh({6, 6, 2}, {-30, -29, -40}, {33, 28, 0}));
  bodies.add("upper", test::box_mesh({3, 3, 8}, {-1.01, -0.97, -2.5}, {1.03, 1.02, 5.5}));
  DepthCounts counts;
  const Contacts contacts = with_rough_depths(bodies, counts);
  ASSERT_EQ(contacts.size(), 3U * 16U);
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    EXPECT_NEAR(contacts.depth[c], -at(bodies.points_rest(), contacts.point[c]).z, 1e-13);
    EXPECT_NEAR(contacts.direction[c].z, 1.0, 1e-14);
  }
  EXPECT_EQ(counts.rough_depths, contacts.size());
}

TEST(Depth, WithoutTimeToRefineItPointsOut) {
  // Balls that overlap by a tenth: out is away from the other's centre, and no point is deeper than the
  // overlap.
  Bodies bodies;
  bodies.add("left", test::ball_mesh(9, {0, 0, 0}, 0.05));
  bodies.add("right", test::ball_mesh(9, {0.09, 0.001, 0.002}, 0.05));
  const std::array<Vec3, 2> centers{Vec3{0, 0, 0}, Vec3{0.09, 0.001, 0.002}};
  DepthCounts counts;
  const Contacts contacts = with_rough_depths(bodies, counts);
  ASSERT_GT(contacts.size(), 20U);
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Vec3 out = at(bodies.points_rest(), contacts.point[c]) - at(centers, contacts.body[c]);
    EXPECT_GT(dot(contacts.direction[c], normalized(out)), 0.7);
    EXPECT_NEAR(length(contacts.direction[c]), 1.0, 1e-12);
    EXPECT_GE(contacts.depth[c], 0.0);
    EXPECT_LT(contacts.depth[c], 0.0125);
  }
  EXPECT_EQ(counts.rough_depths, contacts.size());
}

TEST(Depth, OfOpposedSurfacesIsTheDistanceToTheNearest) {
  // A thin plate goes all through the middle of a wide slab: half of its border edges leave above, half
  // below.
  Bodies bodies;
  bodies.add("slab", test::box_mesh({8, 8, 1}, {-4, -4, -0.3}, {4, 4, 0.3}));
  bodies.add("plate", test::box_mesh({2, 1, 8}, {-0.5, -0.05, -2}, {0.5, 0.05, 2}));
  Detector detector(bodies, {});
  detector.detect(bodies.points_rest());
  const Contacts& contacts = detector.contacts();
  std::size_t middle = 0;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Vec3& p = at(bodies.points_rest(), contacts.point[c]);
    if (contacts.body[c] != 0 || std::abs(p.z) > 1e-12) continue;
    ++middle;
    EXPECT_NEAR(contacts.depth[c], 0.3, 1e-9);
    EXPECT_NEAR(length(contacts.direction[c]), 1.0, 1e-12);
    EXPECT_LT(contacts.certainty[c], 0.7) << "it can leave either way";
  }
  EXPECT_EQ(middle, 6U);
}

}  // namespace
}  // namespace palpate
