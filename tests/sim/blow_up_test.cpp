// Runs that must stop: their messages, and that the last good state is kept.
#include <algorithm>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include <palpate/error.hpp>
#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "sim/response.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

/// A plate that stands still and a box above it.
Bodies plate_and_box() {
  Bodies bodies;
  bodies.add("plate", test::box_mesh({2, 2, 1}, {-0.5, -0.5, -0.1}, {0.5, 0.5, 0.0}));
  bodies.add("liver", test::box_mesh({2, 2, 2}, {-0.1, -0.1, 1.0}, {0.1, 0.1, 1.2}));
  return bodies;
}

Model plate_and_box_model() {
  return {.bodies = plate_and_box(), .materials = {Material{}, Material{}}, .obstacles = {1, 0}};
}

std::string message_of_step(Simulation& simulation) {
  try {
    simulation.step();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

void expect_last_state_kept(Simulation& simulation, const std::string& start, const std::string& end) {
  std::string hash = simulation.state_hash();
  StepMetrics metrics = simulation.metrics();
  std::vector<Index> contacts = simulation.detector().contacts().point;
  std::vector<Vec3> forces(simulation.contact_forces().begin(), simulation.contact_forces().end());
  std::string message;
  for (int n = 0; n < 2000; ++n) {
    message = message_of_step(simulation);
    if (message != "no error") break;
    hash = simulation.state_hash();
    metrics = simulation.metrics();
    contacts = simulation.detector().contacts().point;
    forces.assign(simulation.contact_forces().begin(), simulation.contact_forces().end());
  }
  EXPECT_TRUE(message.starts_with(start)) << message;
  EXPECT_TRUE(message.ends_with(end)) << message;
  EXPECT_NE(message.find(", step " + std::to_string(metrics.step + 1) + ": "), std::string::npos) << message;
  EXPECT_EQ(simulation.state_hash(), hash);
  EXPECT_EQ(simulation.metrics().step, metrics.step);
  EXPECT_EQ(simulation.metrics().time, metrics.time);
  EXPECT_EQ(simulation.metrics().kinetic_energy, metrics.kinetic_energy);
  EXPECT_EQ(simulation.metrics().solver_iterations, metrics.solver_iterations);
  EXPECT_EQ(simulation.metrics().detection.contacts, metrics.detection.contacts);
  EXPECT_EQ(simulation.detector().contacts().point, contacts);
  EXPECT_TRUE(std::ranges::equal(simulation.contact_forces(), forces));
  EXPECT_EQ(message_of_step(simulation), message) << "the step can be tried again";
}

TEST(BlowUp, SpeedAboveTheLimit) {
  SimulationSettings settings;
  settings.limits.max_speed = 1.0;
  Simulation simulation(plate_and_box_model(), settings, 1);
  // 9.81 m/s^2 for 10 ms a step: the first speed above 1 m/s is that of step 11.
  expect_last_state_kept(simulation, "body liver: tet ", ", expected at most 1 (limits.max_speed)");
  EXPECT_EQ(simulation.metrics().step, 10);
}

TEST(BlowUp, WithoutALimitItIsAHundredDiagonalsAStep) {
  Bodies bodies;
  bodies.add("box", test::box_mesh({1, 1, 1}, {0, 0, 0}, {1, 2, 2}));
  SimulationSettings settings;
  settings.gravity = {};  // free fall would raise the limit
  settings.time_step = 0.1;
  const std::vector<Vec3> forces(8, {0, 0, 1e9});  // on about 500 kg each
  Simulation simulation({.bodies = std::move(bodies), .materials = {Material{}}, .forces = forces}, settings,
                        1);
  const std::string message = message_of_step(simulation);
  EXPECT_TRUE(message.ends_with(", expected at most 3000 (limits.max_speed)")) << message;
  EXPECT_TRUE(message.starts_with("body box: tet ")) << message;  // the fastest corner depends on rounding
  EXPECT_NE(message.find(", step 1: found a speed of 2487"), std::string::npos) << message;
}

TEST(BlowUp, AFreeFallIsNoneHoweverSmallTheBody) {
  Bodies bodies;
  bodies.add("drop", test::ball_mesh(2, {0, 0, 0}, 5e-4));
  SimulationSettings settings;
  settings.time_step = 0.02;
  Simulation simulation({.bodies = std::move(bodies), .materials = {Material{}}}, settings, 1);
  for (int i = 0; i < 200; ++i) simulation.step();
  EXPECT_NEAR(simulation.metrics().largest_speed, 9.81 * 4.0, 1e-6)
      << "a hundred diagonals a step are 8.7 m/s";
}

TEST(BlowUp, NumbersThatAreNotFinite) {
  SimulationSettings settings;
  settings.gravity = {0, 0, -1e308};
  Simulation simulation(plate_and_box_model(), settings, 1);
  expect_last_state_kept(simulation, "body liver: tet ", "");
  EXPECT_EQ(simulation.metrics().step, 0);
}

TEST(BlowUp, ATetThatStaysInverted) {
  // Much too soft for its weight: it falls through its own fixed bottom and hangs below it, inverted.
  SimulationSettings settings;
  settings.limits.inverted_time = 0.4;
  Bodies bodies = plate_and_box();
  std::vector<std::uint8_t> fixed;
  for (const Vec3& p : bodies.points_rest()) fixed.push_back(p.z == 1.0 ? 1 : 0);
  const Material material{.young_modulus = 300.0, .poisson_ratio = 0.0, .mass_damping = 20.0};
  Simulation simulation({.bodies = std::move(bodies),
                         .materials = {material, material},
                         .fixed_points = fixed,
                         .obstacles = {1, 0}},
                        settings, 1);
  expect_last_state_kept(simulation, "body liver: tet ", ", expected less than 0.4 s (limits.inverted_time)");
  EXPECT_GT(simulation.metrics().step, 40);
}

/// A box that is pressed into a plate.
Simulation pressed_box(const SimulationSettings& settings) {
  Bodies bodies;
  bodies.add("plate", test::box_mesh({8, 8, 1}, {-0.5, -0.5, -0.1}, {0.5, 0.5, 0.0}));
  bodies.add("box", test::box_mesh({8, 8, 4}, {-0.2, -0.2, -0.005}, {0.2, 0.2, 0.2}));
  return {
      {.bodies = std::move(bodies), .materials = {Material{}, Material{}}, .obstacles = {1, 0}}, settings, 1};
}

TEST(BlowUp, AStepThatFailsFindsNoOtherContacts) {
  // Approximate mode and budgets choose differently in each detection.
  SimulationSettings approximate;
  approximate.detection.cells_per_primitive = 1;
  approximate.detection.cell_size = 0.02;
  SimulationSettings limited;
  limited.detection.budget = Budget{.tests = 20};
  for (SimulationSettings settings : {approximate, limited}) {
    // Iteration counts of a failed solve may affect the choice of the preconditioner.
    settings.solver.preconditioner = Preconditioner::jacobi;
    Simulation failing = pressed_box(settings);
    Simulation control = pressed_box(settings);
    std::size_t incomplete = 0;
    for (int n = 0; n < 12; ++n) {
      if (n % 3 == 2) {
        const Contacts before = failing.detector().contacts();
        SimulationSettings impossible = settings;
        impossible.limits.max_speed = 1e-15;
        failing.change(impossible);
        EXPECT_NE(message_of_step(failing), "no error");
        failing.change(settings);
        EXPECT_EQ(failing.detector().contacts().tet, before.tet);
        EXPECT_EQ(failing.detector().contacts().depth, before.depth);
      }
      failing.step();
      const StepMetrics& metrics = control.step();
      incomplete += metrics.detection.dropped_cells > 0 || metrics.detection.completeness < 1.0 ? 1 : 0;
      ASSERT_EQ(failing.state_hash(), control.state_hash()) << "step " << n;
    }
    EXPECT_GT(incomplete, 3U) << "or there is nothing to choose, "
                              << (settings.detection.budget ? "budget" : "approximate");
  }
}

TEST(BlowUp, LimitsOutOfRangeAreRefused) {
  const auto message = [&](const LimitSettings& limits) -> std::string {
    SimulationSettings settings;
    settings.limits = limits;
    try {
      Simulation(plate_and_box_model(), settings, 1);
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message({}), "accepted");
  EXPECT_EQ(message({.max_speed = 0.0}),
            "simulation settings: limits.max_speed: found 0, expected a finite number > 0");
  EXPECT_EQ(message({.inverted_time = 0.0}),
            "simulation settings: limits.inverted_time: found 0, expected a finite number > 0");
}

TEST(Regions, ContactStiffnessComesFromTheMeanByVolume) {
  Bodies bodies = plate_and_box();
  const auto plate_tets = static_cast<std::size_t>(bodies.bodies()[0].tets.size());
  std::vector<Index> of_tet(bodies.tets().size(), 1);
  std::fill_n(of_tet.begin(), plate_tets, 0);
  for (std::size_t t = plate_tets; t < plate_tets + 12; ++t) of_tet[t] = 2;  // a quarter of 48 equal tets
  const std::vector<Material> materials{{}, {.young_modulus = 1000.0}, {.young_modulus = 9000.0}};
  Simulation simulation(
      {.bodies = std::move(bodies), .materials = materials, .material_of_tet = of_tet, .obstacles = {1, 0}},
      {}, 1);
  ASSERT_EQ(simulation.contact_materials().size(), 2U);
  EXPECT_NEAR(simulation.contact_materials()[1].young_modulus, 3000.0, 1e-9);
  EXPECT_EQ(simulation.contact_materials()[0].young_modulus, Material{}.young_modulus);
}

}  // namespace
}  // namespace palpate
