// Damped isolated scenes: three balls that run into each other without gravity, and stiff boxes that hit each
// other off their centres and spin away. Expected: the total energy never grows.
#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <string>
#include <utility>
#include <vector>

#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

class Collision {
 public:
  Collision(Model model, double time_step, const ResponseSettings& response)
      : stiffness_(*response.stiffness), simulation_(std::move(model), settings(time_step, response), 1) {}

  void step() {
    simulation_.step();
    const std::vector<double>& depths = simulation_.detector().contacts().depth;
    contact_energy_ = 0.0;
    for (const double depth : depths) contact_energy_ += 0.5 * stiffness_ * depth * depth;
  }

  /// Motion, strain and the penalty springs, k d^2 / 2 each; not the springs of friction.
  [[nodiscard]] double energy() const { return energy_apart_from_contact() + contact_energy_; }
  [[nodiscard]] double energy_apart_from_contact() const {
    return simulation_.metrics().kinetic_energy + simulation_.metrics().elastic_energy;
  }
  /// Whether bodies pushed each other in the last step.
  [[nodiscard]] bool pushed() const { return simulation_.contact_forces().front() != Vec3{}; }
  [[nodiscard]] std::size_t contacts() const { return simulation_.detector().contacts().size(); }

 private:
  static SimulationSettings settings(double time_step, const ResponseSettings& response) {
    SimulationSettings settings;
    settings.time_step = time_step;
    settings.gravity = {};
    settings.solver = {.tolerance = 1e-8, .max_iterations = 3000};
    settings.response = response;
    return settings;
  }

  double stiffness_;
  Simulation simulation_;
  double contact_energy_ = 0.0;
};

Model three_balls() {
  Model model;
  for (int i = 0; i < 3; ++i) {
    model.bodies.add("ball " + std::to_string(i), test::ball_mesh(4, {0.12 * i, 0.01 * i, 0.005 * i}, 0.05));
  }
  model.materials.assign(3, {.young_modulus = 2e4, .mass_damping = 0.1, .stiffness_damping = 0.005});
  for (const Index body : model.bodies.body_of_point())
    model.velocities.push_back({0.6 - 0.6 * body, 0.0, 0.0});
  return model;
}

/// The second box flies at a corner of the first with 1 m/s.
Model boxes_off_center(double young_modulus) {
  Model model;
  const Vec3 size{0.04, 0.04, 0.04};
  const Vec3 corner{-0.05, 0.011, 0.02};
  model.bodies.add("first", test::box_mesh({2, 2, 2}, {}, size));
  model.bodies.add("second", test::box_mesh({2, 2, 2}, corner, corner + size));
  model.materials.assign(2, {.young_modulus = young_modulus, .stiffness_damping = 0.002});
  for (const Index body : model.bodies.body_of_point()) model.velocities.push_back({1.0 * body, 0.0, 0.0});
  return model;
}

void expect_no_growth(double time_step, const ResponseSettings& response) {
  Collision balls(three_balls(), time_step, response);
  const double first = balls.energy();
  double energy = first;
  std::size_t most_contacts = 0;
  for (int n = 0; n < 300; ++n) {
    balls.step();
    const double next = balls.energy();
    EXPECT_LE(next, energy * (1.0 + 1e-7)) << "step " << n << ", friction " << response.friction
                                           << ", damping " << response.damping << ", time step " << time_step;
    energy = next;
    most_contacts = std::max(most_contacts, balls.contacts());
  }
  EXPECT_GT(most_contacts, 10U);
  EXPECT_LT(energy, 0.7 * first);
}

TEST(Energy, OfADampedIsolatedSceneNeverGrows) {
  for (const double time_step : {0.02, 0.01, 0.005, 0.002}) {
    for (const double friction : {0.0, 0.3}) {
      for (const double damping : {0.0, 0.3}) {
        expect_no_growth(time_step, {.stiffness = 500.0, .damping = damping, .friction = friction});
      }
    }
  }
}

/// Straight paths would swell a body that begins to spin: up to 36 times the energy in one step. While an
/// edge slides over a face its depth grows without a force, so k d^2 / 2 is no measure here. Instead,
/// energies of motion and strain gain at most a fraction of 1e-3 (the limit of BodyRotations) in a step
/// without contact, and in contact no more than penalty springs return.
TEST(Energy, OfStiffBoxesThatSpinAfterAHitNeverGrows) {
  for (const double time_step : {0.02, 0.01, 0.005, 0.002}) {
    for (const double young_modulus : {1e6, 2e7}) {
      for (const double friction : {0.0, 0.5}) {
        Collision boxes(boxes_off_center(young_modulus), time_step,
                        {.stiffness = 2e3, .damping = 0.3, .friction = friction});
        const double first = boxes.energy_apart_from_contact();
        double least = first;
        double last = first;
        for (double time = 0.0; time < 0.4; time += time_step) {
          boxes.step();
          const double next = boxes.energy_apart_from_contact();
          ASSERT_LE(next, boxes.pushed() ? 1.03 * least : (1.0 + 1e-3) * last)
              << "time " << time << ", friction " << friction << ", time step " << time_step
              << ", Young's modulus " << young_modulus;
          least = std::min(least, next);
          last = next;
        }
        EXPECT_LT(least, 0.8 * first);
      }
    }
  }
}

/// A bar that spins freely about an oblique axis.
Simulation spinning_bar(double young_modulus, double angular_velocity, double time_step) {
  Model model;
  model.bodies.add("bar", test::box_mesh({8, 1, 1}, {-0.05, -0.01, -0.01}, {0.05, 0.01, 0.01}));
  model.materials = {Material{.young_modulus = young_modulus, .density = 505}};
  SimulationSettings settings;
  settings.time_step = time_step;
  settings.gravity = {};
  Simulation simulation(std::move(model), settings, 1);
  std::vector<Index> points;
  std::vector<Vec3> velocities;
  for (const Vec3& p : simulation.positions()) {
    points.push_back(static_cast<Index>(points.size()));
    velocities.push_back(cross(angular_velocity * Vec3{0.3, 0.1, 1.0}, p));
  }
  simulation.set_velocities(points, velocities);
  return simulation;
}

/// Half a turn in a step and more. Undivided, such steps have more than a hundred times the energy.
TEST(Energy, OfBarsThatSpinByHalfATurnInAStepIsBounded) {
  constexpr double time_step = 0.02;
  for (const auto& [young_modulus, angle, most] : {std::array{1e6, 4.0, 1.2}, {3.7e4, 3.0, 2.6}}) {
    const double at_start = spinning_bar(young_modulus, angle / time_step, 1e-7).step().kinetic_energy;
    Simulation bar = spinning_bar(young_modulus, angle / time_step, time_step);
    EXPECT_GT(bar.step().substeps, 1);
    for (int step = 1; step < 40; ++step) {
      bar.step();
      ASSERT_LE(bar.metrics().kinetic_energy + bar.metrics().elastic_energy, most * at_start)
          << "step " << step << ", Young's modulus " << young_modulus;
    }
  }
}

}  // namespace
}  // namespace palpate
