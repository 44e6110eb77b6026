#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "geometry/vector.hpp"
#include "io/picture_camera.hpp"
#include "results/support.hpp"

namespace palpate::test {
namespace {

using io::Camera;
using io::ScreenPoint;

void expect_near(const Vec3& found, const Vec3& expected) {
  EXPECT_NEAR(length(found - expected), 0.0, 1e-12);
}

TEST(Camera, LooksAtTheTargetWithZUp) {
  const Camera camera = io::aim_camera({3, 0, 0}, {0, 0, 0}, 200, 100);
  const ScreenPoint target = camera.project({0, 0, 0});
  EXPECT_NEAR(target.x, 100.0, 1e-9);
  EXPECT_NEAR(target.y, 50.0, 1e-9);
  EXPECT_NEAR(target.depth, 3.0, 1e-12);
  EXPECT_LT(camera.project({0, 0, 0.1}).y, 50.0);   // up is up
  EXPECT_GT(camera.project({0, 0.1, 0}).x, 100.0);  // from +x, +y is to the right
  expect_near(camera.direction(100, 50), {-1, 0, 0});
}

TEST(Camera, LooksStraightDown) {
  const Camera camera = io::aim_camera({0, 0, 5}, {0, 0, 0}, 100, 100);
  EXPECT_GT(camera.project({1, 0, 0}).x, 50.0);
  EXPECT_LT(camera.project({0, 1, 0}).y, 50.0);
}

TEST(Camera, DirectionAndProjectionAreInverse) {
  const Camera camera = io::aim_camera({1, 2, 3}, {-1, 0.5, 0}, 640, 480);
  const ScreenPoint place = camera.project(camera.position + 7.0 * camera.direction(123.25, 400.5));
  EXPECT_NEAR(place.x, 123.25, 1e-9);
  EXPECT_NEAR(place.y, 400.5, 1e-9);
}

/// All points inside the frame, and the frame filled from side to side in one direction, up to 6 % of its
/// shorter side.
void expect_tight(const std::vector<Vec3>& points, int width, int height) {
  const Camera camera = io::fit_camera(points, width, height);
  double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
  for (const Vec3& point : points) {
    const ScreenPoint place = camera.project(point);
    EXPECT_GT(place.depth, 0.0);
    left = std::min(left, place.x);
    right = std::max(right, place.x);
    top = std::min(top, place.y);
    bottom = std::max(bottom, place.y);
  }
  const double border = 0.06 * std::min(width, height);
  const double beside = std::min(left, width - right) - border;
  const double above = std::min(top, height - bottom) - border;
  EXPECT_NEAR(std::min(beside, above), 0.0, 1e-6);
  if (beside < above) {
    EXPECT_NEAR(left, width - right, 1e-6);
  }  // centred where it is tight
  if (above < beside) {
    EXPECT_NEAR(top, height - bottom, 1e-6);
  }
}

TEST(Camera, FitsTallFlatAndSkewSets) {
  expect_tight(box_mesh({0, 0, 0}, {1, 1, 2}).points, 1280, 900);
  expect_tight(box_mesh({-5, 0, 0}, {5, 1, 0.1}).points, 1280, 900);
  expect_tight(box_mesh({0, -3, -9}, {0.2, 0.1, -1}).points, 300, 900);
}

TEST(Camera, FitsASinglePoint) {
  const std::vector<Vec3> point{{1, 2, 3}};
  const ScreenPoint place = io::fit_camera(point, 100, 80).project(point[0]);
  EXPECT_GT(place.depth, 0.0);
  EXPECT_NEAR(place.x, 50.0, 1e-6);
  EXPECT_NEAR(place.y, 40.0, 1e-6);
}

}  // namespace
}  // namespace palpate::test
