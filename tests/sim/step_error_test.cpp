// The error of a step is as small as the tolerance says. Oracle: the same step from the same state, solved with
// a far smaller tolerance.
#include <cmath>
#include <gtest/gtest.h>

#include "sim/examples.hpp"

namespace palpate::test {
namespace {

/// Blocks that land on each other: contacts open, close and slide in every step, and the solver has modes that
/// converge slowly (the sway of the tower).
Scene stiff_tower(double young_modulus) {
  Scene scene = example("tower");
  for (auto& body : scene.bodies)
    if (body.material) body.material->young_modulus = young_modulus;
  return scene;
}

TEST(StepError, IsWithinTheTolerance) {
  constexpr double tolerance = 1e-4;
  for (const double young_modulus : {1e6, 2e7, 1e9}) {
    const Scene scene = stiff_tower(young_modulus);
    Simulation simulation = simulate(scene);
    Simulation exact = simulate(scene);
    SimulationSettings tight = scene.settings;
    tight.solver.tolerance = 1e-9;
    tight.solver.max_iterations = 5000;
    for (int step = 0; step < 60; ++step) {
      exact.restore(simulation.save());
      exact.change(tight);
      const std::vector<Vec3> before(simulation.velocities().begin(), simulation.velocities().end());
      simulation.step();
      exact.step();
      double error = 0.0;
      double change = 0.0;
      for (std::size_t i = 0; i < before.size(); ++i) {
        error += squared_length(simulation.velocities()[i] - exact.velocities()[i]);
        change += std::max(squared_length(exact.velocities()[i] - before[i]), squared_length(scene.settings.time_step * scene.settings.gravity));
      }
      std::printf("%g step %d it %d det %d solves %d ratio %.2f\n", young_modulus, step, (int)simulation.metrics().solver_iterations, (int)simulation.metrics().detections, (int)simulation.metrics().solves, std::sqrt(error / change) / tolerance);
    }
  }
}

}  // namespace
}  // namespace palpate::test
