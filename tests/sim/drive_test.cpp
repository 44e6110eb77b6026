// Prescribed motions, attachments, forces and grabs. Oracles: Newton, and the formula of the motion.
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include <palpate/error.hpp>
#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "support/mean.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

Vec3 mean_velocity(const Simulation& simulation, Index body) {
  return test::mean_of_body(simulation.bodies(), body, simulation.velocities());
}

/// Why a call is refused.
template <class Call>
std::string message(Call&& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "accepted";
}

/// A block on a plate that follows a motion.
Model block_on_plate(const Motion& motion) {
  Model model;
  model.bodies.add("plate", test::box_mesh({9, 3, 1}, {-1, -0.5, -0.1}, {3, 0.5, 0}));
  model.bodies.add("block", test::box_mesh({4, 4, 2}, {-0.05, -0.05, 1e-5}, {0.05, 0.05, 0.05001}));
  model.materials = {Material{}, Material{.young_modulus = 1e6, .stiffness_damping = 1e-3}};
  model.obstacles = {1, 0};
  model.motions = {motion};
  model.motion_of_point.assign(model.bodies.points_rest().size(), -1);
  for (Index p = 0; p < model.bodies.bodies()[0].points.end; ++p) at(model.motion_of_point, p) = 0;
  return model;
}

TEST(RigidMotion, IsExactAndItsVelocityEntersFriction) {
  // A belt at 0.5 m/s under a block with friction 0.3: the block gains 0.3 g until it moves with the belt.
  Model model = block_on_plate({{}, {{0.0, {}, {1, 0, 0, 0}}, {10.0, {5, 0, 0}, {1, 0, 0, 0}}}});
  SimulationSettings settings;
  settings.time_step = 0.002;
  settings.response.friction = 0.3;
  const Vec3 start = model.bodies.points_rest()[0];
  Simulation simulation(std::move(model), settings, 1);
  const auto run_to = [&](double time) {
    while (simulation.metrics().time < time - 1e-9) simulation.step();
    return mean_velocity(simulation, 1).x;
  };
  const double first = run_to(0.06);
  const double second = run_to(0.12);
  EXPECT_NEAR((second - first) / 0.06, 0.3 * 9.81, 0.05 * 0.3 * 9.81);
  EXPECT_NEAR(run_to(0.6), 0.5, 0.005);
  EXPECT_EQ(simulation.positions()[0].x, start.x + 0.5 * simulation.metrics().time) << "no rounding adds up";
  EXPECT_FALSE(simulation.at_rest()) << "while rails move nothing is at rest";
  // One-way coupling: the plate follows its motion, and kinetic energy is that of the block alone.
  double mass = 0.0;
  for (const double m : simulation.masses().subspan(1)) mass += m;
  EXPECT_NEAR(simulation.metrics().kinetic_energy, 0.5 * mass * 0.25, 0.02 * 0.125 * mass);
}

TEST(RigidMotion, LiftsWhatLiesOnItAndHoldsAtItsEnd) {
  Model model = block_on_plate(
      {{}, {{0.0, {}, {1, 0, 0, 0}}, {0.5, {0, 0, 0.2}, {1, 0, 0, 0}}}, Interpolation::smooth});
  SimulationSettings settings;
  settings.time_step = 0.005;
  settings.response.friction = 0.3;
  Simulation simulation(std::move(model), settings, 1);
  while (!simulation.at_rest() && simulation.metrics().step < 400) simulation.step();
  ASSERT_TRUE(simulation.at_rest());
  EXPECT_GE(simulation.metrics().time, 0.5);
  const double height = test::mean_of_body(simulation.bodies(), 1, simulation.positions()).z;
  EXPECT_NEAR(height, 0.225, 0.001);
}

TEST(RigidMotion, StartsWhereTheMotionIsAtTimeZero) {
  Model model = block_on_plate({{}, {{0.0, {0, 0, -1}, {1, 0, 0, 0}}}});
  const double z = model.bodies.points_rest()[0].z;
  const Simulation simulation(std::move(model), {}, 1);
  EXPECT_EQ(simulation.positions()[0].z, z - 1.0);
  EXPECT_EQ(simulation.velocities()[0], Vec3{});
}

TEST(Attachment, CarriesTissueWithTheMotion) {
  // One end of a bar is glued to a motion; the rest of the bar follows through its elasticity.
  Model model;
  model.bodies.add("bar", test::box_mesh({6, 2, 2}, {0, 0, 0}, {0.12, 0.04, 0.04}));
  model.materials = {Material{.young_modulus = 1e5, .mass_damping = 20.0}};
  model.motions = {
      {{0, 0, 0}, {{0.0, {}, {1, 0, 0, 0}}, {0.5, {0.3, 0.1, 0}, {std::sqrt(0.5), 0, 0, std::sqrt(0.5)}}}}};
  const auto rest = model.bodies.points_rest();
  const std::vector<Vec3> start(rest.begin(), rest.end());
  for (const Vec3& p : start) model.motion_of_point.push_back(p.x == 0.0 ? 0 : -1);
  SimulationSettings settings;
  settings.gravity = {};
  Simulation simulation(std::move(model), settings, 1);
  for (int i = 0; i < 300; ++i) simulation.step();
  for (std::size_t p = 0; p < start.size(); ++p) {
    const Vec3 turned{-start[p].y + 0.3, start[p].x + 0.1, start[p].z};  // a quarter turn about z
    EXPECT_LT(length(simulation.positions()[p] - turned), start[p].x == 0.0 ? 1e-15 : 1e-4) << p;
  }
}

TEST(Force, AcceleratesAFreeBodyByNewtonAndIsTakenOff) {
  Model model;
  model.bodies.add("ball", test::ball_mesh(3, {0, 0, 0}, 0.05));
  model.materials = {Material{.young_modulus = 1e5, .stiffness_damping = 0.01}};
  const std::size_t points = model.bodies.points_rest().size();
  model.forces.assign(points, {0.01, 0, 0});
  SimulationSettings settings;
  settings.gravity = {};
  settings.solver.tolerance = 1e-10;
  Simulation simulation(std::move(model), settings, 1);
  const auto momentum = [&] {
    return mean_velocity(simulation, 0).x * simulation.masses()[0];  // accurate to the uniformity of the mesh
  };
  for (int i = 0; i < 20; ++i) simulation.step();
  EXPECT_NEAR(momentum(), 0.01 * static_cast<double>(points) * 0.2, 0.05 * momentum());
  for (std::size_t p = 0; p < points; ++p) simulation.set_force(static_cast<Index>(p), {});
  for (int i = 0; i < 100; ++i) simulation.step();
  const double before = momentum();
  for (int i = 0; i < 20; ++i) simulation.step();
  EXPECT_NEAR(momentum(), before, 1e-6 * before);
}

TEST(Grab, HoldsABodyByItsWeightOverItsStiffnessAndLetsGo) {
  Model model;
  model.bodies.add("block", test::box_mesh({2, 2, 2}, {0, 0, 0}, {0.04, 0.04, 0.04}));
  model.materials = {Material{.young_modulus = 1e6, .mass_damping = 10.0}};
  Simulation simulation(std::move(model), {}, 1);
  const Vec3 start =
      simulation.positions()[13];  // the centre point, so that the hanging block does not rotate
  ASSERT_EQ(start, (Vec3{0.02, 0.02, 0.02}));
  const Index number = simulation.grab({.point = 13, .target = start, .stiffness = 500.0});
  for (int i = 0; i < 600; ++i) simulation.step();
  const double weight = 9.81 * simulation.masses()[0];
  EXPECT_NEAR(simulation.grab_force(number).z, weight, 1e-4 * weight);
  EXPECT_EQ(simulation.grabs(), std::vector<Index>{number});
  EXPECT_EQ(simulation.grab_of(number).point, 13);
  const Wrench wrench = simulation.grab_wrench(0, simulation.positions()[13] - Vec3{0.1, 0.0, 0.0});
  EXPECT_EQ(wrench.force, simulation.grab_force(number));
  EXPECT_NEAR(wrench.torque.y, -0.1 * weight, 1e-4 * weight) << "x cross z is -y";
  EXPECT_NEAR(simulation.positions()[13].z, start.z - weight / 500.0, 1e-4 * weight / 500.0);

  simulation.move_grab(number, start + Vec3{0, 0, 0.5});
  for (int i = 0; i < 600; ++i) simulation.step();
  EXPECT_NEAR(simulation.positions()[13].z, start.z + 0.5 - weight / 500.0, 1e-4);

  simulation.release(number);
  EXPECT_TRUE(simulation.grabs().empty());
  EXPECT_EQ(simulation.grab_wrench(0, {}).force, Vec3{});
  simulation.step();
  simulation.step();
  EXPECT_LT(mean_velocity(simulation, 0).z, -0.1) << "falls";
  EXPECT_EQ(simulation.grab({.point = 0, .target = {}, .stiffness = 1.0}), number)
      << "the number is free again";
}

TEST(Grab, RefusesWhatIsNoGrab) {
  Model model;
  model.bodies.add("block", test::box_mesh({1, 1, 1}, {0, 0, 0}, {1, 1, 1}));
  model.materials = {Material{}};
  Simulation simulation(std::move(model), {}, 1);
  EXPECT_EQ(message([&] { simulation.grab({.point = 8, .target = {}, .stiffness = 1.0}); }),
            "grab: point: found 8, expected a point index in [0, 7]");
  EXPECT_EQ(message([&] { simulation.grab({.point = 0, .target = {}, .stiffness = 0.0}); }),
            "grab: stiffness: found 0, expected a finite number > 0");
  EXPECT_EQ(message([&] {
              simulation.grab({.point = 0, .target = {0, std::nan(""), 0}, .stiffness = 1.0});
            }),
            "grab: target: found a number that is not finite, expected three finite numbers");
  for (const Index number : {-1, 0, 1}) {
    EXPECT_EQ(message([&] { simulation.release(number); }),
              "grab: number: found " + std::to_string(number) + ", expected the number of an active grab");
  }
  EXPECT_EQ(message([&] { simulation.set_force(8, {}); }),
            "simulation: point: found 8, expected less than 8");
  EXPECT_EQ(message([&] {
              simulation.set_force(0, {INFINITY, 0, 0});
            }),
            "simulation: force: found a number that is not finite, expected three finite numbers");
}

/// A rigid body has a motion or stays: a force on it, or a grab, would do nothing.
TEST(Drive, ForcesAndGrabsOfRigidBodiesAreRefused) {
  Simulation simulation(block_on_plate({{}, {Keyframe{}}}), {}, 1);
  const Index own = simulation.bodies().bodies()[1].points.begin;
  const std::array<Index, 2> points{own, 0};
  EXPECT_EQ(
      message([&] {
        simulation.set_forces(points, std::array{Vec3{0, 0, 9}, Vec3{0, 0, 1}});
      }),
      "simulation: forces: found point 0 of the rigid body 'plate', expected points of bodies that deform");
  EXPECT_EQ(
      message([&] { simulation.grab({.point = 0, .target = {}, .stiffness = 100.0}); }),
      "simulation: grab: found point 0 of the rigid body 'plate', expected a point of a body that deforms");
  EXPECT_TRUE(simulation.grabs().empty());
  EXPECT_EQ(message([&] { simulation.set_forces(points, std::array{Vec3{}, Vec3{}}); }), "accepted");
  simulation.step();
  EXPECT_LT(mean_velocity(simulation, 1).z, 0.0) << "the force of the call that failed is not set";
}

/// A grab of a body that is not in the scene would report a force, and act after it is inserted.
TEST(Drive, ForcesAndGrabsOfRemovedBodiesAreRefused) {
  Simulation simulation(block_on_plate({{}, {Keyframe{}}}), {}, 1);
  const Index own = simulation.bodies().bodies()[1].points.begin;
  const std::string found = "found point " + std::to_string(own) + " of the removed body 'block', expected ";
  simulation.change({.remove = {1}});
  EXPECT_EQ(message([&] {
              simulation.set_forces(std::array{own}, std::array{Vec3{0, 0, 1}});
            }),
            "simulation: forces: " + found + "points of bodies that deform");
  EXPECT_EQ(message([&] { simulation.grab({.point = own, .target = {}, .stiffness = 100.0}); }),
            "simulation: grab: " + found + "a point of a body that deforms");
  simulation.change({.insert = {1}});
  simulation.grab({.point = own, .target = {}, .stiffness = 100.0});
}

}  // namespace
}  // namespace palpate
