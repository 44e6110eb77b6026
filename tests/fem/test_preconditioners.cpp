// Effect of the preconditioners on solutions, and the factor of the coarsest level.
#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "fem/envelope_cholesky.hpp"
#include "fem/meshes.hpp"
#include "fem/system.hpp"

namespace palpate::fem::test {
namespace {

TEST(EnvelopeCholesky, SolvesWhatEigenSolves) {
  const std::vector<Index> first{0, 0, 1, 0, 4, 2, 5};
  const auto n = 6 * static_cast<Eigen::Index>(first.size());
  EnvelopeCholesky factor;
  for (const unsigned seed : {1U, 2U}) {  // the second time in reused memory
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    Eigen::MatrixXd a = 20.0 * Eigen::MatrixXd::Identity(n, n);
    factor.reset(first);
    for (Index row = 0; row < factor.size(); ++row) {
      for (Index column = at(first, row); column <= row; ++column) {
        for (Eigen::Index i = 0; i < 6; ++i) {
          for (Eigen::Index j = 0; j < (row == column ? i + 1 : 6); ++j) {
            a(6 * row + i, 6 * column + j) += uniform(random);
            a(6 * column + j, 6 * row + i) = a(6 * row + i, 6 * column + j);
          }
        }
        for (int i = 0; i < 6; ++i) {
          for (int j = 0; j < 6; ++j)
            at(factor.block(row, column), 6 * i + j) = a(6 * row + i, 6 * column + j);
        }
      }
    }
    factor.factor();
    std::vector<Vector6> b(first.size());
    Eigen::VectorXd right(n);
    for (Eigen::Index i = 0; i < n; ++i) right[i] = at(at(b, i / 6), i % 6) = uniform(random);
    factor.solve(b);
    const Eigen::VectorXd expected = a.llt().solve(right);
    for (Eigen::Index i = 0; i < n; ++i) EXPECT_NEAR(at(at(b, i / 6), i % 6), expected[i], 1e-13);
  }
}

TEST(EnvelopeCholesky, LeavesOutWhatHasNoStiffness) {
  EnvelopeCholesky factor;
  factor.reset(std::vector<Index>{0});
  for (std::size_t i = 0; i < 6; ++i) factor.block(0, 0)[7 * i] = i == 2 ? 0.0 : 4.0;
  factor.factor();
  std::vector<Vector6> b{{4.0, 8.0, 12.0, 16.0, 20.0, 24.0}};
  factor.solve(b);
  EXPECT_EQ(b[0], (Vector6{1.0, 2.0, 0.0, 4.0, 5.0, 6.0}));
}

/// Stiff blocks on springs above each other: a bad case for block Jacobi.
struct Stack {
  explicit Stack(int thread_count) : threads(thread_count) {
    for (int i = 0; i < 8; ++i) {
      TetMesh mesh = box_mesh({2, 2, 2}, {0.04, 0.04, 0.04});
      for (Vec3& p : mesh.points) p.z += 0.04 * i;
      bodies.add("block " + std::to_string(i), mesh);
    }
    const std::vector<std::uint8_t> held = select(bodies, [](const Vec3& p) { return p.z == 0.0; });
    dynamics = std::make_unique<Dynamics>(bodies, std::vector<Material>(8, {2e7, 0.3, 1000.0, 0.0, 1e-3}),
                                          held, std::vector<std::uint8_t>(8, 0), threads);
    for (int i = 0; i + 1 < 8; ++i) {
      for (Index k = 0; k < 9; ++k) {
        Coupling spring;
        spring.points[0] = 27 * i + 18 + k;
        spring.points[1] = 27 * (i + 1) + k;
        spring.coefficients = {1.0, -1.0};
        spring.stiffness = {1e3, 1e3, 1e5, 0.0, 0.0, 0.0};
        couplings.push_back(spring);
      }
    }
  }
  SolveReport solve(const SolveGoal& goal) {
    dynamics->begin_step(0.01, {0.3, 0.0, -9.81}, {});
    return dynamics->solve(couplings, goal);
  }
  parallel::Threads threads;
  Bodies bodies;
  std::unique_ptr<Dynamics> dynamics;
  std::vector<Coupling> couplings;
};

Eigen::VectorXd solution(const Stack& stack) {
  return to_eigen(stack.dynamics->mean_velocities());
}

TEST(Preconditioner, ThoseThatThereAreLeadToTheSameSolutionMultigridFaster) {
  Stack stack(2);
  const SolveGoal goal{.tolerance = 1e-12, .max_iterations = 5000, .preconditioner = Preconditioner::jacobi};
  const SolveReport jacobi = stack.solve(goal);
  const Eigen::VectorXd expected = solution(stack);
  ASSERT_TRUE(jacobi.converged);
  EXPECT_FALSE(jacobi.multigrid);
  SolveGoal other_goal = goal;
  other_goal.preconditioner = Preconditioner::multigrid;
  Stack other(2);
  const SolveReport report = other.solve(other_goal);
  EXPECT_TRUE(report.converged);
  EXPECT_TRUE(report.multigrid);
  EXPECT_LT(6 * report.iterations, jacobi.iterations);
  EXPECT_LT((solution(other) - expected).norm(), 1e-8 * expected.norm());

  other_goal.preconditioner = Preconditioner::automatic;
  Stack third(2);
  const SolveReport automatic = third.solve(other_goal);
  EXPECT_TRUE(automatic.multigrid);
  EXPECT_GT(automatic.jacobi_iterations, 0) << "the next solve begins with it";
  EXPECT_GT(automatic.iterations, report.iterations);
  EXPECT_LT(automatic.iterations, jacobi.iterations);
  EXPECT_LT((solution(third) - expected).norm(), 1e-8 * expected.norm());
}

/// Couplings are also off the diagonal, so at first the residual stagnates.
TEST(Preconditioner, TheErrorIsWhatTheGoalSays) {
  Stack exact(1);
  exact.solve({.tolerance = 1e-13, .max_iterations = 9000, .preconditioner = Preconditioner::multigrid});
  const Eigen::VectorXd expected = solution(exact);
  for (const Preconditioner preconditioner : {Preconditioner::jacobi, Preconditioner::multigrid}) {
    for (const double tolerance : {1e-2, 1e-3, 1e-5}) {
      Stack stack(1);
      const SolveReport report = stack.solve({.tolerance = tolerance,
                                              .max_iterations = 5000,
                                              .of_solution = true,
                                              .preconditioner = preconditioner});
      EXPECT_TRUE(report.converged);
      // Masses are equal except at the surface, so the plain norm is accurate enough.
      const double scale = std::max(expected.norm(), 0.01 * 9.81 * std::sqrt(8.0 * 27.0));
      EXPECT_LT((solution(stack) - expected).norm(), 1.5 * tolerance * scale)
          << static_cast<int>(preconditioner) << ", " << report.iterations << " iterations";
    }
  }
}

TEST(Preconditioner, MultigridGivesTheSameBitsForEveryThreadCount) {
  Stack reference(1);
  const SolveGoal goal{.tolerance = 1e-6, .max_iterations = 300, .preconditioner = Preconditioner::multigrid};
  reference.solve(goal);
  for (const int threads : {2, 3, 5}) {
    Stack stack(threads);
    stack.solve(goal);
    EXPECT_TRUE(std::ranges::equal(stack.dynamics->mean_velocities(), reference.dynamics->mean_velocities()));
  }
}

}  // namespace
}  // namespace palpate::fem::test
