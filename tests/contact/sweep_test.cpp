// Continuity of depth and direction: one body moves through another in 1000 steps. The bounds are those that
// docs/depth.md states. A jump stays as large however small the steps are, so the worst steps are also looked
// at in 100 parts: there the change must fall.
#include "contact/sweep.hpp"

#include <filesystem>
#include <gtest/gtest.h>

#include "support/meshes.hpp"
#include "support/real_data.hpp"

namespace palpate {
namespace {

constexpr int steps = 1000;
constexpr double steepest_depth = 60.0;      // change of depth per motion
constexpr double steepest_direction = 20.0;  // change of direction, times certainty and depth, per motion

/// Body 1 on its way through body 0, at s from 0 to 1.
class Passage {
 public:
  Passage(TetMesh still, TetMesh moving, const Vec3& travel) : travel_(travel) {
    bodies_.add("still", std::move(still));
    bodies_.add("moving", std::move(moving));
    edge_ = mesh_statistics(bodies_, bodies_.points_rest(), 0).edge_length.mean;
  }
  [[nodiscard]] test::SweepReport sweep(double first, double stride, int n) const {
    Detector detector(bodies_, {}, {}, 2);
    return test::sweep(detector, first, stride, n, [this](double s) {
      std::vector<Vec3> x(bodies_.points_rest().begin(), bodies_.points_rest().end());
      const Range moving = at(bodies_.bodies(), 1).points;
      for (Index p = moving.begin; p < moving.end; ++p) at(x, p) += (s - 0.5) * travel_;
      return x;
    });
  }
  [[nodiscard]] double edge() const { return edge_; }

 private:
  Bodies bodies_;
  Vec3 travel_;
  double edge_ = 0.0;
};

/// What may turn at once: nothing, or directions where an edge between two contacts leaves a concave body in
/// between (docs/depth.md).
enum class Turns { none, in_concave_places };

void expect_continuous(const std::string& name, const Passage& passage, Turns turns = Turns::none) {
  SCOPED_TRACE(name);
  constexpr double stride = 1.0 / (steps - 1);
  constexpr int parts = 100;
  const test::SweepReport whole = passage.sweep(0.0, stride, steps);
  const double motion = whole.motion / passage.edge();
  EXPECT_GT(whole.pairs, 10000U);
  EXPECT_GT(whole.deepest, passage.edge()) << "deep enough to be hard";
  EXPECT_EQ(whole.regions_without_border, 0U);
  EXPECT_LT(whole.depth.size, steepest_depth * whole.motion) << "point " << whole.depth.point;
  EXPECT_LT(whole.direction.size, steepest_direction * whole.motion) << "point " << whole.direction.point;
  const auto refined = [&](const test::Jump& jump) {
    return passage.sweep((jump.step - 1) * stride, stride / parts, parts + 1);
  };
  const double fine_depth = refined(whole.depth).depth.size;
  const double fine_direction = refined(whole.direction).direction.size;
  EXPECT_LT(fine_depth, 0.1 * whole.depth.size) << "a jump at step " << whole.depth.step;
  if (turns == Turns::none) {
    EXPECT_LT(fine_direction, 0.1 * whole.direction.size) << "a jump at step " << whole.direction.step;
  }
  std::printf(
      "%-10s motion %.4f edges a step; deepest %.2f edges; depth changes %.1f times as fast (%.3f edges a "
      "step, %.4f in 100 parts); direction times certainty and depth %.1f times as fast (%.4f edges a step, "
      "%.5f in "
      "100 parts); turn %.0f degrees\n",
      name.c_str(), motion, whole.deepest / passage.edge(), whole.depth.size / whole.motion,
      whole.depth.size / passage.edge(), fine_depth / passage.edge(), whole.direction.size / whole.motion,
      whole.direction.size / passage.edge(), fine_direction / passage.edge(),
      114.592 * std::asin(0.5 * whole.rotation.size));
}

TetMesh turned(TetMesh mesh, const Vec3& axis, double angle) {
  for (Vec3& p : mesh.points) p = test::rotated(p, axis, angle);
  return mesh;
}

TEST(Sweep, OfABarThroughABoxIsContinuous) {
  expect_continuous(
      "box/box", {test::box_mesh({6, 6, 6}, {-1, -1, -1}, {1, 1, 1}),
                  turned(test::box_mesh({3, 3, 14}, {-0.41, -0.45, -2.4}, {0.43, 0.4, 2.5}), {1, 2, 3}, 0.2),
                  {4.0, 0.3, 0.2}});
}

TEST(Sweep, OfABallThroughABallIsContinuous) {
  expect_continuous("ball/ball", {test::ball_mesh(8, {0, 0, 0}, 1.0),
                                  turned(test::ball_mesh(8, {0.02, 0.51, 0.03}, 0.8), {1, 2, 3}, 0.01),
                                  {4.0, 0.01, 0.02}});
}

TEST(Sweep, OfASmallBoxJumpsOnlyWhereItIsSwallowedWhole) {
  const Passage passage(
      test::box_mesh({4, 4, 4}, {-1, -1, -1}, {1, 1, 1}),
      turned(test::box_mesh({2, 2, 2}, {-0.21, -0.1, -0.15}, {0.2, 0.3, 0.22}), {1, 2, 3}, 0.3),
      {3.0, 0.1, 0.2});
  const test::SweepReport whole = passage.sweep(0.0, 1.0 / (steps - 1), steps);
  EXPECT_GT(whole.regions_without_border, 100U);
  EXPECT_LT(whole.depth.size, steepest_depth * whole.motion) << "step " << whole.depth.step;
  EXPECT_LT(whole.swallowed.size, whole.deepest);
}

class OrganSweep : public ::testing::TestWithParam<const char*> {};

TEST_P(OrganSweep, IsContinuous) {
  const std::filesystem::path file = test::real_data_folder() / "meshes" / GetParam();
  if (!std::filesystem::exists(file)) {
    GTEST_SKIP() << "no mesh " << file << ": set PALPATE_TEST_DATA to where the real meshes are";
  }
  const TetMesh organ = test::real_mesh(GetParam(), 1.0);
  const bool bones = std::string(GetParam()) == "Ossicles.vtu";  // thin and bent
  expect_continuous(GetParam(), {organ, turned(organ, {1, 2, 3}, 1.0), {1.7, 0.1, 0.05}},
                    bones ? Turns::in_concave_places : Turns::none);
}

INSTANTIATE_TEST_SUITE_P(Meshes, OrganSweep, ::testing::Values("liver.msh", "liver2.msh", "Ossicles.vtu"),
                         [](const auto& p) {
                           const std::string name = p.param;
                           return name.substr(0, name.find('.'));
                         });

}  // namespace
}  // namespace palpate
