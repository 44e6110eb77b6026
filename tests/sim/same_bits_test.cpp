// Whole runs end in the same state on every SIMD target with fused multiply-adds and with every compiler.
// Oracles: equality over targets; over compilers, hashes that each build must reproduce. If a change of the
// method changes them, put in those of g++ and run this test with clang too: ./dev test --preset clang -R
// SameState
#include <functional>
#include <gtest/gtest.h>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sim/examples.hpp"
#include "support/simd_targets.hpp"

namespace palpate::test {
namespace {

/// The state hash after every tenth step, so that a failure shows when two runs diverge.
std::vector<std::string> hashes(Simulation simulation, int steps) {
  std::vector<std::string> all;
  int steps_in_contact = 0;
  for (int i = 0; i < steps; ++i) {
    const DetectionCounts& counts = simulation.step().detection;
    steps_in_contact += counts.contacts + counts.edge_contacts > 0 ? 1 : 0;
    if ((i + 1) % 10 == 0) all.push_back(simulation.state_hash());
  }
  EXPECT_GT(steps_in_contact, steps / 10);
  return all;
}

void expect_same_state(const std::function<Simulation()>& make, int steps, const std::string& golden) {
  if (targets_of_same_bits() == 0) GTEST_SKIP() << "no SIMD target here fuses multiply-adds";
  std::vector<std::string> expected;
  for_each_simd_target(targets_of_same_bits(), [&](const char* target) {
    const std::vector<std::string> found = hashes(make(), steps);
    if (expected.empty()) expected = found;
    EXPECT_EQ(found, expected) << target;
    EXPECT_EQ(found.back(), golden) << target;
  });
}

/// The example "everything": friction, a prescribed rotation, an attachment, plastic tissue of two materials,
/// self-collision, a load and a grab.
TEST(SameState, Everything) {
  expect_same_state([] { return simulate(example("everything")); }, 120, "0f199996d0d214ec");
}

/// Two tissues that are tied to each other, side by side on a plate and on a third.
TEST(SameState, Ties) {
  constexpr const char* text = R"({
    "name": "ties", "time_step": 0.01, "duration": 1, "contact": {"friction": 0.3},
    "bodies": [
      {"name": "plate", "box": {"cells": [4, 4, 1], "size": [0.4, 0.4, 0.02]}, "translate": [0, 0, -0.01],
       "obstacle": true},
      {"name": "left", "box": {"cells": [5, 4, 3], "size": [0.05, 0.04, 0.03]}, "translate": [-0.0251, 0, 0.0151],
       "attached": [{"to": "right", "box": {"lower": [-0.001, -1, -1], "upper": [0, 1, 1]}}],
       "material": {"young_modulus": 20000, "poisson_ratio": 0.4}},
      {"name": "right", "box": {"cells": [4, 3, 3], "size": [0.05, 0.04, 0.03]}, "translate": [0.025, 0, 0.0301],
       "material": {"young_modulus": 50000, "poisson_ratio": 0.3}},
      {"name": "below", "box": {"cells": [3, 3, 2], "size": [0.06, 0.06, 0.014]}, "translate": [0.05, 0, 0.00701],
       "material": {"young_modulus": 10000, "poisson_ratio": 0.45}}
    ]})";
  expect_same_state([&] { return simulate(read_scene_text(text, "ties")); }, 40, "2e9909129c94e24e");
}

/// Many contacts with friction, and enough rows for several chunks of a reduction.
TEST(SameState, Stack) {
  expect_same_state([] { return simulate(read_scene(PALPATE_SOURCE_DIR "/scenes/stacking.json")); }, 20,
                    "ed16fe3cdfafc41b");
}

/// Three balls in rotating frames: one spins fast in the air, one fast and one slowly on a plate that tilts.
TEST(SameState, TurningBodies) {
  constexpr const char* text = R"({
    "name": "turning", "time_step": 0.01, "duration": 1, "contact": {"friction": 0.4},
    "bodies": [
      {"name": "plate", "box": {"cells": [4, 4, 1], "size": [0.4, 0.4, 0.02]}, "translate": [0, 0, -0.01],
       "motion": {"keyframes": [{"time": 0}, {"time": 0.4, "rotate": {"axis": [1, 2, 0.5], "angle": 25}}]}},
      {"name": "wheel", "ball": {"radius": 0.03, "resolution": 3}, "translate": [0, 0, 0.031],
       "rotate": {"axis": [1, 1, 0], "angle": 33}, "material": {"young_modulus": 2e5, "poisson_ratio": 0.45}},
      {"name": "ball", "ball": {"radius": 0.03, "resolution": 2}, "translate": [0, 0.1, 2],
       "material": {"young_modulus": 2e5, "poisson_ratio": 0.3}},
      {"name": "roller", "ball": {"radius": 0.03, "resolution": 4}, "translate": [-0.1, 0, 0.0301],
       "material": {"young_modulus": 1e5, "poisson_ratio": 0.3}}
    ]})";
  const auto make = [&] {
    const Scene scene = read_scene_text(text, "turning");
    Model model = load_model(scene, [](const std::filesystem::path& path) -> TetMesh {
      throw Error(path.string(), "", "a mesh file", "none in this scene");
    });
    const std::span<const Vec3> points = model.bodies.points_rest();
    model.velocities.resize(points.size());
    const auto spin = [&](std::size_t body, const Vec3& centre, const Vec3& angular_velocity) {
      const Range own = model.bodies.bodies()[body].points;
      for (Index p = own.begin; p < own.end; ++p)
        at(model.velocities, p) = cross(angular_velocity, at(points, p) - centre);
    };
    spin(1, {0.0, 0.0, 0.031}, {3.0, 40.0, 8.0});
    spin(2, {0.0, 0.1, 2.0}, {3.0, 40.0, 8.0});
    spin(3, {-0.1, 0.0, 0.0301}, {0.0, 6.0, 0.0});
    return Simulation(std::move(model), scene.settings, 2);
  };
  expect_same_state(make, 40, "57ed81cb33847188");
}

}  // namespace
}  // namespace palpate::test
