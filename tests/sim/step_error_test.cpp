// The error of a step with contacts is as small as the tolerance says. Oracle: the same step from the same
// state, solved with a far smaller tolerance.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "sim/examples.hpp"

namespace palpate::test {
namespace {

/// Blocks that land on each other. The sway of the tower converges slowly, and a solve that continues another
/// one with a few new contacts could end after two iterations.
Scene tower_of(double young_modulus) {
  Scene scene = example("tower");
  for (auto& body : scene.bodies)
    if (body.material) body.material->young_modulus = young_modulus;
  return scene;
}

/// Difference of the velocities, relative to their change in the step, or to that of free fall if it is
/// larger.
double relative_error(const Simulation& found, const Simulation& expected, const std::vector<Vec3>& before,
                      double fall) {
  double error = 0.0;
  double change = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    error += squared_length(found.velocities()[i] - expected.velocities()[i]);
    change += std::max(squared_length(expected.velocities()[i] - before[i]), fall * fall);
  }
  return std::sqrt(error / change);
}

/// Compares the steps that `counts` selects by number and metrics. Returns their number.
template <class Counts>
int compare(const Scene& scene, int steps, Counts&& counts) {
  Simulation simulation = simulate(scene);
  Simulation exact = simulate(scene);
  SimulationSettings tight = scene.settings;
  tight.solver.tolerance = 1e-9;
  tight.solver.max_iterations = 5000;
  tight.solver.max_solves = 200;
  const double fall = scene.settings.time_step * length(scene.settings.gravity);
  int counted = 0;
  for (int step = 0; step < steps; ++step) {
    exact.restore(simulation.save());
    exact.change(tight);
    const std::vector<Vec3> before(simulation.velocities().begin(), simulation.velocities().end());
    simulation.step();
    exact.step();
    const StepMetrics& metrics = simulation.metrics();
    if (!counts(step, metrics)) continue;
    ++counted;
    EXPECT_LE(relative_error(simulation, exact, before, fall), scene.settings.solver.tolerance)
        << "step " << step << ", solves " << metrics.solves << ", iterations " << metrics.solver_iterations;
  }
  return counted;
}

/// Steps in which each solve was one of the whole nonlinear problem: a linear solve is accepted by its
/// contact forces instead (docs/solver.md). The first step is left out, in which all contacts are new: there
/// the two solutions differ by more.
TEST(StepError, IsWithinTheTolerance) {
  int counted = 0;
  for (const double young_modulus : {1e6, 5e6, 2e7, 1e8}) {
    SCOPED_TRACE(young_modulus);
    counted += compare(tower_of(young_modulus), 60, [](int step, const StepMetrics& metrics) {
      return step > 0 && metrics.detections > 1 && metrics.solves == metrics.detections;
    });
  }
  EXPECT_GT(counted, 12);
}

/// A step with hyperelastic tissue ends where the updates of its linearisation have become small
/// (docs/materials.md, "How a step is solved"), after solves that are less exact at first.
TEST(StepError, OfHyperelasticTissueIsWithinTheTolerance) {
  for (const ElementKind elements : {ElementKind::linear, ElementKind::smoothed}) {
    SCOPED_TRACE(static_cast<int>(elements));
    Scene scene = tower_of(2e4);
    scene.bodies.resize(4);
    scene.settings.detection.self_collision.clear();
    for (auto& body : scene.bodies) {
      if (!body.material) continue;
      body.material->model = MaterialModel::stable_neo_hookean;
      body.material->elements = elements;
    }
    int several = 0;
    compare(scene, 40, [&](int, const StepMetrics& metrics) {
      several += metrics.solves > 3 ? 1 : 0;
      return true;
    });
    EXPECT_GT(several, 10);
  }
}

}  // namespace
}  // namespace palpate::test
