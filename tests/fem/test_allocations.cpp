#include <gtest/gtest.h>

#include "fem/meshes.hpp"
#include "support/count_allocations.hpp"

namespace palpate::fem::test {
namespace {

TEST(Allocations, ASteadyStepMakesNone) {
  const Bodies bodies = single_body(irregular_box_mesh({8, 8, 8}, {0.5, 0.5, 0.5}, 0.2));
  Dynamics dynamics = Scene{{2e4, 0.4, 1000.0, 0.0, 0.001}, {}, 2}.dynamics(bodies);
  dynamics.set_positions(noisy(bodies, 0.01, 70));
  std::vector<Coupling> couplings(100);
  for (Index c = 0; c < 100; ++c) {
    at(couplings, c).points[0] = c;
    at(couplings, c).coefficients[0] = 1.0;
    at(couplings, c).stiffness = {10.0, 10.0, 10.0, 0.0, 0.0, 0.0};
  }
  for (int i = 0; i < 2; ++i) dynamics.step(0.01, {0.0, 0.0, -9.81}, {}, couplings, 1e-4, 50);
  const long before = allocations;
  ASSERT_GT(before, 0) << "allocations are not counted";
  for (int i = 0; i < 3; ++i) {
    dynamics.step(0.01, {0.0, 0.0, -9.81}, {},
                  std::span(couplings).first(static_cast<std::size_t>(60 + 20 * i)), 1e-4, 50);
    static_cast<void>(dynamics.kinetic_energy() + dynamics.elastic_energy());
  }
  EXPECT_EQ(allocations - before, 0);
}

TEST(Allocations, NorDoesOneWithMultigrid) {
  const Bodies bodies = single_body(irregular_box_mesh({8, 8, 8}, {0.5, 0.5, 0.5}, 0.2));
  Dynamics dynamics = Scene{{2e4, 0.4, 1000.0, 0.0, 0.001}, {}, 2}.dynamics(bodies);
  dynamics.set_positions(noisy(bodies, 0.01, 70));
  std::vector<Coupling> couplings(200);
  for (Index c = 0; c < 200; ++c) {
    at(couplings, c).points = {c, 500 - c, -1, -1, -1};
    at(couplings, c).coefficients = {1.0, -1.0};
    at(couplings, c).stiffness = {10.0, 10.0, 10.0, 0.0, 0.0, 0.0};
  }
  const auto step = [&](std::size_t count) {
    dynamics.begin_step(0.01, {0.0, 0.0, -9.81}, {});
    const SolveGoal goal{
        .tolerance = 1e-6, .max_iterations = 50, .preconditioner = Preconditioner::multigrid};
    EXPECT_TRUE(dynamics.solve(std::span(couplings).first(count), goal).multigrid);
    dynamics.end_step();
  };
  step(200);
  const long before = allocations;
  for (std::size_t i = 0; i < 5; ++i) step(160 + 10 * i);
  EXPECT_EQ(allocations - before, 0);
}

}  // namespace
}  // namespace palpate::fem::test
