// A damped isolated scene: three balls that run into each other without gravity. Oracle: the second law.
#include <algorithm>
#include <gtest/gtest.h>
#include <string>

#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

class CollidingBalls {
 public:
  CollidingBalls(double time_step, double friction, double contact_damping)
      : simulation_(three_balls(), settings(time_step, friction, contact_damping), 1) {}

  void step() {
    simulation_.step();
    const std::vector<double>& depths = simulation_.detector().contacts().depth;
    contact_energy_ = 0.0;
    for (const double depth : depths) contact_energy_ += 0.5 * stiffness_ * depth * depth;
  }

  /// Motion, strain and the penalty springs, k d^2 / 2 each; not the springs of friction.
  [[nodiscard]] double energy() const {
    return simulation_.metrics().kinetic_energy + simulation_.metrics().elastic_energy + contact_energy_;
  }
  [[nodiscard]] std::size_t contacts() const { return simulation_.detector().contacts().size(); }

 private:
  static Model three_balls() {
    Model model;
    for (int i = 0; i < 3; ++i) {
      model.bodies.add("ball " + std::to_string(i),
                       test::ball_mesh(4, {0.12 * i, 0.01 * i, 0.005 * i}, 0.05));
    }
    model.materials.assign(3, {.young_modulus = 2e4, .mass_damping = 0.1, .stiffness_damping = 0.005});
    for (const Index body : model.bodies.body_of_point())
      model.velocities.push_back({0.6 - 0.6 * body, 0.0, 0.0});
    return model;
  }
  static SimulationSettings settings(double time_step, double friction, double contact_damping) {
    SimulationSettings settings;
    settings.time_step = time_step;
    settings.gravity = {};
    settings.solver = {.tolerance = 1e-8, .max_iterations = 3000};
    settings.response = {.stiffness = stiffness_, .damping = contact_damping, .friction = friction};
    return settings;
  }

  static constexpr double stiffness_ = 500.0;
  Simulation simulation_;
  double contact_energy_ = 0.0;
};

void expect_no_growth(double time_step, double friction, double contact_damping) {
  CollidingBalls balls(time_step, friction, contact_damping);
  const double first = balls.energy();
  double energy = first;
  std::size_t most_contacts = 0;
  for (int n = 0; n < 300; ++n) {
    balls.step();
    const double next = balls.energy();
    EXPECT_LE(next, energy * (1.0 + 1e-7))
        << "step " << n << ", friction " << friction << ", time step " << time_step;
    energy = next;
    most_contacts = std::max(most_contacts, balls.contacts());
  }
  EXPECT_GT(most_contacts, 10U);
  EXPECT_LT(energy, 0.7 * first);
}

TEST(Energy, OfADampedIsolatedSceneNeverGrows) {
  for (const double time_step : {0.02, 0.01, 0.005, 0.002}) {
    expect_no_growth(time_step, 0.0, 0.0);
    expect_no_growth(time_step, 0.3, 0.3);
    expect_no_growth(time_step, 0.0, 0.3);
    expect_no_growth(time_step, 0.3, 0.0);
  }
}

}  // namespace
}  // namespace palpate
