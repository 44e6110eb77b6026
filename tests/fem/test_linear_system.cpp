#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "fem/conjugate_gradients.hpp"
#include "fem/linear_system.hpp"
#include "fem/meshes.hpp"

namespace palpate::fem::test {
namespace {

constexpr double time_step = 0.01;

SymmetricMatrix3 random_semi_definite(std::mt19937_64& random, double scale) {
  const Vec3 a = random_vector(random, 1.0);
  const Vec3 b = random_vector(random, 1.0);
  const auto outer = [&](const Vec3& v) {
    return scale * SymmetricMatrix3{v.x * v.x, v.y * v.y, v.z * v.z, v.x * v.y, v.x * v.z, v.y * v.z};
  };
  return outer(a) + outer(b);
}

/// A deformed box with couplings and fixed points, and the same system written out densely by other means.
struct System {
  explicit System(int thread_count)
      : threads(thread_count),
        bodies(single_body(irregular_box_mesh({4, 3, 3}, {0.4, 0.3, 0.3}, 0.2))),
        elements(bodies, std::vector<Material>(1, {5e4, 0.4, 1000.0, 0.0, 0.0}),
                 std::vector<std::uint8_t>(1, 0)),
        matrix(elements, static_cast<Index>(bodies.points_rest().size())),
        free(select(bodies, [](const Vec3& p) { return p.x > 0.0; })),
        system(matrix, couplings, free) {
    std::mt19937_64 random(21);
    elements.update(threads, noisy(bodies, 0.02, 20));
    std::uniform_real_distribution<double> uniform(0.5, 2.0);
    for (std::size_t i = 0; i < free.size(); ++i) diagonal.push_back(uniform(random));
    for (Index e = 0; e < elements.size(); ++e) factors.push_back(1e-4 * uniform(random));
    matrix.assemble(threads, elements, diagonal, factors);
    std::uniform_int_distribution<Index> any(0, 10);
    for (int c = 0; c < 600; ++c) {
      Coupling coupling;
      const int used = c % 7 == 0 ? 1 : 5;
      for (int k = 0; k < used; ++k) {
        // Distinct points, some of them fixed.
        at(coupling.points, k) = 16 * k + any(random);
        at(coupling.coefficients, k) = k == 0 ? 1.0 : -uniform(random) / 4.0;
      }
      coupling.stiffness = random_semi_definite(random, 2000.0);
      coupling.damping = random_semi_definite(random, 3.0);
      coupling.force = random_vector(random, 1.0);
      list.push_back(coupling);
    }
    couplings.set(list, time_step, static_cast<Index>(free.size()));
    system.update_preconditioner(threads);
  }

  [[nodiscard]] Eigen::MatrixXd dense() const {
    const auto n = 3 * static_cast<Eigen::Index>(free.size());
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
    for (Index e = 0; e < elements.size(); ++e) {
      for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) {
          Matrix3 block;
          elements.add_stiffness(e, i, j, 1.0, block);
          const Tet& corners = at(elements.corners(), e);
          a.block<3, 3>(3 * at(corners, i), 3 * at(corners, j)) += at(factors, e) * to_eigen(block);
        }
      }
    }
    for (std::size_t i = 0; i < free.size(); ++i) {
      a.diagonal().segment<3>(3 * static_cast<Eigen::Index>(i)).array() += diagonal[i];
    }
    for (const Coupling& c : list) {
      Eigen::MatrixXd j = Eigen::MatrixXd::Zero(3, n);
      for (int k = 0; k < 5; ++k) {
        if (at(c.points, k) < 0) continue;
        j.block<3, 3>(0, 3 * at(c.points, k)) += at(c.coefficients, k) * Eigen::Matrix3d::Identity();
      }
      a += j.transpose() * (time_step * to_eigen(c.damping) + time_step * time_step * to_eigen(c.stiffness)) *
           j;
    }
    return a;
  }
  /// Zero at points that are not free.
  [[nodiscard]] std::vector<Vec3> random_free_vector(unsigned seed) const {
    auto x = random_vectors(free.size(), 1.0, seed);
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (free[i] == 0) x[i] = {};
    }
    return x;
  }
  void restrict(Eigen::MatrixXd& a) const {
    for (std::size_t i = 0; i < free.size(); ++i) {
      if (free[i] != 0) continue;
      const auto row = 3 * static_cast<Eigen::Index>(i);
      a.middleRows<3>(row).setZero();
      a.middleCols<3>(row).setZero();
      a.block<3, 3>(row, row).setIdentity();
    }
  }

  parallel::Threads threads;
  Bodies bodies;
  Elements elements;
  BlockMatrix matrix;
  CouplingSystem couplings;
  std::vector<std::uint8_t> free;
  LinearSystem system;
  std::vector<double> diagonal;
  std::vector<double> factors;
  std::vector<Coupling> list;
};

TEST(BlockMatrix, HasASymmetricPatternAndExactlySymmetricBlocks) {
  const System s(1);
  for (Index row = 0; row < s.matrix.size(); ++row) {
    const auto columns = s.matrix.columns(row);
    EXPECT_TRUE(std::is_sorted(columns.begin(), columns.end()));
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const auto back = s.matrix.columns(columns[k]);
      const auto found = std::find(back.begin(), back.end(), row);
      ASSERT_NE(found, back.end());
      const Matrix3& mirrored = s.matrix.blocks(columns[k])[static_cast<std::size_t>(found - back.begin())];
      EXPECT_EQ(to_eigen(s.matrix.blocks(row)[k]), to_eigen(mirrored).transpose());
    }
  }
}

TEST(BlockMatrix, HasOneBlockForEachPointAndTwoForEachEdge) {
  const System s(1);
  std::size_t blocks = 0;
  for (Index row = 0; row < s.matrix.size(); ++row) blocks += s.matrix.columns(row).size();
  EXPECT_EQ(blocks, s.bodies.points_rest().size() + 2 * s.bodies.edges().size());
}

TEST(LinearSystem, ProductEqualsTheDenseMatrixWithCouplingsAndFixedPoints) {
  System s(1);
  Eigen::MatrixXd a = s.dense();
  s.restrict(a);
  const auto x = s.random_free_vector(22);
  std::vector<Vec3> y(x.size(), {9.0, 9.0, 9.0});
  s.system.multiply(s.threads, x, y);
  const Eigen::VectorXd expected = a * to_eigen(x);
  EXPECT_LT((to_eigen(y) - expected).cwiseAbs().maxCoeff(), 1e-13 * expected.cwiseAbs().maxCoeff());
  for (std::size_t i = 0; i < y.size(); ++i) {
    if (s.free[i] == 0) {
      EXPECT_EQ(y[i], Vec3{});
    }
  }
}

TEST(LinearSystem, PreconditionerIsTheInverseOfTheDiagonalBlocks) {
  System s(1);
  const Eigen::MatrixXd a = s.dense();
  const auto r = random_vectors(s.free.size(), 1.0, 23);
  for (std::size_t i = 0; i < s.free.size(); ++i) {
    const Vec3 z = s.system.precondition(i, r[i]);
    const auto at_row = 3 * static_cast<Eigen::Index>(i);
    const Eigen::Matrix3d block = a.block<3, 3>(at_row, at_row);
    const Eigen::Vector3d expected = block.inverse() * to_eigen(r[i]);
    if (s.free[i] == 0) {
      EXPECT_EQ(z, Vec3{});
    } else {
      EXPECT_LT((to_eigen(z) - expected).norm(), 1e-11 * expected.norm());
    }
  }
}

TEST(ConjugateGradients, SolveWhatEigenSolvesDirectly) {
  System s(2);
  Eigen::MatrixXd a = s.dense();
  s.restrict(a);
  const auto b = s.random_free_vector(24);
  std::vector<Vec3> x(b.size());
  ConjugateGradients solver;
  const SolveReport report = solver.solve(s.threads, s.system, b, x, 1e-13, 2000);
  EXPECT_TRUE(report.converged);
  EXPECT_GT(report.iterations, 3);
  EXPECT_LE(report.relative_residual, 1e-13);
  const Eigen::VectorXd expected = a.llt().solve(to_eigen(b));
  EXPECT_LT((to_eigen(x) - expected).norm(), 1e-10 * expected.norm());
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (s.free[i] == 0) {
      EXPECT_EQ(x[i], Vec3{});
    }
  }
}

TEST(ConjugateGradients, ReportTheResidualThatIsThere) {
  System s(1);
  Eigen::MatrixXd a = s.dense();
  s.restrict(a);
  const auto b = s.random_free_vector(25);
  ConjugateGradients solver;
  for (const int cap : {0, 1, 4}) {
    std::vector<Vec3> x(b.size());
    const SolveReport report = solver.solve(s.threads, s.system, b, x, 1e-12, cap);
    EXPECT_FALSE(report.converged);
    EXPECT_EQ(report.iterations, cap);
    const double residual = (to_eigen(b) - a * to_eigen(x)).norm() / to_eigen(b).norm();
    EXPECT_NEAR(report.relative_residual, residual, 1e-12);
  }
}

TEST(ConjugateGradients, UseAGoodGuessAndDropABadOne) {
  System s(1);
  const auto b = s.random_free_vector(26);
  ConjugateGradients solver;
  std::vector<Vec3> x(b.size());
  const int cold = solver.solve(s.threads, s.system, b, x, 1e-10, 2000).iterations;
  const auto solution = x;
  EXPECT_LE(solver.solve(s.threads, s.system, b, x, 1e-9, 2000).iterations, 1);
  auto bad = s.random_free_vector(27);
  for (Vec3& v : bad) v = 1e9 * v;
  EXPECT_EQ(solver.solve(s.threads, s.system, b, bad, 1e-10, 2000).iterations, cold);
  EXPECT_EQ(bad, solution);
}

TEST(ConjugateGradients, GiveExactlyZeroForAZeroRightSide) {
  System s(1);
  auto x = s.random_free_vector(28);
  const std::vector<Vec3> b(x.size());
  ConjugateGradients solver;
  const SolveReport report = solver.solve(s.threads, s.system, b, x, 1e-10, 10);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.iterations, 0);
  EXPECT_EQ(largest(x), 0.0);
}

TEST(ConjugateGradients, GiveTheSameBitsForEveryThreadCount) {
  System reference(1);
  const auto b = reference.random_free_vector(29);
  std::vector<Vec3> expected(b.size());
  ConjugateGradients solver;
  solver.solve(reference.threads, reference.system, b, expected, 1e-8, 100);
  for (const int threads : {2, 3, 7}) {
    System s(threads);
    std::vector<Vec3> x(b.size());
    solver.solve(s.threads, s.system, b, x, 1e-8, 100);
    EXPECT_EQ(x, expected) << threads;
  }
}

}  // namespace
}  // namespace palpate::fem::test
