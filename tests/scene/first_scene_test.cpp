// The scene around a mesh: where an instrument meets a body from above, and how far a body sags, against
// closed forms.
#include "scene/first_scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <set>
#include <string>
#include <vector>

#include "geometry/vector.hpp"
#include "scene/ball_from_above.hpp"
#include "scene/generators.hpp"
#include "scene/held_parts.hpp"
#include "scene/own_weight.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

TEST(BallFromAbove, TouchesABoxInTheMiddleOfItsTop) {
  const Vec3 place = place_of_touch(test::single_body(make_box({6, 5, 3}, {0.2, 0.1, 0.06})), 0.01);
  EXPECT_NEAR(place.x, 0.0, 1e-12);
  EXPECT_NEAR(place.y, 0.0, 1e-12);
  EXPECT_NEAR(place.z, 0.03 + 0.01, 1e-12);
}

TEST(BallFromAbove, TouchesABallAtItsPole) {
  const Vec3 place = place_of_touch(test::single_body(make_ball(0.05, 6)), 0.02);
  EXPECT_NEAR(std::hypot(place.x, place.y), 0.0, 1e-12);
  EXPECT_NEAR(place.z, 0.05 + 0.02, 1e-12);  // the pole is a point of the mesh
}

TEST(BallFromAbove, TouchesARimAsFarAsItsRadius) {
  // Pythagoras: 3, 4, 5.
  const std::vector<Vec3> samples{{0.3, 0.0, 0.1}, {9.0, 0.0, 7.0}};
  const auto touch = touch_from_above(samples, 0.0, 0.0, 0.5);
  ASSERT_TRUE(touch);
  EXPECT_NEAR(touch->height, 0.1 + 0.4, 1e-12);
  EXPECT_NEAR(touch->beside, 0.3, 1e-12);
  EXPECT_FALSE(touch_from_above(samples, 2.0, 0.0, 0.5));
}

TEST(BallFromAbove, MeetsAFrameWhoseMiddleIsAHole) {
  // A square frame that stands upright, 3 x 3 cells without the middle one: a vertical line through its
  // middle meets the upper bar; one of a frame that lies meets nothing there.
  TetMesh frame = make_box({3, 1, 3}, {0.3, 0.1, 0.3});
  std::erase_if(frame.tets, [&](const Tet& tet) {
    Vec3 sum{};
    for (const Index corner : tet) sum += at(frame.points, corner);
    return std::max(std::abs(sum.x), std::abs(sum.z)) < 4 * 0.05;
  });
  const Vec3 upright = place_of_touch(test::single_body(frame), 0.02);
  EXPECT_NEAR(upright.z, 0.15 + 0.02, 1e-12);
  for (Vec3& point : frame.points) point = {point.x, -point.z, point.y};
  const Vec3 lying = place_of_touch(test::single_body(frame), 0.02);
  const double to_rim = std::max(0.0, 0.05 - std::max(std::abs(lying.x), std::abs(lying.y)));
  EXPECT_LT(to_rim, 0.005) << "not in the hole";
  EXPECT_NEAR(lying.z, 0.05 + std::sqrt(0.02 * 0.02 - to_rim * to_rim), 1e-12) << "on the rim";
}

TEST(OwnWeight, AColumnSagsAsTheClosedFormSays) {
  // A column of height H without lateral strain sags by rho g (H z - z^2 / 2) / E at height z: in the root
  // mean square sqrt(2 / 15) rho g H^2 / E.
  const double height = 0.3;
  const Bodies bodies = test::single_body(make_box({1, 1, 30}, {0.02, 0.02, height}));
  std::vector<std::uint8_t> fixed;
  for (const Vec3& point : bodies.points_rest()) fixed.push_back(point.z < -0.5 * height + 1e-9 ? 1 : 0);
  Material material{.young_modulus = 30e3, .poisson_ratio = 0.0, .density = 900.0};
  const double expected = std::sqrt(2.0 / 15.0) * 900.0 * 9.81 * height * height / 30e3;
  EXPECT_NEAR(sag_under_own_weight(bodies, material, fixed), expected, 0.02 * expected);
  material.young_modulus = 3e6;
  EXPECT_NEAR(sag_under_own_weight(bodies, material, fixed), 0.01 * expected, 2e-4 * expected);
}

/// Two blocks of 0.1 m, one above the other with 0.05 m of air between; one mesh.
TetMesh two_blocks() {
  TetMesh both = make_box({2, 2, 2}, {0.1, 0.1, 0.1});
  TetMesh upper = both;
  const auto count = static_cast<Index>(both.points.size());
  for (const Vec3& point : upper.points) both.points.push_back(point + Vec3{0.0, 0.0, 0.15});
  for (const Tet& tet : upper.tets)
    both.tets.push_back({tet[0] + count, tet[1] + count, tet[2] + count, tet[3] + count});
  return both;
}

TEST(HeldParts, EachPieceIsHeldByItsLowestTenth) {
  const Bodies bodies = test::single_body(two_blocks());
  const HeldParts parts = held_parts(bodies);
  EXPECT_EQ(parts.boxes.size(), 2U);
  for (std::size_t point = 0; point < parts.points.size(); ++point) {
    const double z = bodies.points_rest()[point].z;
    EXPECT_EQ(parts.points[point], z < -0.04 || (0.09 < z && z < 0.11) ? 1 : 0) << z;
  }
}

TEST(FirstScene, OfTwoPiecesIsAsStiffAsOfOne) {
  const FirstScene one = make_first_scene("a", "a.vtu", make_box({2, 2, 2}, {0.1, 0.1, 0.1}), {});
  const FirstScene two = make_first_scene("a", "a.vtu", two_blocks(), {});
  // The same blocks under the same weight; the sag that is allowed goes with the height, 0.25 m to 0.1 m.
  EXPECT_NEAR(two.scene.bodies[0].material->young_modulus,
              std::max(20e3, one.scene.bodies[0].material->young_modulus / 2.5), 300.0);
  EXPECT_EQ(two.scene.bodies[0].fixed.size(), 2U);
}

TEST(FirstScene, BodiesHaveDifferentNames) {
  for (const char* name : {"liver", "floor", "instrument", "ground", "tool"}) {
    for (const bool drop : {false, true}) {
      const FirstScene first =
          make_first_scene(name, "x.vtu", make_box({2, 2, 2}, {0.1, 0.1, 0.1}), {.drop = drop});
      std::set<std::string> names;
      for (const SceneBody& body : first.scene.bodies) names.insert(body.name);
      EXPECT_EQ(names.size(), 3U) << name;
      EXPECT_TRUE(names.contains(name));
    }
  }
}

}  // namespace
}  // namespace palpate
