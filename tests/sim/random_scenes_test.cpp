// Random scenes (random_scenes.hpp). Oracles: the energy never exceeds the first, floors hold, tissue is not
// inverted unless crushed, and steps converge.
#include "sim/random_scenes.hpp"

#include <cstdio>
#include <gtest/gtest.h>

namespace palpate {
namespace {

/// Energy of motion, height and strain, J. Contact springs temporarily store some more.
double energy(const Simulation& simulation) {
  double sum = simulation.metrics().kinetic_energy + simulation.metrics().elastic_energy;
  for (Index body = 1; body < simulation.bodies().body_count(); ++body) {
    const double weight = at(simulation.masses(), body) * -simulation.settings().gravity.z;
    sum += weight * simulation.center_of_mass(body).z;
  }
  return sum;
}

struct Outcome {
  int steps = 0;
  int not_converged = 0;
  std::int64_t iterations = 0;
  int inverted = 0;        ///< scenes with an inverted tet at some time
  int stays_inverted = 0;  ///< scenes with an inverted tet at their end
  int gained = 0;          ///< scenes that gained energy, and ended there
  int second_order = 0;    ///< steps
};

Outcome run(std::uint64_t seed, ElementKind elements, TimeIntegration integration) {
  constexpr double duration = 1.0;
  constexpr int most_steps = 250;
  test::RandomScene scene(seed, elements);
  const double time_step = scene.settings.time_step;
  scene.settings.time_integration = integration;
  Simulation simulation(std::move(scene.model), scene.settings, 1);
  Outcome outcome{.steps = std::min(most_steps, static_cast<int>(duration / time_step))};
  const double at_start = energy(simulation);
  for (int step = 0; step < outcome.steps; ++step) {
    simulation.step();
    if (!simulation.metrics().solver_converged) {
      ++outcome.not_converged;
      std::printf("seed %d does not converge in step %d of %g s\n", static_cast<int>(seed), step, time_step);
    }
    outcome.iterations += simulation.metrics().solver_iterations;
    outcome.second_order += simulation.metrics().order == 2 ? 1 : 0;
    if (energy(simulation) > 1.01 * at_start) {
      std::printf("seed %d gains energy in step %d of %g s\n", static_cast<int>(seed), step, time_step);
      outcome.steps = step + 1;
      outcome.gained = 1;
      return outcome;
    }
    if (simulation.metrics().inverted_tets > 0) outcome.inverted = 1;
  }
  outcome.stays_inverted = simulation.metrics().inverted_tets > 0 ? 1 : 0;
  for (Index body = 1; body < simulation.bodies().body_count(); ++body) {
    const Vec3 center = simulation.center_of_mass(body);
    const bool above = std::max(std::abs(center.x), std::abs(center.y)) < test::RandomScene::floor;
    EXPECT_TRUE(!above || center.z > 0.0) << "seed " << seed << ": body " << body << " at " << center.z;
  }
  return outcome;
}

/// \param most_inverted  allowed number of scenes with inverted tets: soft bodies below heavy ones are
///                       crushed
/// \param stay_inverted  the same, with inverted tets at their end
void run_all(std::uint64_t first, std::uint64_t count, int most_inverted,
             ElementKind elements = ElementKind::linear,
             TimeIntegration integration = TimeIntegration::implicit_euler, int most_failures = 0,
             int stay_inverted = 0) {
  Outcome all;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    const Outcome one = run(seed, elements, integration);
    all.steps += one.steps;
    all.not_converged += one.not_converged;
    all.inverted += one.inverted;
    all.stays_inverted += one.stays_inverted;
    all.iterations += one.iterations;
    all.gained += one.gained;
    all.second_order += one.second_order;
  }
  std::printf(
      "%d steps, %d not converged, %d of second order, %.1f iterations each, %d scenes with inverted tets, "
      "%d at "
      "their end\n",
      all.steps, all.not_converged, all.second_order, static_cast<double>(all.iterations) / all.steps,
      all.inverted, all.stays_inverted);
  EXPECT_LE(all.stays_inverted, stay_inverted);
  EXPECT_EQ(all.gained, 0);
  EXPECT_LE(all.inverted, most_inverted);
  EXPECT_LE(all.not_converged, most_failures) << "of " << all.steps << " steps";
}

TEST(RandomScenes, KeepTheirEnergyTheirFloorAndConverge) {
  run_all(1, 16, 0);
}

/// In 1044, a solve of stiff bodies cycles with sweeps over up to 64 contacts; in 1058, one of softer bodies.
TEST(RandomScenes, SlowSolvesThatCycleConvergeWithOtherSweeps) {
  run_all(1044, 1, 0);
  run_all(1058, 1, 0);
}

/// A sheet falls so deep into a narrow box within a step that its points are nearest to the sides of the box.
/// Pushed out there, it gained energy.
TEST(RandomScenes, OneWhoseSheetFallsDeepIntoABoxKeepsItsEnergy) {
  run_all(1053, 1, 0);
}

/// Bodies that rotate far in a step hit each other. Angular impulses from the forces of these contacts gained
/// up to 36 % of the energy.
TEST(RandomScenes, WhoseBodiesRotateFarAndMeetKeepTheirEnergy) {
  for (const std::uint64_t seed : {1093U, 1120U, 1150U, 1187U, 1198U})
    run_all(seed, 1, 1, ElementKind::linear, TimeIntegration::implicit_euler, 0, 1);
}

/// The first seeds of the first test: a step of smoothed tets takes longer. The long test has 60 others.
TEST(RandomScenes, OfSmoothedTetsKeepTheirEnergyTheirFloorAndConverge) {
  run_all(1, 4, 0, ElementKind::smoothed);
}

/// BDF2 gives way to implicit Euler where contacts change. Without that, tissue is inverted over seeds 1
/// to 16.
TEST(RandomScenes, OfBdf2KeepTheirEnergyTheirFloorAndConverge) {
  run_all(1, 16, 0, ElementKind::linear, TimeIntegration::bdf2);
}

/// Found: 11 scenes, and 5 of 8450 steps.
TEST(RandomScenes, DISABLED_SixtyOfSmoothedTetsDo) {
  run_all(2000, 60, 15, ElementKind::smoothed, TimeIntegration::implicit_euler, 10, 15);
}

TEST(RandomScenes, DISABLED_TwoHundredDo) {
  run_all(1000, 200, 30, ElementKind::linear, TimeIntegration::implicit_euler, 0, 5);
}

}  // namespace
}  // namespace palpate
