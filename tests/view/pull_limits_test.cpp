// How hard tissue may be pulled. Oracle: the surface of boxes.
#include "view/pull_limits.hpp"

#include <algorithm>
#include <cstdint>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "geometry/vector.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"

namespace palpate::view {
namespace {

/// A box of 0.1 m and 20 kPa at the origin; beside it at x one of 1 kPa.
Model two_boxes(const std::string& x) {
  const std::string box = R"("box": {"cells": [6, 6, 6], "size": [0.1, 0.1, 0.1]})";
  const Scene scene =
      read_scene_text(R"({"bodies": [{"name": "stiff", )" + box +
                          R"(, "material": {"young_modulus": 20000}}, {"name": "soft", )" + box +
                          R"(, "translate": [)" + x + R"(, 0, 0], "material": {"young_modulus": 1000}}]})",
                      "two boxes");
  return load_model(scene, [](const auto&) { return TetMesh{}; });
}

TEST(PullLimits, AddUpToTheStressThatTissueTakesTimesTheSurface) {
  const Model model = two_boxes("5");
  const PullLimits limits(model.bodies, model.materials, {});
  const Range points = model.bodies.bodies()[0].points;
  double sum = 0.0;
  for (Index p = points.begin; p < points.end; ++p) sum += limits.force(p);
  EXPECT_NEAR(sum, PullLimits::largest_strain * 20000 * 0.06, 1e-9 * sum) << "far from each other";
}

TEST(PullLimits, AreThoseOfTheSoftestThatLiesAgainstABody) {
  const Model model = two_boxes("0.1");
  const PullLimits limits(model.bodies, model.materials, {});
  const double most = PullLimits::largest_squeeze * 1000 * 0.06 / 4;
  const auto [begin, end] = model.bodies.bodies()[0].points;
  double largest = 0.0;
  for (Index p = begin; p < end; ++p) largest = std::max(largest, limits.force(p));
  EXPECT_NEAR(largest, most, 1e-9 * most);
  const std::vector<std::uint8_t> rigid{0, 1};
  const PullLimits beside_rigid(model.bodies, model.materials, rigid);
  EXPECT_GT(beside_rigid.force(begin), 0.0);
  EXPECT_NEAR(beside_rigid.force(begin) / PullLimits(two_boxes("5").bodies, model.materials, {}).force(begin),
              1.0, 1e-9)
      << "what does not deform takes any squeeze";
}

TEST(PullLimits, MakeASpringGiveWay) {
  EXPECT_EQ(limited_stiffness({0, 0, 0}, {0, 0, 0.01}, 100, 2), 100);
  EXPECT_DOUBLE_EQ(limited_stiffness({0, 0, 0}, {0, 3, 4}, 100, 2), 0.4) << "5 m away with 2 N";
}

}  // namespace
}  // namespace palpate::view
