// The second level of the preconditioner, against dense matrices of Eigen.
#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <gtest/gtest.h>
#include <set>

#include "fem/coarse_space.hpp"
#include "fem/envelope_cholesky.hpp"
#include "fem/meshes.hpp"
#include "fem/system.hpp"

namespace palpate::fem::test {
namespace {

const parallel::Threads one_thread(1);

TEST(EnvelopeCholesky, SolvesWhatEigenSolves) {
  const std::vector<Index> first{0, 0, 1, 0, 4, 2, 5};
  const auto n = 6 * static_cast<Eigen::Index>(first.size());
  EnvelopeCholesky factor;
  for (const unsigned seed : {1U, 2U}) {  // the second time in memory that is used already
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

/// Several bodies, of which one has more points than an aggregate, one is held and one has a single free
/// point.
TEST(CoarseSpace, CutsFreePointsOfEachBodyIntoAggregates) {
  Bodies bodies;
  bodies.add("large", box_mesh({6, 6, 6}, {1.0, 1.0, 1.0}));
  bodies.add("held", unit_tet_mesh());
  bodies.add("small", box_mesh({2, 2, 2}, {1.0, 1.0, 1.0}));
  bodies.add("single", unit_tet_mesh());
  std::vector<std::uint8_t> free(bodies.points_rest().size(), 1);
  for (Index p = bodies.bodies()[1].points.begin; p < bodies.bodies()[1].points.end; ++p) at(free, p) = 0;
  for (Index p = bodies.bodies()[3].points.begin + 1; p < bodies.bodies()[3].points.end; ++p) at(free, p) = 0;
  const CoarseSpace coarse(bodies, free);
  std::vector<std::set<Index>> bodies_of(static_cast<std::size_t>(coarse.size()));
  std::vector<int> count(bodies_of.size());
  for (std::size_t p = 0; p < free.size(); ++p) {
    const Index a = coarse.aggregate_of_point()[p];
    ASSERT_EQ(a >= 0, free[p] != 0);
    if (a < 0) continue;
    at(bodies_of, a).insert(bodies.body_of_point()[p]);
    ++at(count, a);
  }
  ASSERT_EQ(coarse.size(), 6) << "343 points in four parts, 27, and 1";
  for (std::size_t a = 0; a < count.size(); ++a) {
    EXPECT_EQ(bodies_of[a].size(), 1U);
    EXPECT_GE(count[a], 1);
    EXPECT_LE(count[a], 96);
  }
}

/// Z, from what an aggregate is: rigid motions about any middle span the same space.
Eigen::MatrixXd rigid_motions(const CoarseSpace& coarse, std::span<const Vec3> positions) {
  Eigen::MatrixXd z =
      Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(positions.size()), 6 * coarse.size());
  for (std::size_t p = 0; p < positions.size(); ++p) {
    const Index a = coarse.aggregate_of_point()[p];
    if (a < 0) continue;
    const auto row = 3 * static_cast<Eigen::Index>(p);
    z.block<3, 3>(row, 6 * a).setIdentity();
    for (int axis = 0; axis < 3; ++axis) {
      z.block<3, 1>(row, 6 * a + 3 + axis) =
          Eigen::Vector3d::Unit(axis).cross(to_eigen(positions[p]) - Eigen::Vector3d(0.2, 0.1, 0.1));
    }
  }
  return z;
}

TEST(CoarseSpace, AddsTheExactSolutionAmongRigidMotions) {
  System s(1);
  Eigen::MatrixXd a = s.dense();
  s.restrict(a);
  CoarseSpace coarse(s.bodies, s.free);
  EXPECT_EQ(coarse.size(), 1);
  for (const unsigned seed : {60U, 61U}) {
    const auto positions = noisy(s.bodies, 0.02, seed);
    coarse.update(s.threads, s.matrix, s.couplings, positions);
    const auto r = s.random_free_vector(62);
    auto z = floats_by_row(s, s.random_free_vector(63));
    const Eigen::VectorXd before = to_eigen(by_point(s, z));
    const double inner = coarse.correct(s.threads, floats_by_row(s, r), z);
    const Eigen::MatrixXd motions = rigid_motions(coarse, positions);
    const Eigen::VectorXd expected =
        motions * (motions.transpose() * a * motions).llt().solve(motions.transpose() * to_eigen(r));
    EXPECT_LT((to_eigen(by_point(s, z)) - before - expected).norm(), 1e-4 * expected.norm());
    EXPECT_NEAR(inner, to_eigen(r).dot(expected), 1e-4 * std::abs(inner));
  }
}

/// Stiff blocks on springs above each other: what block Jacobi is bad at.
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

TEST(Preconditioner, ThoseThatThereAreLeadToTheSameSolutionTheTwoLevelsFaster) {
  Stack stack(2);
  const SolveGoal goal{.tolerance = 1e-12, .max_iterations = 5000, .preconditioner = Preconditioner::jacobi};
  const SolveReport jacobi = stack.solve(goal);
  const Eigen::VectorXd expected = solution(stack);
  ASSERT_TRUE(jacobi.converged);
  EXPECT_FALSE(jacobi.two_level);
  SolveGoal two = goal;
  two.preconditioner = Preconditioner::two_level;
  Stack other(2);
  const SolveReport report = other.solve(two);
  EXPECT_TRUE(report.converged);
  EXPECT_TRUE(report.two_level);
  EXPECT_LT(3 * report.iterations, jacobi.iterations);
  EXPECT_LT((solution(other) - expected).norm(), 1e-8 * expected.norm());

  two.preconditioner = Preconditioner::automatic;
  Stack third(2);
  const SolveReport automatic = third.solve(two);
  EXPECT_TRUE(automatic.two_level);
  EXPECT_GT(automatic.iterations, report.iterations);
  EXPECT_LT(automatic.iterations, jacobi.iterations);
  EXPECT_LT((solution(third) - expected).norm(), 1e-8 * expected.norm());
}

/// The couplings are not on the diagonal alone: the residual stagnates while bodies have not met yet.
TEST(Preconditioner, TheErrorIsWhatTheGoalSays) {
  Stack exact(1);
  exact.solve({.tolerance = 1e-13, .max_iterations = 9000, .preconditioner = Preconditioner::two_level});
  const Eigen::VectorXd expected = solution(exact);
  for (const Preconditioner preconditioner : {Preconditioner::jacobi, Preconditioner::two_level}) {
    for (const double tolerance : {1e-2, 1e-3, 1e-5}) {
      Stack stack(1);
      const SolveReport report = stack.solve({.tolerance = tolerance,
                                              .max_iterations = 5000,
                                              .of_solution = true,
                                              .preconditioner = preconditioner});
      EXPECT_TRUE(report.converged);
      // Equal masses but for corners, so that the plain norm is near enough.
      const double scale = std::max(expected.norm(), 0.01 * 9.81 * std::sqrt(8.0 * 27.0));
      EXPECT_LT((solution(stack) - expected).norm(), 1.5 * tolerance * scale)
          << static_cast<int>(preconditioner) << ", " << report.iterations << " iterations";
    }
  }
}

TEST(Preconditioner, TwoLevelsGiveTheSameBitsForEveryThreadCount) {
  Stack reference(1);
  const SolveGoal goal{.tolerance = 1e-6, .max_iterations = 300, .preconditioner = Preconditioner::two_level};
  reference.solve(goal);
  for (const int threads : {2, 5}) {
    Stack stack(threads);
    stack.solve(goal);
    EXPECT_TRUE(std::ranges::equal(stack.dynamics->mean_velocities(), reference.dynamics->mean_velocities()));
  }
}

}  // namespace
}  // namespace palpate::fem::test
