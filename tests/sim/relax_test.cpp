// Oracles: symmetry, points that must not move, and a run that starts from the result.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include <palpate/error.hpp>
#include <palpate/relax.hpp>
#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "support/mean.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

/// Two equal balls that overlap by 4 mm along x.
Model two_balls() {
  Model model;
  model.bodies.add("left", test::ball_mesh(10, {-0.023, 0, 0}, 0.025));
  model.bodies.add("right", test::ball_mesh(10, {0.023, 0, 0}, 0.025));
  model.materials = {Material{.young_modulus = 2e4}, Material{.young_modulus = 2e4}};
  return model;
}

SimulationSettings without_gravity() {
  SimulationSettings settings;
  settings.gravity = {};
  settings.response.friction = 0.3;
  return settings;
}

Vec3 centre(const Model& model, Index body) {
  return test::mean_of_body(model.bodies, body, model.bodies.points_rest());
}

TEST(Relax, MovesEqualBodiesEquallyFarApart) {
  Model model = two_balls();
  const RelaxReport report = relax(model, without_gravity(), {});
  EXPECT_TRUE(report.relaxed);
  EXPECT_GT(report.steps, 0);
  EXPECT_GT(report.contacts_before, 10U);
  EXPECT_GT(report.deepest_before, 0.003);
  EXPECT_LT(report.deepest_before, 0.0041);
  EXPECT_LE(report.deepest_after, report.allowed_depth);
  EXPECT_NEAR(report.allowed_depth,
              0.01 * mesh_statistics(model.bodies, model.bodies.points_rest(), 0).edge_length.mean,
              0.1 * report.allowed_depth);
  EXPECT_LT(report.largest_move, 0.006);
  EXPECT_LT(centre(model, 0).x, -0.0238) << "goes half of the overlap, less the dent";
  EXPECT_GT(centre(model, 0).x, -0.0251);
  EXPECT_NEAR(centre(model, 0).x + centre(model, 1).x, 0.0, 2e-4) << "momentum";
  for (const Index body : {0, 1}) {
    EXPECT_NEAR(centre(model, body).y, 0.0, 2e-4);
    EXPECT_NEAR(centre(model, body).z, 0.0, 2e-4);
  }

  // A run starts without stress and stays where it is.
  Simulation simulation(std::move(model), without_gravity(), 1);
  EXPECT_LT(simulation.metrics().elastic_energy, 1e-20);
  EXPECT_LE(simulation.metrics().deepest, report.allowed_depth);
  for (int i = 0; i < 50; ++i) simulation.step();
  EXPECT_LT(simulation.metrics().largest_speed, 0.002);
}

double six_volumes(const Model& model, const Tet& tet) {
  const auto points = model.bodies.points_rest();
  const auto edge = [&](std::size_t i) { return at(points, tet[i]) - at(points, tet[0]); };
  return dot(cross(edge(1), edge(2)), edge(3));
}

/// Bars that cross, 1 mm deep, with no point in each other.
TEST(Relax, RemovesOverlapsOfEdges) {
  Model model;
  model.bodies.add("lower", test::box_mesh({3, 1, 1}, {-0.1, -0.01, -0.01}, {0.1, 0.01, 0.01}));
  model.bodies.add("upper", test::box_mesh({1, 3, 1}, {-0.01, -0.1, 0.009}, {0.01, 0.1, 0.029}));
  model.materials = {Material{.young_modulus = 1e5}, Material{.young_modulus = 1e5}};
  const RelaxReport report = relax(model, without_gravity(), {});
  EXPECT_EQ(report.contacts_before, 0U);
  EXPECT_NEAR(report.deepest_before, 0.001, 1e-6);
  EXPECT_TRUE(report.relaxed);
  EXPECT_GT(centre(model, 1).z - centre(model, 0).z, 0.0195);
}

TEST(Relax, RemovesDeepOverlapsWithoutCrushingTissue) {
  Model three;
  const std::vector<Vec3> centres{{0, 0, 0}, {0.06, 0, 0.001}, {0.03, 0.05, 0.001}};
  for (const Vec3& c : centres) three.bodies.add("ball", test::ball_mesh(5, c, 0.05));
  three.materials.assign(3, Material{});
  Model in_bone;  // nearly swallowed
  in_bone.bodies.add("bone", test::box_mesh({4, 4, 4}, {-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05}));
  in_bone.bodies.add("ball", test::ball_mesh(3, {0.01, 0.005, 0.045}, 0.02));
  in_bone.materials.assign(2, Material{});
  in_bone.obstacles = {1, 0};
  for (Model* model : {&three, &in_bone}) {
    const Model before = *model;
    const RelaxReport report = relax(*model, without_gravity(), {});
    EXPECT_TRUE(report.relaxed) << report.deepest_after << " m of " << report.deepest_before;
    EXPECT_GT(report.deepest_before, 0.02);
    for (const Tet& tet : model->bodies.tets())
      ASSERT_GE(six_volumes(*model, tet), 0.1 * six_volumes(before, tet));
    Detector detector(model->bodies, {}, {}, 1);
    detector.detect(model->bodies.points_rest());
    for (const double depth : detector.contacts().depth) EXPECT_LE(depth, report.allowed_depth);
  }
}

TEST(Relax, LeavesWhatHasNowhereToGo) {
  // A ball in a cavity of bone that is too small for it: there is no answer without crushing it.
  Model model;
  for (const double side : {-1.0, 1.0}) {
    model.bodies.add("bone", test::box_mesh({2, 2, 2}, {-0.06, -0.06, side * 0.05 - 0.045},
                                            {0.06, 0.06, side * 0.05 + 0.045}));
  }
  model.bodies.add("ball", test::ball_mesh(4, {0, 0, 0}, 0.03));
  model.bodies.add("wall", test::box_mesh({2, 2, 2}, {0.006, -0.06, -0.1}, {0.05, 0.06, 0.1}));
  model.bodies.add("wall", test::box_mesh({2, 2, 2}, {-0.05, -0.06, -0.1}, {-0.006, 0.06, 0.1}));
  model.bodies.add("wall", test::box_mesh({2, 2, 2}, {-0.06, 0.006, -0.1}, {0.06, 0.05, 0.1}));
  model.bodies.add("wall", test::box_mesh({2, 2, 2}, {-0.06, -0.05, -0.1}, {0.06, -0.006, 0.1}));
  model.materials.assign(7, Material{});
  model.obstacles = {1, 1, 0, 1, 1, 1, 1};
  const Model before = model;
  const RelaxReport report = relax(model, without_gravity(), {});
  EXPECT_FALSE(report.relaxed);
  for (const Tet& tet : model.bodies.tets())
    ASSERT_GE(six_volumes(model, tet), 0.1 * six_volumes(before, tet));
}

TEST(Relax, SeesAllOverlapsInApproximateModeToo) {
  SimulationSettings settings = without_gravity();
  settings.detection.cells_per_primitive = 1;
  settings.detection.cell_size = 0.001;  // so small that the one slot of a primitive misses nearly all cells
  Model approximate = two_balls();
  Model exact = two_balls();
  const RelaxReport report = relax(approximate, settings, {});
  settings.detection.cells_per_primitive.reset();
  EXPECT_EQ(report.contacts_before, relax(exact, settings, {}).contacts_before);
  EXPECT_GT(report.contacts_before, 10U);
}

TEST(Relax, HasTheSameBitsForEveryThreadCount) {
  std::vector<Vec3> first;
  for (const int threads : {1, 2, 3}) {
    Model model = two_balls();
    relax(model, without_gravity(), {}, threads);
    const std::vector<Vec3> points(model.bodies.points_rest().begin(), model.bodies.points_rest().end());
    if (first.empty()) first = points;
    EXPECT_EQ(points, first) << threads;
  }
}

TEST(Relax, LeavesRigidBodiesAndFixedPointsWhereTheyAre) {
  Model model = two_balls();
  model.obstacles = {1, 0};
  const std::vector<Vec3> before(model.bodies.points_rest().begin(), model.bodies.points_rest().end());
  const Index left_end = model.bodies.bodies()[0].points.end;
  model.fixed_points.assign(before.size(), 0);
  const auto last = before.size() - 1;
  model.fixed_points[last] = 1;
  EXPECT_TRUE(relax(model, without_gravity(), {}).relaxed);
  for (Index p = 0; p < left_end; ++p) ASSERT_EQ(at(model.bodies.points_rest(), p), at(before, p));
  EXPECT_EQ(model.bodies.points_rest()[last], before[last]);
}

TEST(Relax, SaysWhatItCouldNotRemove) {
  Model model = two_balls();
  const RelaxReport report = relax(model, without_gravity(), {.depth = 1e-9, .max_steps = 2});
  EXPECT_FALSE(report.relaxed);
  EXPECT_EQ(report.steps, 2);
  EXPECT_GT(report.deepest_after, report.allowed_depth);
}

/// Tissue attached inside its own bone.
TEST(Relax, DoesNotWaitForWhatCannotMove) {
  Model model = two_balls();
  const std::vector<Vec3> before(model.bodies.points_rest().begin(), model.bodies.points_rest().end());
  model.obstacles = {1, 0};
  // All points of tets that reach into the other ball.
  for (const Vec3& p : before) model.fixed_points.push_back(p.x < 0.012 ? 1 : 0);
  const RelaxReport report = relax(model, without_gravity(), {});
  EXPECT_TRUE(report.relaxed);
  EXPECT_EQ(report.steps, 0);
  EXPECT_EQ(report.deepest_before, 0.0);
  EXPECT_GT(report.contacts_before, 0U);
  EXPECT_TRUE(std::ranges::equal(model.bodies.points_rest(), before));
}

TEST(Relax, DoesNothingWhereNothingOverlaps) {
  Model model;
  model.bodies.add("ball", test::ball_mesh(3, {0, 0, 0}, 0.05));
  model.materials = {Material{}};
  const RelaxReport report = relax(model, {}, {});
  EXPECT_TRUE(report.relaxed);
  EXPECT_EQ(report.steps, 0);
}

TEST(Relax, LeavesTheModelAsItWasWhereItIsStopped) {
  Model model = two_balls();
  const std::vector<Vec3> before(model.bodies.points_rest().begin(), model.bodies.points_rest().end());
  EXPECT_THROW(relax(model, without_gravity(), {}, 1, [](int, double) { throw 1; }), int);
  EXPECT_TRUE(std::equal(before.begin(), before.end(), model.bodies.points_rest().begin()));
}

TEST(Relax, RefusesBadSettings) {
  Model model = two_balls();
  const auto message = [&](const RelaxSettings& settings) -> std::string {
    try {
      relax(model, {}, settings);
    } catch (const Error& e) {
      return e.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message({.depth = 0.0}), "relax settings: depth: found 0, expected a finite number > 0");
  EXPECT_EQ(message({.max_steps = 0}), "relax settings: max_steps: found 0, expected at least 1");
}

TEST(Bodies, TakesOtherRestPositionsOrNone) {
  Model model = two_balls();
  std::vector<Vec3> points(model.bodies.points_rest().begin(), model.bodies.points_rest().end());
  for (Vec3& p : points) p = 2.0 * p;
  model.bodies.set_points_rest(points);
  EXPECT_EQ(model.bodies.points_rest()[3], points[3]);
  for (Vec3& p : points) p.x = -p.x;
  try {
    model.bodies.set_points_rest(points);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()),
              "left: tet 0: found no positive volume, expected a tet that is not flat or inverted");
  }
  EXPECT_EQ(model.bodies.points_rest()[3].x, -points[3].x);
  points.pop_back();
  EXPECT_THROW(model.bodies.set_points_rest(points), Error);
}

}  // namespace
}  // namespace palpate
