// The paper's stacking scene as it ships. Oracles: brute force at every tenth step of a whole run, equality
// over thread counts, and the weight of the stack.
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <initializer_list>
#include <string>

#include <palpate/error.hpp>
#include <palpate/simulation.hpp>

#include "contact/variants.hpp"
#include "geometry/vector.hpp"
#include "scene/generators.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"
#include "support/mean.hpp"

namespace palpate {
namespace {

Simulation stacking(int threads, Structure structure = Structure::compact, Order order = Order::linear,
                    Sort sort = Sort::adaptive) {
  Scene scene = read_scene(PALPATE_SOURCE_DIR "/scenes/stacking.json");
  scene.settings.detection.structure = structure;
  scene.settings.detection.order = order;
  scene.settings.detection.sort = sort;
  Model model = load_model(scene, [](const std::filesystem::path& path) -> TetMesh {
    throw Error(path.string(), "", "a mesh file", "none in this scene");
  });
  return Simulation(std::move(model), scene.settings, threads);
}

std::string hash_of(Simulation simulation, int steps) {
  for (int i = 0; i < steps; ++i) simulation.step();
  EXPECT_GT(simulation.metrics().detection.contacts, 3000U);
  return simulation.state_hash();
}

void expect_the_same_for_thread_counts(std::initializer_list<int> counts, int steps) {
  const std::string one = hash_of(stacking(1), steps);
  for (const int threads : counts) EXPECT_EQ(hash_of(stacking(threads), steps), one) << threads << " threads";
}

/// Each `stride`-th variant, brute force included, on other threads than the one before.
void expect_the_same_for_variants(std::size_t stride, int steps) {
  constexpr std::array<int, 4> threads{1, 2, 3, 7};
  const auto variants = test::every_variant();
  ASSERT_EQ(variants.size(), 16U);
  std::string expected;
  for (std::size_t i = 0; i < variants.size(); i += stride) {
    const DetectionSettings& variant = variants[i];
    const std::string hash =
        hash_of(stacking(threads[i % threads.size()], variant.structure, variant.order, variant.sort), steps);
    if (expected.empty()) expected = hash;
    EXPECT_EQ(hash, expected) << test::name_of(variant);
  }
}

TEST(Stacking, HashIsTheSameForThreadCountsStructuresOrdersAndSorts) {
  expect_the_same_for_variants(5, 40);
}

TEST(Stacking, DISABLED_HashAfter200StepsIsTheSameForEveryThreadCount) {
  expect_the_same_for_thread_counts({2, 3, 7}, 200);
}

TEST(Stacking, DISABLED_HashAfter200StepsIsTheSameForEveryStructureOrderAndSort) {
  expect_the_same_for_variants(1, 200);
}

TEST(Stacking, ContactsEqualBruteForceOverAWholeRunAndItComesToRest) {
  Simulation simulation = stacking(2);
  DetectionSettings settings;
  settings.structure = Structure::brute;
  std::vector<std::uint8_t> immovable(20, 0);
  immovable[0] = 1;
  Detector brute(simulation.bodies(), settings, immovable, 2);
  std::size_t most = 0;
  while (!simulation.at_rest() && simulation.metrics().step < 1000) {
    simulation.step();
    if (simulation.metrics().step % 10 != 0) continue;
    brute.detect(simulation.positions());
    const Contacts& a = simulation.detector().contacts();
    const Contacts& b = brute.contacts();
    ASSERT_EQ(a.point, b.point) << "step " << simulation.metrics().step;
    ASSERT_EQ(a.body, b.body);
    ASSERT_EQ(a.tet, b.tet);
    ASSERT_EQ(a.depth, b.depth);
    ASSERT_EQ(simulation.detector().crossings().size(), brute.crossings().size());
    most = std::max(most, a.size());
  }
  EXPECT_GT(most, 3000U);
  ASSERT_TRUE(simulation.at_rest());
  double weight = 0.0;
  for (std::size_t b = 1; b < 20; ++b) weight += 9.81 * simulation.masses()[b];
  EXPECT_NEAR(weight, 9.81 * 19 * 0.4, 1e-9);
  EXPECT_NEAR(-simulation.contact_forces()[0].z, weight, 0.01 * weight);

  // It stays at rest: over two seconds nothing drifts, no body is faster than the rest speed, and motion
  // decreases.
  for (int i = 0; i < 200; ++i) simulation.step();
  const auto top_centre = [&] { return test::mean_of_body(simulation.bodies(), 19, simulation.positions()); };
  const Vec3 before = top_centre();
  for (int i = 0; i < 400; ++i) {
    simulation.step();
    ASSERT_TRUE(simulation.at_rest()) << "step " << simulation.metrics().step;
  }
  EXPECT_LT(length(top_centre() - before), 1e-4);
  EXPECT_LT(simulation.metrics().kinetic_energy, 1e-7) << "1e-4 m/s: a tenth of the rest speed";
}

/// The stack of the paper at rest: between membranes k and k + 1 acts the weight of those above.
TEST(Stacking, TheWrenchBetweenTwoMembranesIsTheWeightAbove) {
  Scene scene = make_stacking_scene();
  scene.settings.solver.tolerance = 1e-6;
  scene.settings.rest.speed = 2e-5;  // m/s in 10 ms: 2e-4 of g, of one membrane
  Simulation simulation(load_model(scene, {}), scene.settings, 2);
  while (!simulation.at_rest() && simulation.metrics().step < 3000) simulation.step();
  ASSERT_TRUE(simulation.at_rest());
  double above = 0.0;
  std::vector<double> weights(20, 0.0);
  for (std::size_t b = 19; b > 0; --b) weights[b] = above += 9.81 * simulation.masses()[b];
  std::size_t neighbours = 0;
  for (const PairWrench& pair : simulation.pair_wrenches()) {
    ASSERT_EQ(pair.body_b, pair.body_a + 1) << "membranes touch their neighbours only";
    ++neighbours;
    EXPECT_NEAR(pair.on_b.force.z, at(weights, pair.body_b), 1e-3 * at(weights, pair.body_b))
        << pair.body_a << " and " << pair.body_b;
    EXPECT_GE(pair.normal, (1.0 - 1e-3) * at(weights, pair.body_b));
  }
  EXPECT_EQ(neighbours, 19U);
}

}  // namespace
}  // namespace palpate
