// No step asks for memory once the first ten of a steady run are done.
#include <gtest/gtest.h>

#include <palpate/simulation.hpp>

#include "contact/variants.hpp"
#include "support/count_allocations.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

/// Four soft slabs on a plate, with about the overlaps that their weight causes.
Simulation resting_stack(const DetectionSettings& detection, int threads) {
  Bodies bodies;
  bodies.add("plate", test::box_mesh({7, 7, 1}, {-0.12, -0.12, -0.02}, {0.12, 0.12, 0.0}));
  std::vector<Material> materials{Material{}};
  for (int slab = 0; slab < 4; ++slab) {
    const double z = 0.02 * slab - 1e-4 * (slab + 1);
    bodies.add("slab " + std::to_string(slab),
               test::box_mesh({8 - slab, 8, 1}, {-0.08, -0.08, z}, {0.08, 0.08, z + 0.02}));
    // So soft that points still change their cells while the slabs settle.
    materials.push_back(Material{.young_modulus = 3e4, .mass_damping = 2.0, .stiffness_damping = 2e-3});
  }
  SimulationSettings settings;
  settings.detection = detection;
  settings.response.friction = 0.3;
  return Simulation(
      {.bodies = std::move(bodies), .materials = std::move(materials), .obstacles = {1, 0, 0, 0, 0}},
      settings, threads);
}

TEST(SimulationAllocations, AStepOfARestingStackMakesNone) {
  for (const DetectionSettings& variant : test::every_variant()) {
    for (const int threads : {1, 2}) {
      Simulation simulation = resting_stack(variant, threads);
      for (int step = 0; step < 13; ++step) simulation.step();  // the last ones make the multigrid
      const long before = allocations;
      ASSERT_GT(before, 0) << "allocations are not counted";
      std::size_t movers = 0;
      for (int step = 0; step < 87; ++step) movers += simulation.step().detection.movers;
      EXPECT_EQ(allocations - before, 0) << test::name_of(variant) << ", " << threads << " threads";
      EXPECT_GT(simulation.metrics().detection.contacts, 200U);
      EXPECT_GT(simulation.metrics().detection.crossings, 200U);
      EXPECT_GT(simulation.metrics().solver_iterations, 0);
      EXPECT_LT(simulation.metrics().fastest_body, 0.05) << "it rests, but for a tremble";
      EXPECT_GT(movers, 0U) << "some points change their cell";
    }
  }
}

}  // namespace
}  // namespace palpate
