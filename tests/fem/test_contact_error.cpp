// The error of a solve with contacts is as small as it says. Oracle: the same step, solved from the same
// state with a far smaller tolerance, without the directions of earlier solves.
#include <cmath>
#include <gtest/gtest.h>

#include "fem/tower.hpp"

namespace palpate::fem::test {
namespace {

SolveGoal goal_of(double tolerance, Preconditioner preconditioner) {
  return {
      .tolerance = tolerance, .max_iterations = 3000, .of_solution = true, .preconditioner = preconditioner};
}

/// A tower that falls by a gap onto its lowest block, and is shaken.
struct Landing {
  explicit Landing(double young_modulus) : tower(1, -1e-4, 0.3, young_modulus) {
    tower.step.time_step = 0.005;
    for (ContactLaw& law : tower.laws) law.stiffness = 0.002 * young_modulus;
  }
  void begin(int step) {
    tower.couplings.resize(contacts.size());
    std::ranges::copy(contacts, tower.couplings.begin());
    const auto positions = tower.dynamics->positions();
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      const Vec3 apart = at(positions, contacts[k].points[0]) - at(positions, contacts[k].points[1]);
      tower.laws[k].depth = -1e-4 - apart.z;
    }
    tower.dynamics->begin_step(tower.step.time_step, {2.0 * std::sin(0.7 * step), 0.5, -9.81}, {});
  }
  SolveReport solve(const SolveGoal& goal) {
    return tower.dynamics->solve(
        {.laws = tower.laws, .couplings = tower.couplings, .first = 0, .friction = tower.step}, goal, false);
  }
  Tower tower;
  std::vector<Coupling> contacts = tower.couplings;
};

class ErrorOfContacts : public testing::TestWithParam<Preconditioner> {};

TEST_P(ErrorOfContacts, IsWithinTheTolerance) {
  constexpr double tolerance = 1e-4;
  constexpr int steps = 40;
  int short_solves = 0;
  for (const double young_modulus : {1e5, 1e6, 2e7, 3e8}) {
    Landing landing(young_modulus);
    Landing exact(young_modulus);
    Dynamics& dynamics = *landing.tower.dynamics;
    for (int step = 0; step < steps; ++step) {
      exact.tower.dynamics->set_state(dynamics.state());
      landing.begin(step);
      landing.solve(goal_of(0.03, GetParam()));  // the next solve continues this one, as in a simulation
      const SolveReport report = landing.solve(goal_of(tolerance, GetParam()));
      ASSERT_TRUE(report.converged);
      short_solves += report.iterations < 10 ? 1 : 0;
      exact.begin(step);
      ASSERT_TRUE(exact.solve(goal_of(1e-9, Preconditioner::multigrid)).converged);
      double error = 0.0;
      double change = 0.0;
      double of_gravity = 0.0;
      for (std::size_t i = 0; i < dynamics.positions().size(); ++i) {
        const double m = dynamics.point_masses()[i];
        const Vec3 end = exact.tower.dynamics->mean_velocities()[i];
        error += m * squared_length(dynamics.mean_velocities()[i] - end);
        change += m * squared_length(end - dynamics.velocities()[i]);
        of_gravity += m * 96.0 * 0.005 * 0.005;
      }
      EXPECT_LE(std::sqrt(error), tolerance * std::sqrt(std::max(change, of_gravity)))
          << young_modulus << " Pa, step " << step << ", iterations " << report.iterations;
      dynamics.end_step();
    }
  }
  EXPECT_GT(short_solves, 20);
}

INSTANTIATE_TEST_SUITE_P(Preconditioners, ErrorOfContacts,
                         testing::Values(Preconditioner::automatic, Preconditioner::multigrid),
                         [](const auto& instance) {
                           return instance.param == Preconditioner::multigrid ? "multigrid" : "automatic";
                         });

}  // namespace
}  // namespace palpate::fem::test
