// Effect of the preconditioners on solutions, and the factor of the coarsest level.
#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "fem/envelope_cholesky.hpp"
#include "fem/inner_solve.hpp"
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
        Block6 block;
        for (int i = 0; i < 6; ++i) {
          for (int j = 0; j < 6; ++j) at(block, 6 * i + j) = a(6 * row + i, 6 * column + j);
        }
        factor.add(row, column, block);
      }
    }
    factor.factor();
    simd::AlignedVector<Vector6> b(first.size());
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
  Block6 block{};
  for (std::size_t i = 0; i < 6; ++i) block[7 * i] = i == 2 ? 0.0 : 4.0;
  factor.add(0, 0, block);
  factor.factor();
  simd::AlignedVector<Vector6> b{{4.0, 8.0, 12.0, 16.0, 20.0, 24.0}};
  factor.solve(b);
  EXPECT_EQ(b[0], (Vector6{1.0, 2.0, 0.0, 4.0, 5.0, 6.0}));
}

/// The block diagonal of a matrix.
Eigen::MatrixXd block_diagonal(const Eigen::MatrixXd& a) {
  Eigen::MatrixXd blocks = Eigen::MatrixXd::Zero(a.rows(), a.cols());
  for (Eigen::Index i = 0; i < a.rows(); i += 3) blocks.block<3, 3>(i, i) = a.block<3, 3>(i, i);
  return blocks;
}

TEST(InnerSolve, FindsTheBestVectorOfTheKrylovSpace) {
  System s(2);
  Eigen::MatrixXd a = s.dense();
  s.restrict(a);
  const Eigen::VectorXd right = to_eigen(s.random_free_vector(5));
  const Eigen::MatrixXd preconditioned = block_diagonal(a).llt().solve(a);
  const Eigen::VectorXd exact = a.llt().solve(right);
  InnerSolve inner;
  std::vector<float> found(s.matrix.row_count() * 3);
  for (const int count : {1, 2, 5, 9}) {
    // An orthonormal basis of D^-1 r, D^-1 A D^-1 r, ...; the best vector has the least error in the norm of
    // A.
    Eigen::MatrixXd basis(right.size(), count);
    Eigen::VectorXd next = block_diagonal(a).llt().solve(right);
    for (int k = 0; k < count; ++k) {
      for (int pass = 0; pass < 2; ++pass) {
        for (int j = 0; j < k; ++j) next -= basis.col(j).dot(next) * basis.col(j);
      }
      basis.col(k) = next.normalized();
      next = preconditioned * basis.col(k);
    }
    const Eigen::VectorXd best =
        basis * (basis.transpose() * a * basis).llt().solve(basis.transpose() * right);
    const auto r = floats_by_row(s, s.random_free_vector(5));
    EXPECT_EQ(inner.apply(s.threads, s.system, r, found, count, 0.0), count);
    const Eigen::VectorXd error = to_eigen(by_point(s, found)) - best;
    EXPECT_LT(std::sqrt(error.dot(a * error)), 1e-4 * std::sqrt(exact.dot(a * exact))) << count;
  }
}

TEST(InnerSolve, StopsAtTheReduction) {
  System s(1);
  Eigen::MatrixXd a = s.dense();
  s.restrict(a);
  const Eigen::VectorXd right = to_eigen(s.random_free_vector(6));
  InnerSolve inner;
  std::vector<float> found(s.matrix.row_count() * 3);
  const auto residual_after = [&](int most, double reduction, int& iterations) {
    iterations =
        inner.apply(s.threads, s.system, floats_by_row(s, s.random_free_vector(6)), found, most, reduction);
    return (right - a * to_eigen(by_point(s, found))).norm() / right.norm();
  };
  int iterations = 0;
  EXPECT_LE(residual_after(1000, 0.1, iterations), 0.1001);
  int ignored = 0;
  EXPECT_GT(residual_after(iterations - 1, 0.1, ignored), 0.0999);
  EXPECT_EQ(ignored, iterations - 1);
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
