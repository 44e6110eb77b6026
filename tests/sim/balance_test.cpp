// Blocks of soft tissue to bone lie on floors and slopes, are pushed, squeezed, dropped and stacked. Oracles:
// Coulomb's and Newton's laws, for the forces that steps report, too.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <string>

#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"

namespace palpate::test {
namespace {

constexpr double gravity = 9.81;

struct Slope {
  double young_modulus = 1e9;
  double time_step = 0.01;
  double size = 0.02;
  double overlap = 1e-6;  ///< with the floor at the start, relative to the size
  int cells = 1;
};

/// Speed of a block after 0.3 s and at least ten steps on a slope of 25 degrees with friction 0.3, relative
/// to that by Coulomb's law.
double relative_speed(const Slope& slope) {
  constexpr double angle = 0.4363;
  constexpr double friction = 0.3;
  const double s = slope.size;
  const double lowest = -slope.overlap * s;
  Model model;
  model.bodies.add("floor", box_mesh({1, 1, 1}, {-4, -4, -0.2}, {4, 4, 0}));
  model.bodies.add("block", box_mesh({slope.cells, slope.cells, slope.cells}, {-s / 2, -s / 2, lowest},
                                     {s / 2, s / 2, lowest + s}));
  model.materials = {Material{}, {.young_modulus = slope.young_modulus}};
  model.obstacles = {true, false};
  SimulationSettings settings;
  settings.time_step = slope.time_step;
  settings.gravity = {gravity * std::sin(angle), 0, -gravity * std::cos(angle)};
  settings.response.friction = friction;
  Simulation simulation(std::move(model), settings, 1);
  const int steps = std::max(10, static_cast<int>(std::lround(0.3 / slope.time_step)));
  const double first = simulation.center_of_mass(1).x;
  for (int step = 0; step < steps; ++step) simulation.step();
  // Implicit Euler from rest: the sum of all speeds.
  const double acceleration = gravity * (std::sin(angle) - friction * std::cos(angle));
  const double expected = acceleration * slope.time_step * slope.time_step * steps * (steps + 1) / 2.0;
  return (simulation.center_of_mass(1).x - first) / expected;
}

/// Number of blocks whose way is off by more than a tenth, and of all.
template <std::size_t A, std::size_t B, std::size_t C>
std::pair<int, int> blocks_that_are_off(const std::array<double, A>& moduli,
                                        const std::array<double, B>& time_steps,
                                        const std::array<double, C>& overlaps) {
  std::pair<int, int> off;
  for (const double young_modulus : moduli)
    for (const double time_step : time_steps)
      for (const double overlap : overlaps)
        for (const double size : {0.02, 0.1})
          for (const int cells : {1, 2}) {
            const double found = relative_speed({young_modulus, time_step, size, overlap, cells});
            ++off.second;
            if (std::abs(found - 1.0) < 0.1) continue;
            ++off.first;
            std::printf("%g Pa, %g s, overlap %g, size %g, %d cells: %g\n", young_modulus, time_step, overlap,
                        size, cells, found);
          }
  return off;
}

/// They stood still or hung in the air, and steps counted as converged.
TEST(Balance, BlocksThatOverlapASlopeSlideDown) {
  const auto [off, all] = blocks_that_are_off(std::array{1e7, 1e8, 1e9}, std::array{0.01, 0.05},
                                              std::array{1e-8, 1e-6, 1e-5, 1e-4});
  EXPECT_EQ(all, 96);
  EXPECT_EQ(off, 0);
}

TEST(Balance, DISABLED_NearlyAllBlocksSlideDown) {
  const auto [off, all] =
      blocks_that_are_off(std::array{1e6, 1e7, 1e8, 1e9, 1e10}, std::array{0.005, 0.01, 0.02, 0.05},
                          std::array{0.0, 1e-8, 1e-6, 1e-5, 1e-4, 1e-3});
  EXPECT_EQ(all, 480);
  EXPECT_LE(off, 3);  // of 10 GPa in steps of 50 ms
}

/// A block on a floor, with a tool that pushes it, two that squeeze and lift it, or a block on top.
Simulation random_scene(Random& random) {
  constexpr std::array moduli{1e6, 1e8, 1e9, 1e10, 2e11};
  constexpr std::array time_steps{0.002, 0.01, 0.02};
  constexpr std::array sizes{0.01, 0.03, 0.1};
  constexpr std::array densities{1000.0, 2000.0, 7800.0};
  const auto one_of = [&](const auto& values) {
    return values[static_cast<std::size_t>(random.integer(0, static_cast<int>(values.size()) - 1))];
  };
  const double s = one_of(sizes);
  const int n = random.integer(1, 3);
  const Material material{.young_modulus = one_of(moduli), .density = one_of(densities)};
  const int kind = random.integer(0, 3);
  const auto box = [&](int cells, double size, const Vec3& low) {
    return box_mesh({cells, cells, cells}, low, low + Vec3{size, size, size});
  };
  Model model;
  const auto add = [&](const std::string& name, TetMesh mesh, const Material& of, bool obstacle) {
    model.bodies.add(name, std::move(mesh));
    model.materials.push_back(of);
    model.obstacles.push_back(obstacle);
  };
  add("floor", box_mesh({1, 1, 1}, {-40 * s, -40 * s, -s}, {40 * s, 40 * s, 0}), {}, true);
  TetMesh block = box(n, s, {-s / 2, -s / 2, kind == 1 ? s : 0.0});
  if (kind == 2) {  // dropped
    const double angle = random.uniform(0.0, 1.2);
    for (Vec3& p : block.points) p = rotated(p, {1, 2, 3}, angle) + Vec3{0, 0, 2 * s};
  }
  add("block", std::move(block), material, false);
  model.motion_of_point.assign(model.bodies.points_rest().size(), -1);
  const auto add_tool = [&](const std::string& name, const Vec3& low, std::vector<Keyframe> keyframes) {
    add(name, box(1, s, low), {}, true);
    model.motion_of_point.resize(model.bodies.points_rest().size(), static_cast<Index>(model.motions.size()));
    model.motions.push_back({.keyframes = std::move(keyframes)});
  };
  if (kind == 0) {
    add_tool("tool", {-1.52 * s, -s / 2, 0.1 * s},
             {{.time = 0.02}, {.time = 1.0, .translate = {8 * s, 0, 0}}});
  } else if (kind == 1) {
    for (const double side : {-1.0, 1.0}) {
      const Vec3 closed{-side * 0.021 * s, 0, 0};
      add_tool(side < 0.0 ? "left" : "right", {side * 1.02 * s - s / 2, -s / 2, s},
               {{.time = 0.0},
                {.time = 0.1, .translate = closed},
                {.time = 0.3, .translate = closed},
                {.time = 0.5, .translate = closed + Vec3{0, 0, s}}});
    }
  } else if (kind == 3) {
    Material other = material;
    other.young_modulus =
        std::min(moduli.back(), other.young_modulus * std::pow(100.0, random.integer(-1, 1)));
    other.density *= std::pow(10.0, random.integer(0, 1));
    add("upper", box(n, s, {-0.4 * s, -s / 2, 1.001 * s}), other, false);
    model.motion_of_point.resize(model.bodies.points_rest().size(), -1);
  }
  SimulationSettings settings;
  settings.time_step = one_of(time_steps);
  settings.gravity = {0, 0, -gravity};
  settings.response.friction = random.chance(0.5) ? 0.3 : 0.8;
  return {std::move(model), settings, 1};
}

/// Largest force that is out of balance in a converged step that was not divided, relative to the larger one
/// of weight and contact force of the body.
double worst_imbalance(Simulation simulation, double time_step) {
  const std::size_t points = simulation.positions().size();
  const auto momenta = [&] {
    std::vector<Vec3> sums(simulation.masses().size());
    for (std::size_t i = 0; i < points; ++i)
      at(sums, simulation.bodies().body_of_point()[i]) +=
          simulation.point_masses()[i] * simulation.velocities()[i];
    return sums;
  };
  double worst = 0.0;
  std::vector<Vec3> before = momenta();
  for (int step = 0; step < 100 && simulation.metrics().time < 1.0; ++step) {
    const StepMetrics& metrics = simulation.step();
    const std::vector<Vec3> after = momenta();
    for (std::size_t body = 0; body < after.size(); ++body) {
      const std::string& name = simulation.bodies().bodies()[body].name;
      const bool is_free = name == "block" || name == "upper";
      const double mass = simulation.masses()[body];
      if (!is_free || !metrics.solver_converged || metrics.substeps > 1) continue;
      const Vec3 force = simulation.contact_forces()[body];
      const Vec3 lacking =
          (1.0 / time_step) * (after[body] - before[body]) + Vec3{0, 0, mass * gravity} - force;
      worst = std::max(worst, length(lacking) / std::max(mass * gravity, length(force)));
    }
    before = after;
  }
  return worst;
}

int scenes_out_of_balance(std::uint64_t first, std::uint64_t count) {
  int bad = 0;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    Random random(seed);
    Simulation simulation = random_scene(random);
    const double time_step = simulation.settings().time_step;
    const double worst = worst_imbalance(std::move(simulation), time_step);
    if (worst <= 0.05) continue;
    ++bad;
    std::printf("seed %d: %g\n", static_cast<int>(seed), worst);
  }
  return bad;
}

/// A fifth of such scenes had steps in which up to the whole weight was lacking.
TEST(Balance, ContactForcesOfConvergedStepsBalanceWeightAndAcceleration) {
  EXPECT_EQ(scenes_out_of_balance(1, 60), 0);
}

TEST(Balance, DISABLED_ContactForcesOfManyScenesBalance) {
  EXPECT_EQ(scenes_out_of_balance(1000, 500), 0);
}

}  // namespace
}  // namespace palpate::test
