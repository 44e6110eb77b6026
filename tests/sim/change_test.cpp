// Settings and motions that change while a simulation runs. Oracles: Newton, the spring law of contacts,
// equal bits for all structures and sorts.
#include <cmath>
#include <gtest/gtest.h>

#include <palpate/error.hpp>
#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "support/mean.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

/// A block on a plate.
Model model() {
  Model made;
  made.bodies.add("plate", test::box_mesh({5, 5, 1}, {-0.2, -0.2, -0.1}, {0.2, 0.2, 0}));
  made.bodies.add("block", test::box_mesh({4, 4, 2}, {-0.05, -0.05, -1e-5}, {0.05, 0.05, 0.05}));
  made.materials = {Material{},
                    Material{.young_modulus = 1e6, .mass_damping = 5.0, .stiffness_damping = 1e-3}};
  made.obstacles = {1, 0};
  return made;
}

void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) simulation.step();
}

double deepest_at_rest(Simulation& simulation) {
  for (int i = 0; i < 600 && !simulation.at_rest(); ++i) simulation.step();
  EXPECT_TRUE(simulation.at_rest());
  return simulation.metrics().deepest;
}

TEST(Change, GravityCountsFromTheNextStep) {
  Model flying;
  flying.bodies.add("block", test::box_mesh({2, 2, 2}, {0, 0, 0}, {1, 1, 1}));
  flying.materials = {Material{}};
  Simulation simulation(std::move(flying), {}, 1);
  run(simulation, 10);
  SimulationSettings settings = simulation.settings();
  settings.gravity = {2.0, 0, 0};
  simulation.change(settings);
  EXPECT_NEAR(simulation.velocities()[0].z, -9.81 * 0.1, 1e-4) << "a change moves nothing";
  run(simulation, 10);
  EXPECT_NEAR(simulation.velocities()[0].z, -9.81 * 0.1, 1e-4);
  EXPECT_NEAR(simulation.velocities()[0].x, 2.0 * 0.1, 1e-4);
  EXPECT_EQ(simulation.metrics().step, 20);
}

TEST(Change, StructureOrderAndSortKeepTheBits) {
  SimulationSettings settings;
  settings.time_step = 0.005;
  Simulation steady(model(), settings, 1);
  run(steady, 30);
  Simulation changing(model(), settings, 1);
  int steps = 0;
  for (const Structure structure :
       {Structure::hash, Structure::uniform, Structure::cuckoo, Structure::compact}) {
    run(changing, 6);
    steps += 6;
    settings.detection.structure = structure;
    settings.detection.order = Order::z;
    settings.detection.sort = Sort::radix;
    const std::size_t contacts = changing.detector().contacts().size();
    changing.change(settings);
    EXPECT_EQ(changing.detector().contacts().size(), contacts) << "found again where the points are";
  }
  run(changing, 30 - steps);
  EXPECT_EQ(changing.state_hash(), steady.state_hash());
}

TEST(Change, ContactStiffnessDecidesHowDeepABlockSinks) {
  SimulationSettings settings;
  settings.time_step = 0.005;
  settings.response.stiffness = 500.0;
  Simulation simulation(model(), settings, 1);
  const double soft = deepest_at_rest(simulation);
  settings.response.stiffness = 2000.0;
  simulation.change(settings);
  EXPECT_FALSE(simulation.at_rest()) << "what has changed is not yet at rest";
  const double stiff = deepest_at_rest(simulation);
  EXPECT_NEAR(stiff / soft, 0.25, 0.05);  // contacts at rims push less
}

TEST(Change, ABlockSlidesOnceFrictionIsZero) {
  SimulationSettings settings;
  settings.time_step = 0.005;
  settings.gravity = {3.0, 0, -9.81};
  settings.response.friction = 0.6;
  Simulation simulation(model(), settings, 1);
  const auto speed = [&] { return test::mean_of_body(simulation.bodies(), 1, simulation.velocities()).x; };
  run(simulation, 100);
  EXPECT_NEAR(speed(), 0.0, 0.002);
  settings.response.friction = 0.0;
  simulation.change(settings);
  run(simulation, 20);
  // Mass damping is part of the block: v' = 3 - 5 v.
  EXPECT_NEAR(speed(), 0.6 * (1.0 - std::exp(-0.5)), 0.02);
}

TEST(Change, RefusesAndChangesNothing) {
  SimulationSettings settings;
  settings.response.friction = 0.3;
  Simulation simulation(model(), settings, 1);
  run(simulation, 5);
  const std::string hash = simulation.state_hash();
  const auto refuse = [&](auto&& spoil) {
    SimulationSettings wrong = settings;
    wrong.gravity = {};
    wrong.detection.structure = Structure::hash;
    spoil(wrong);
    EXPECT_THROW(simulation.change(wrong), Error);
    EXPECT_EQ(simulation.settings().gravity, settings.gravity);
    EXPECT_EQ(simulation.settings().detection, settings.detection);
    EXPECT_EQ(simulation.settings().response.friction, 0.3);
  };
  refuse([](SimulationSettings& s) { s.time_step = 0.02; });
  refuse([](SimulationSettings& s) { s.gravity.x = NAN; });
  refuse([](SimulationSettings& s) { s.response.friction = -0.1; });
  refuse([](SimulationSettings& s) { s.response.stiffness = 0.0; });
  refuse([](SimulationSettings& s) { s.detection.cells_per_primitive = 28; });
  refuse([](SimulationSettings& s) { s.detection.cell_size = -1.0; });
  refuse([](SimulationSettings& s) { s.detection.self_collision = {1}; });
  refuse([](SimulationSettings& s) { s.solver.tolerance = 0.0; });
  EXPECT_EQ(simulation.state_hash(), hash);
  EXPECT_NO_THROW(simulation.step());
}

TEST(SetMotion, LeadsABodyToWhereItHasIt) {
  Model made = model();
  made.motions = {{{}, {{0.0, {}, {1, 0, 0, 0}}}}};
  made.motion_of_point.assign(made.bodies.points_rest().size(), -1);
  for (Index p = 0; p < made.bodies.bodies()[0].points.end; ++p) at(made.motion_of_point, p) = 0;
  Simulation simulation(std::move(made), {}, 1);
  const Vec3 start = simulation.positions()[0];
  run(simulation, 3);
  EXPECT_EQ(simulation.positions()[0], start);
  const double half = std::sqrt(0.5);
  simulation.set_motion(0, {{}, {{0.03, {}, {1, 0, 0, 0}}, {0.13, {0, 0, -0.1}, {half, 0, 0, half}}}});
  run(simulation, 5);
  EXPECT_NEAR(simulation.positions()[0].z, start.z - 0.05, 1e-12);
  run(simulation, 20);
  // A quarter turn about z.
  EXPECT_NEAR(simulation.positions()[0].x, -start.y, 1e-12);
  EXPECT_NEAR(simulation.positions()[0].y, start.x, 1e-12);
  EXPECT_THROW(simulation.set_motion(1, {{}, {{0.0, {}, {1, 0, 0, 0}}}}), Error);
  EXPECT_THROW(simulation.set_motion(0, {}), Error);
  EXPECT_THROW(simulation.set_motion(0, {{}, {{1.0, {}, {1, 0, 0, 0}}, {0.5, {}, {1, 0, 0, 0}}}}), Error);
}

TEST(PoseAt, IsThePoseOfPrescribedMotions) {
  const double half = std::sqrt(0.5);
  const Motion motion{
      {}, {{0.0, {}, {2, 0, 0, 0}}, {1.0, {4, 0, 0}, {half, 0, 0, half}}}, Interpolation::smooth};
  const Keyframe middle = pose_at(motion, 0.5);
  EXPECT_NEAR(middle.translate.x, 2.0, 1e-12);
  EXPECT_NEAR(middle.quaternion[0], std::cos(M_PI / 8), 1e-12);
  EXPECT_NEAR(middle.quaternion[3], std::sin(M_PI / 8), 1e-12);
  EXPECT_EQ(pose_at(motion, 9.0).translate, (Vec3{4, 0, 0}));
  EXPECT_THROW(static_cast<void>(pose_at({}, 0.0)), Error);
}

}  // namespace
}  // namespace palpate
