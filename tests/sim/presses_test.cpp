// Thin tools that are pressed slowly into thin sheets do not go through, or it is counted. Their motion in a
// step is a quarter of the thickness or less (rarely up to 29 %), so there is no search for passes within a
// step. Oracle: the inner parts of tool and sheet do not cross.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <gtest/gtest.h>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "scene/generators.hpp"
#include "sim/shots.hpp"

namespace palpate::test {
namespace {

struct Press {
  std::array<ShotBody, 2> bodies;  ///< sheet, tool
  Model model;
  SimulationSettings settings;
  int steps = 0;
  bool six_tets = false;  ///< cells have six tets each (Kuhn), else five
  std::string name;
};

/// A bar that a motion presses into the middle of a sheet whose border is fixed, by 10 to 70 % of half the
/// width of the sheet. Thickness, cells, stiffness, friction, time step, and the place and direction of the
/// bar are random.
Press random_press(std::uint64_t seed) {
  Random random(seed);
  Press press;
  const double width = random.uniform(0.01, 0.04);  // half of it, m
  const double thick = width * random.uniform(0.015, 0.08);
  const int cells = random.integer(4, 10);
  const bool kuhn = random.chance(0.5);
  press.six_tets = kuhn;
  const auto box = [&](const std::array<int, 3>& n, const Vec3& size) {
    return kuhn ? box_mesh(n, -0.5 * size, 0.5 * size) : make_box(n, size);
  };
  press.bodies[0] = {
      "sheet", box({cells, cells, 1}, {2.0 * width, 2.0 * width, thick}), {0.98, 0.98, 0.2}, thick};
  const double half = random.uniform(0.0005, 0.002);
  const double reach = 0.5 * width * random.uniform(0.3, 1.2);
  const int along = random.integer(1, 10);
  press.bodies[1] = {
      "bar", box({along, 1, 1}, {2.0 * reach, 2.0 * half, 2.0 * half}), {0.9, 0.2, 0.2}, 2.0 * half};
  const double distance = width * random.uniform(0.1, 0.7);
  const double motion = random.uniform(0.02, 0.24) * std::min(thick, 2.0 * half);
  press.steps = static_cast<int>(std::ceil(distance / motion));
  press.settings.time_step = 0.001 * std::pow(20.0, random.uniform(0.0, 1.0));
  press.settings.gravity = {};
  press.settings.response.friction = random.chance(0.5) ? 0.0 : 0.3;
  constexpr double quarter = 0.785398163397448;
  const double roll = random.chance(0.3) ? quarter : random.uniform(0.0, 2.0 * quarter);
  const double tilt = random.chance(0.5) ? 0.0 : random.uniform(-0.3, 0.3);
  const double turn = random.chance(0.3) ? 0.0 : random.uniform(0.0, 4.0 * quarter);
  const Vec3 aside =
      random.chance(0.3) ? Vec3{} : width * Vec3{random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), 0.0};
  TetMesh bar = press.bodies[1].mesh;
  double lowest = 0.0;
  for (Vec3& p : bar.points) {
    p = aside + rotated(rotated(rotated(p, {1, 0, 0}, roll), {0, 1, 0}, tilt), {0, 0, 1}, turn);
    lowest = std::min(lowest, p.z);
  }
  for (Vec3& p : bar.points) p.z += thick / 2 + motion - lowest;
  Model& model = press.model;
  for (const Vec3& p : press.bodies[0].mesh.points) {
    const bool at_border = std::max(std::abs(p.x), std::abs(p.y)) > 0.999 * width;
    model.fixed_points.push_back(at_border ? 1 : 0);
    model.motion_of_point.push_back(-1);
  }
  model.fixed_points.resize(model.fixed_points.size() + bar.points.size(), 0);
  model.motion_of_point.resize(model.fixed_points.size(), 0);
  model.bodies.add("sheet", press.bodies[0].mesh);
  model.bodies.add("bar", std::move(bar));
  const double modulus = std::pow(10.0, random.uniform(4.0, 8.0));
  model.materials = {{.young_modulus = modulus}, {}};
  model.obstacles = {0, 1};
  const double end = press.steps * press.settings.time_step;
  model.motions = {{.keyframes = {{}, {.time = end, .translate = {0, 0, -(distance + motion)}}}}};
  char text[200];
  std::snprintf(text, sizeof text,
                "seed %d: sheet %.1f x %.2f mm, %d cells of %d tets, E %.1f kPa; bar %.1f x %.1f mm, by %.1f "
                "mm in %d steps",
                static_cast<int>(seed), 2e3 * width, 1e3 * thick, cells, kuhn ? 6 : 5, 1e-3 * modulus,
                2e3 * reach, 2e3 * half, 1e3 * distance, press.steps);
  press.name = text;
  return press;
}

struct PressResult {
  int through_step = 0;     ///< first step after which the inner parts of tool and sheet cross; 0: none
  std::int64_t passes = 0;  ///< counted until then
  int inverted_tets = 0;    ///< most in a step until then
};

PressResult result_of(const Press& press) {
  Simulation simulation(press.model, press.settings, 1);
  const Bodies& bodies = simulation.bodies();
  Core sheet(bodies, 0, press.bodies[0].core, press.bodies[0].mesh);
  Core bar(bodies, 1, press.bodies[1].core, press.bodies[1].mesh);
  PressResult result;
  for (int step = 1; step <= press.steps && result.through_step == 0; ++step) {
    const StepMetrics& m = simulation.step();
    result.passes += m.passes;
    result.inverted_tets = std::max(result.inverted_tets, static_cast<int>(m.inverted_tets));
    for (Core* core : {&sheet, &bar}) core->put(simulation.positions(), simulation.positions(), 1.0);
    if (sheet.box().overlaps(bar.box()) && !sheet.crossings(bar).empty()) result.through_step = step;
  }
  return result;
}

struct Presses {
  int through = 0;
  int through_six_tets = 0;  ///< of those, sheets with cells of six tets
  int intact = 0;            ///< of those that went through, without inverted tets
  int unseen = 0;            ///< of those that went through, without a pass that was counted
};

Presses press_all(std::span<const std::uint64_t> seeds) {
  Presses presses;
  for (const std::uint64_t seed : seeds) {
    const Press press = random_press(seed);
    const PressResult result = result_of(press);
    if (result.through_step == 0) continue;
    ++presses.through;
    presses.through_six_tets += press.six_tets ? 1 : 0;
    presses.intact += result.inverted_tets == 0 ? 1 : 0;
    presses.unseen += result.passes == 0 ? 1 : 0;
    std::printf("through in step %d, %lld passes, %d inverted tets: %s\n", result.through_step,
                static_cast<long long>(result.passes), result.inverted_tets, press.name.c_str());
  }
  std::printf("%d of %zu went through: %d without inverted tets, %d without a pass that was counted\n",
              presses.through, seeds.size(), presses.intact, presses.unseen);
  return presses;
}

/// Before contacts were kept on their side, the tool went through in all of these, and it was not counted, or
/// no tet was inverted.
TEST(SweptPresses, ASlowThinToolGoesThroughNoIntactSheetAndIsCounted) {
  constexpr auto seeds = std::to_array<std::uint64_t>(
      {16, 47, 1008, 1026, 1174, 1267, 1284, 1301, 1317, 1325, 1631, 1699, 1796, 1964, 1980, 1985});
  const Presses presses = press_all(seeds);
  EXPECT_LE(presses.through, 8);
  EXPECT_EQ(presses.intact, 0);
  EXPECT_EQ(presses.unseen, 0);
}

TEST(SweptPresses, DISABLED_OfThousandSlowToolsFewGoThroughAndNoneThroughAnIntactSheet) {
  std::vector<std::uint64_t> seeds(1000);
  std::iota(seeds.begin(), seeds.end(), std::uint64_t{1000});
  const Presses presses = press_all(seeds);
  // A cell of five tets is inverted as soon as it is twisted by more than its thickness, whatever the forces.
  EXPECT_EQ(presses.through_six_tets, 0);
  EXPECT_LE(presses.through, 25);
  EXPECT_EQ(presses.intact, 0);
  EXPECT_LE(presses.unseen, 2);
}

}  // namespace
}  // namespace palpate::test
