// Contacts have the depth, direction and certainty that docs/depth.md defines. Oracle: its formulas
// (depth_formulas.hpp), from all triangles and a dense system in long double.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <gtest/gtest.h>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/depth_formulas.hpp"
#include "geometry/vector.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"
#include "support/real_data.hpp"

namespace palpate {
namespace {

/// Two bodies; their positions are not those at rest.
struct Scene {
  Bodies bodies;
  std::vector<Vec3> positions;

  void move_second(const Vec3& by) {
    const Range points = bodies.bodies()[1].points;
    for (Index p = points.begin; p < points.end; ++p) at(positions, p) += by;
  }
};

Scene scene_of(TetMesh a, TetMesh b) {
  Scene scene;
  scene.bodies.add("a", std::move(a));
  scene.bodies.add("b", std::move(b));
  scene.positions.assign(scene.bodies.points_rest().begin(), scene.bodies.points_rest().end());
  return scene;
}

/// Moves the second body along a direction until it comes to the first, and further by `overlap`.
void bring_together(Scene& scene, Detector& detector, const Vec3& direction, double far, double overlap) {
  const auto touch = [&](double distance) {
    scene.move_second(distance * direction);
    detector.detect(scene.positions);
    scene.move_second(-distance * direction);
    return detector.contacts().size() > 0;
  };
  double apart = far;
  while (apart > -far && !touch(apart)) apart -= 0.03 * far;
  double near = apart;
  apart += 0.03 * far;
  for (int i = 0; i < 14; ++i) {
    const double middle = 0.5 * (near + apart);
    (touch(middle) ? near : apart) = middle;
  }
  scene.move_second((near - overlap) * direction);
  detector.detect(scene.positions);
}

/// Differences of contacts from the formulas.
struct Differences {
  int contacts = 0;
  int raised = 0;          ///< of these, to the distance of the surface
  int disagree = 0;        ///< of these, with normals that differ: the length of the mean is below 0.9
  int uncertain = 0;       ///< of these, with a plane certainty below 0.5
  double depth = 0.0;      ///< the largest, relative to the depth
  double direction = 0.0;  ///< the largest
  double certainty = 0.0;  ///< the largest
};

struct Checked {
  Differences shallow;  ///< in regions of which the deepest contact is less than 0.2 edges deep
  Differences deep;     ///< in others, with a straight exit that leaves the body
  Differences bent;     ///< in others, with a straight exit that ends inside
  test::DepthFormulas::Used used;
};

/// \param are_convex  the bodies: if they are not, exits that are not straight are left out
void check(const Scene& scene, const Detector& detector, Checked& checked, bool are_convex = false) {
  const Contacts& contacts = detector.contacts();
  const test::DepthFormulas formulas(scene.bodies, scene.positions, contacts);
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const auto& expected = formulas.result(c);
    if (!expected.is_defined || (expected.is_bent && !are_convex)) continue;
    Differences& d = expected.deepest <= 0.2 ? checked.shallow
                     : expected.is_bent      ? checked.bent
                                             : checked.deep;
    ++d.contacts;
    d.raised += expected.is_raised ? 1 : 0;
    d.disagree += expected.agreement < 0.9 ? 1 : 0;
    d.uncertain += expected.plane_certainty < 0.5 ? 1 : 0;
    d.depth = std::max(d.depth, std::abs(contacts.depth[c] / expected.depth - 1.0));
    d.direction = std::max(d.direction, length(contacts.direction[c] - expected.direction));
    d.certainty = std::max(d.certainty, std::abs(contacts.certainty[c] - expected.certainty));
  }
  checked.used += formulas.used();
}

/// The library solves its systems iteratively, to 1e-5.
void expect_equal(const Checked& checked) {
  for (const Differences& d : {checked.shallow, checked.deep, checked.bent}) {
    EXPECT_LT(d.depth, 1e-3);
    EXPECT_LT(d.direction, 1e-4);
    EXPECT_LT(d.certainty, 5e-3);
    std::printf(
        "%d contacts, %d raised, %d disagree, %d uncertain; depths differ by %.2g, directions by %.2g, "
        "certainties by %.2g\n",
        d.contacts, d.raised, d.disagree, d.uncertain, d.depth, d.direction, d.certainty);
  }
  std::printf("%d crossings, %d edges with several, %d near triangles, %d links\n", checked.used.crossings,
              checked.used.edges_with_several, checked.used.near_triangles, checked.used.links);
}

Vec3 unit(test::Random& random) {
  return normalized(random.point(-1, 1));
}

/// Stretches and rotates a body.
void deform(Scene& scene, Index body, test::Random& random) {
  const Vec3 axis = unit(random);
  const double angle = random.uniform(0, 3);
  const Vec3 scale = random.point(0.9, 1.1);
  const Range points = at(scene.bodies.bodies(), body).points;
  for (Index i = points.begin; i < points.end; ++i) {
    Vec3& p = at(scene.positions, i);
    p = test::rotated({scale.x * p.x, scale.y * p.y, scale.z * p.z}, axis, angle);
  }
}

TetMesh plate(double low, double high) {
  return test::box_mesh({5, 4, 1}, {-0.05, -0.04, low}, {0.05, 0.04, high});
}

TetMesh ball_or_box(test::Random& random) {
  const int n = random.integer(2, 5);
  if (random.chance(0.1)) return test::joined(plate(-0.006, -0.003), plate(0.0, 0.004));  // edges cross both
  if (random.chance(0.5)) return test::ball_mesh(n, {}, 0.05);
  const Vec3 half{0.05, random.uniform(0.02, 0.05), random.uniform(0.005, 0.05)};
  return test::box_mesh({n, random.integer(1, 4), random.integer(1, 3)}, -1.0 * half, half);
}

/// \param most_overlap  in edges
void check_pair(TetMesh a, TetMesh b, double most_overlap, test::Random& random, Checked& checked) {
  Scene scene = scene_of(std::move(a), std::move(b));
  deform(scene, 0, random);
  deform(scene, 1, random);
  scene.move_second(random.point(-0.02, 0.02));
  Detector detector(scene.bodies, {}, {}, 1);
  const double edge = std::min(mesh_statistics(scene.bodies, scene.positions, 0).edge_length.mean,
                               mesh_statistics(scene.bodies, scene.positions, 1).edge_length.mean);
  bring_together(scene, detector, unit(random), 0.25, random.uniform(0.02, most_overlap) * edge);
  check(scene, detector, checked);
}

TEST(ShallowDepth, OfBallsAndBoxes) {
  test::Random random(1);
  Checked checked;
  for (int i = 0; i < 1000; ++i) check_pair(ball_or_box(random), ball_or_box(random), 0.3, random, checked);
  expect_equal(checked);
  EXPECT_GT(checked.shallow.contacts, 1500);
  EXPECT_GT(checked.shallow.raised, 300);
  EXPECT_GT(checked.shallow.disagree, 100);
  EXPECT_GT(checked.used.edges_with_several, 50);
  EXPECT_GT(checked.used.near_triangles, 400);
}

/// A box on a box, almost flush: regions of many contacts.
TEST(ShallowDepth, OfBoxesThatLieOnEachOther) {
  test::Random random(2);
  Checked checked;
  for (int i = 0; i < 40; ++i) {
    const int n = random.integer(2, 7);
    const int m = random.integer(2, 7);
    Scene scene = scene_of(test::box_mesh({n, n, 2}, {-0.05, -0.05, -0.02}, {0.05, 0.05, 0.0}),
                           test::box_mesh({m, m, 3}, {-0.05, -0.05, 0.0}, {0.05, 0.05, 0.04}));
    const Range points = scene.bodies.bodies()[1].points;
    const double yaw = random.uniform(0, 3);
    const double tilt = random.uniform(0, 0.03);
    const Vec3 by{random.uniform(-0.04, 0.04), random.uniform(-0.04, 0.04), 0.0};
    const Vec3 axis{random.uniform(-1, 1), random.uniform(-1, 1), 0.0};
    for (Index p = points.begin; p < points.end; ++p) {
      Vec3& x = at(scene.positions, p);
      x = test::rotated(test::rotated(x, {0, 0, 1}, yaw), axis, tilt) + by;
    }
    Detector detector(scene.bodies, {}, {}, 1);
    bring_together(scene, detector, {0, 0, 1}, 0.05, random.uniform(0.02, 0.25) * 0.1 / std::max(n, m));
    check(scene, detector, checked);
  }
  expect_equal(checked);
  EXPECT_GT(checked.shallow.contacts, 900);
  EXPECT_GT(checked.used.links, 5000);
}

TEST(ShallowDepth, AndThatOfDeepContacts) {
  test::Random random(3);
  Checked checked;
  for (int i = 0; i < 10; ++i)
    check_pair(test::ball_mesh(random.integer(2, 8), {}, 0.05), test::ball_mesh(8, {}, 0.05), 6.0, random,
               checked);
  // The end of a bar, many layers from the surface: the planes there are not certain.
  for (int i = 0; i < 10; ++i) {
    Scene scene = scene_of(i % 2 == 0 ? test::ball_mesh(4, {-0.1, 0.0, 0.0}, 0.1)
                                      : test::box_mesh({3, 3, 3}, {-0.2, -0.1, -0.1}, {0.0, 0.1, 0.1}),
                           test::box_mesh({24, 2, 2}, {-0.1, -0.005, -0.005}, {0.0, 0.005, 0.005}));
    const Range points = scene.bodies.bodies()[1].points;
    const Vec3 axis = unit(random);
    const double angle = random.uniform(0.05, 0.3);
    const Vec3 by = random.point(-0.03, 0.03);
    for (Index p = points.begin; p < points.end; ++p) {
      Vec3& x = at(scene.positions, p);
      x = test::rotated(x, axis, angle) + Vec3{0.0, by.y, by.z};
    }
    Detector detector(scene.bodies, {}, {}, 1);
    bring_together(scene, detector, {1, 0, 0}, 0.2, random.uniform(0.03, 0.08));
    check(scene, detector, checked, true);
  }
  expect_equal(checked);
  EXPECT_GT(checked.deep.contacts, 1500);
  EXPECT_GT(checked.bent.contacts, 900);
  EXPECT_GT(checked.bent.uncertain, 700);
}

class ShallowDepthOfOrgans : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(test::real_data_folder() / "meshes"))
      GTEST_SKIP() << "no meshes: set PALPATE_TEST_DATA to where they are";
  }
};

TEST_F(ShallowDepthOfOrgans, InRandomPairs) {
  constexpr std::array names{"liver.msh", "liver2.msh", "Ossicles.vtu", "volumetricTongue.vtu"};
  test::Random random(4);
  Checked checked;
  for (int i = 0; i < 40; ++i) {
    const TetMesh a = test::real_mesh(at(names, random.integer(0, 3)), 0.1);
    const TetMesh b =
        random.chance(0.3) ? ball_or_box(random) : test::real_mesh(at(names, random.integer(0, 3)), 0.1);
    check_pair(a, b, 0.3, random, checked);
  }
  expect_equal(checked);
  EXPECT_GT(checked.shallow.contacts, 60);
}

}  // namespace
}  // namespace palpate
