#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "fem/contact_law.hpp"
#include "fem/dynamics.hpp"
#include "fem/meshes.hpp"

namespace palpate::fem::test {

/// Blocks on each other, the lowest one held, with contacts between their faces.
struct Tower {
  static constexpr int count = 5;
  /// \param depth           of all contacts, m
  /// \param young_modulus   Pa
  explicit Tower(int thread_count, double depth, double mu, double young_modulus = 1e6)
      : threads(thread_count) {
    step = {.coefficient = mu, .time_step = 0.01};
    for (int i = 0; i < count; ++i) {
      TetMesh mesh = box_mesh({2, 2, 2}, {0.04, 0.04, 0.04});
      for (Vec3& p : mesh.points) p.z += 0.04 * i;
      bodies.add("block " + std::to_string(i), mesh);
    }
    const std::vector<std::uint8_t> held = select(bodies, [](const Vec3& p) { return p.z == 0.0; });
    dynamics = std::make_unique<Dynamics>(
        bodies, std::vector<Material>(count, {young_modulus, 0.3, 1000.0, 0.0, 1e-3}), held,
        std::vector<std::uint8_t>(count, 0), threads);
    for (int i = 0; i + 1 < count; ++i) {
      for (Index k = 0; k < 9; ++k) {
        Coupling contact;
        contact.points[0] = 27 * (i + 1) + k;
        contact.points[1] = 27 * i + 18 + k;
        contact.coefficients = {1.0, -1.0};
        couplings.push_back(contact);
        laws.push_back(
            {.stiffness = 2e3, .damping = 5.0, .depth = depth, .slip = {}, .direction = {0.0, 0.0, 1.0}});
      }
    }
  }
  SolveReport solve(const Vec3& gravity, const SolveGoal& goal, bool steady = false) {
    dynamics->begin_step(step.time_step, gravity, {});
    return dynamics->solve({.laws = laws, .couplings = couplings, .first = 0, .friction = step}, goal,
                           steady);
  }
  parallel::Threads threads;
  Bodies bodies;
  std::unique_ptr<Dynamics> dynamics;
  std::vector<Coupling> couplings;
  std::vector<ContactLaw> laws;
  StepFriction step{};
};

}  // namespace palpate::fem::test
