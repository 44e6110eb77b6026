// Limits of pulls on tissue. Oracle: the surface of boxes.
#include "view/pull_limits.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "geometry/vector.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"

namespace palpate::view {
namespace {

/// A box of 0.1 m and 20 kPa at the origin that is held at its base; beside it at x one of 1 kPa.
Model two_boxes(
    const std::string& x,
    const std::string& more = R"(, "fixed": [{"box": {"lower": [-1, -1, -1], "upper": [1, 1, -0.049]}}])") {
  const std::string box = R"("box": {"cells": [6, 6, 6], "size": [0.1, 0.1, 0.1]})";
  const Scene scene = read_scene_text(R"({"bodies": [{"name": "stiff", )" + box +
                                          R"(, "material": {"young_modulus": 20000})" + more +
                                          R"(}, {"name": "soft", )" + box + R"(, "translate": [)" + x +
                                          R"(, 0, 0], "material": {"young_modulus": 1000}}]})",
                                      "two boxes");
  return load_model(scene, [](const auto&) { return TetMesh{}; });
}

PullLimits limits_of(const Model& model, double time_step = 0.01) {
  const std::vector<double> edges(model.materials.size(), 0.02);
  return {model, std::span(model.materials).first(model.bodies.bodies().size()), edges, time_step};
}

/// The point of the first body at a place.
Index point_at(const Model& model, const Vec3& place) {
  const Range points = model.bodies.bodies()[0].points;
  for (Index p = points.begin; p < points.end; ++p) {
    if (length(model.bodies.points_rest()[static_cast<std::size_t>(p)] - place) < 1e-9) return p;
  }
  throw std::runtime_error("no point there");
}

TEST(PullLimits, AreTheStressThatTissueTakesTimesTheSurfaceOfAPoint) {
  const Model model = two_boxes("5");
  const double cell = 0.1 / 6;
  // Points of a side have four or eight triangles alternately: on average, the area of one square each.
  const double most = PullLimits::largest_strain * 20000 * cell * cell;
  const double sum = limits_of(model).force(point_at(model, {0, 0, 0.05})) +
                     limits_of(model).force(point_at(model, {cell, 0, 0.05}));
  EXPECT_NEAR(sum, 2 * most, 1e-9 * most);
  EXPECT_EQ(limits_of(model).force(point_at(model, {0, 0, 0})), 0.0) << "inside";
}

TEST(PullLimits, AreLessWhereOnlyOneTetHoldsAPoint) {
  Model model;
  const double a = 0.01;
  model.bodies.add("tet", {{{0, 0, 0}, {a, 0, 0}, {0, a, 0}, {0, 0, a}}, {{0, 1, 2, 3}}});
  model.materials = {Material{.young_modulus = 1000}};
  model.fixed_points = {0, 1, 1, 1};
  // Three right triangles meet at point 0. The opposite face is smaller than their sum, so it is the limit.
  const double across = std::sqrt(3.0) / 2 * a * a;
  const double squeeze = PullLimits::largest_squeeze * 1000 * (1.5 * a * a + across) / 4;
  const double strain = PullLimits::largest_strain * 1000 * across / 3;
  EXPECT_NEAR(limits_of(model).force(0), std::min(strain, squeeze), 1e-12);
  EXPECT_NEAR(limits_of(model).force(1), std::min(PullLimits::largest_strain * 1000 * a * a / 6, squeeze),
              1e-12);
}

TEST(PullLimits, AreThoseOfTheSoftestThatLiesAgainstABody) {
  Model model = two_boxes("0.1");
  model.materials[1].young_modulus = 500;  // so soft that strain does not limit pulls
  const double most = PullLimits::largest_squeeze * 500 * 0.06 / 4;
  const PullLimits limits = limits_of(model);
  const auto [begin, end] = model.bodies.bodies()[0].points;
  double largest = 0.0;
  for (Index p = begin; p < end; ++p) largest = std::max(largest, limits.force(p));
  EXPECT_NEAR(largest, most, 1e-9 * most);
  Model beside_rigid = two_boxes("0.1");
  beside_rigid.obstacles = {0, 1};
  const Index point = point_at(model, {0, 0, 0.05});
  EXPECT_NEAR(limits_of(beside_rigid).force(point) / limits_of(two_boxes("5")).force(point), 1.0, 1e-9)
      << "what does not deform takes any squeeze";
}

TEST(PullLimits, AreThoseOfTheSoftestTetAtAPoint) {
  const Model model =
      two_boxes("5", R"(, "fixed": [{"box": {"lower": [-1, -1, -1], "upper": [1, 1, -0.049]}}],
    "regions": [{"box": {"lower": [0, -1, -1], "upper": [1, 1, 1]}, "material": {"young_modulus": 400}}])");
  const double cell = 0.1 / 6;
  const auto forces = [&](double x) {
    const PullLimits limits = limits_of(model);
    return limits.force(point_at(model, {x, 0, 0.05})) + limits.force(point_at(model, {x, cell, 0.05}));
  };
  EXPECT_NEAR(forces(2 * cell), PullLimits::largest_strain * 400 * 2 * cell * cell, 1e-9);
  EXPECT_NEAR(forces(-2 * cell), PullLimits::largest_strain * 20000 * 2 * cell * cell, 1e-9);
}

TEST(PullLimits, DoNotThrowAFreeBodyFarInAStep) {
  const Model model = two_boxes("5", "");
  const double step = 1.0;  // long, so that this is the limit
  const double mass = model.materials[0].density * 1e-3;
  EXPECT_NEAR(limits_of(model, step).force(point_at(model, {0, 0, 0.05})),
              PullLimits::largest_leap * mass * 0.02, 1e-9);
  EXPECT_GT(limits_of(two_boxes("5"), step).force(point_at(model, {0, 0, 0.05})), 1.0) << "held at its base";
}

TEST(PullLimits, ReduceTheStiffnessOfASpring) {
  const PullSpring spring{.stiffness = 100, .mass = 0.0, .most = 2};
  const Vec3 still{};
  EXPECT_EQ(limited_stiffness(spring, {0, 0, 0}, still, 0.1, {0, 0, 0.01}), 100);
  EXPECT_DOUBLE_EQ(limited_stiffness(spring, {0, 0, 0}, still, 0.1, {0, 3, 4}), 0.4) << "5 m away with 2 N";
  EXPECT_DOUBLE_EQ(limited_stiffness(spring, {0, 0, 0}, {0, -30, -40}, 0.1, {0, 3, 4}), 0.2)
      << "going away, 10 m";
  EXPECT_DOUBLE_EQ(limited_stiffness(spring, {0, 0, 0}, {0, 30, 40}, 0.1, {0, 3, 4}), 0.4) << "coming";
}

/// Spring and damper, 2 sqrt(k m), of a point that flees.
TEST(PullLimits, CountTheDamper) {
  const PullSpring spring{.stiffness = 1000, .mass = 0.01, .most = 2};
  const double k = limited_stiffness(spring, {0, 0, 0}, {0, 0, -3}, 0.01, {0, 0, 1});
  EXPECT_NEAR(k * 1.03 + 2 * std::sqrt(k * 0.01) * 3, 2, 1e-12);
}

}  // namespace
}  // namespace palpate::view
