// The edge-triangle query with clusters on every SIMD target of this processor, against all pairs with the
// exact predicates (the brute structure, itself checked against rational arithmetic in detector_test.cpp).
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include <palpate/detection.hpp>

#include "contact/scenes.hpp"
#include "geometry/vector.hpp"
#include "support/simd_targets.hpp"

namespace palpate {
namespace {

using test::ContactScene;
using test::Random;

bool same_crossings(const Detector& a, const Detector& b) {
  return std::ranges::equal(a.crossings(), b.crossings(), [](const Crossing& x, const Crossing& y) {
    return x.border_edge == y.border_edge && x.triangle == y.triangle && x.parameter == y.parameter;
  });
}

/// Compares all targets and several threads with all pairs; returns how many crossings there are.
std::size_t check(const ContactScene& scene, DetectionSettings settings) {
  settings.structure = Structure::brute;
  Detector brute(scene.bodies, settings, scene.immovable, 1);
  brute.detect(scene.positions);
  settings.structure = Structure::compact;
  test::for_each_simd_target([&](const char* target) {
    for (const int threads : {1, 3}) {
      Detector detector(scene.bodies, settings, scene.immovable, threads);
      detector.detect(scene.positions);
      EXPECT_TRUE(same_crossings(brute, detector)) << target << ", threads " << threads;
    }
  });
  return brute.crossings().size();
}

DetectionSettings draw_settings(const ContactScene& scene, Random& random, double unit) {
  DetectionSettings settings;
  for (std::size_t b = 0; b < scene.bodies.bodies().size(); ++b)
    settings.self_collision.push_back(random.chance(0.4) ? 1 : 0);
  settings.cell_size = unit * std::pow(10.0, random.uniform(-3, 1));
  settings.order = random.chance(0.5) ? Order::linear : Order::z;
  return settings;
}

class ClusteredCrossingsScenes : public ::testing::TestWithParam<int> {};

TEST_P(ClusteredCrossingsScenes, AreThoseOfAllPairs) {
  std::size_t crossings = 0;
  for (std::uint64_t seed = 7000; seed < 7040; ++seed) {
    Random random(seed);
    const ContactScene scene = test::make_contact_scene(GetParam(), seed);
    SCOPED_TRACE("seed " + std::to_string(seed));
    crossings += check(scene, draw_settings(scene, random, GetParam() == 6 ? 1e-9 : 1.0));
    ASSERT_FALSE(HasFailure());
  }
  // Of bodies in one place every point is in contact, so they have no border edges.
  const bool in_one_place = GetParam() == 2;
  EXPECT_EQ(crossings > 20, !in_one_place) << crossings;
}

INSTANTIATE_TEST_SUITE_P(Scenes, ClusteredCrossingsScenes, ::testing::Range(0, test::contact_scene_kinds),
                         [](const auto& p) { return test::identifier(test::contact_scene_name(p.param)); });

/// Bodies pressed into each other: boxes whose points are moved a little, and whose surfaces partly lie in
/// one plane up to rounding, near the origin and far from it.
TEST(ClusteredCrossings, OfSurfacesThatGraze) {
  std::size_t crossings = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed);
    ContactScene scene;
    const double far = random.chance(0.5) ? 0.0 : std::pow(10.0, random.uniform(0, 4));
    const double noise = random.chance(0.5) ? 0.05 : std::ldexp(1.0, random.integer(-50, -20));
    const Vec3 offset{far, -far, 0.5 * far};
    for (int b = 0; b < 3; ++b) {
      const Vec3 lower = 0.5 * static_cast<double>(b) * Vec3{1.0, 0.0, random.chance(0.5) ? 0.5 : 0.0};
      TetMesh mesh = test::box_mesh({4, 3, 3}, lower + offset, lower + offset + Vec3{1.0, 1.0, 1.0});
      for (Vec3& p : mesh.points) p += noise * random.point(-1, 1);
      scene.bodies.add(std::string("box ").append(std::to_string(b)), std::move(mesh));
    }
    const auto rest = scene.bodies.points_rest();
    scene.positions.assign(rest.begin(), rest.end());
    scene.immovable.assign(3, 0);
    DetectionSettings settings;
    settings.cell_size = std::pow(10.0, random.uniform(-2, 0.5));
    SCOPED_TRACE("seed " + std::to_string(seed));
    crossings += check(scene, settings);
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(crossings, 2000U);
}

/// A few edges are much longer than the others: they go another way, and are found all the same.
TEST(ClusteredCrossings, OfLongAndShortEdges) {
  std::size_t crossings = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    ContactScene scene;
    scene.bodies.add("fine", test::box_mesh({6, 6, 6}, {-1, -1, -1}, {1, 1, 1}));
    scene.bodies.add("fine too", test::box_mesh({6, 6, 6}, {-0.5, -0.6, -0.7}, {1.5, 1.4, 1.3}));
    scene.bodies.add("coarse", test::soup(3, [&] { return random.point(-6, 6); }));
    const auto rest = scene.bodies.points_rest();
    scene.positions.assign(rest.begin(), rest.end());
    for (Vec3& p : scene.positions) p += random.chance(0.02) ? random.point(-5, 5) : Vec3{};
    scene.immovable.assign(3, 0);
    DetectionSettings settings;
    settings.cell_size = 0.3;
    SCOPED_TRACE("seed " + std::to_string(seed));
    crossings += check(scene, settings);
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(crossings, 2000U);
}

}  // namespace
}  // namespace palpate
