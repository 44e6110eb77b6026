#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "fem/conjugate_gradients.hpp"
#include "fem/linear_system.hpp"
#include "fem/meshes.hpp"
#include "fem/system.hpp"

namespace palpate::fem::test {
namespace {

/// The blocks of one row by column.
std::vector<std::pair<Index, Matrix3>> row_of(const BlockMatrix& matrix, Index row) {
  std::vector<std::pair<Index, Matrix3>> blocks;
  for (const std::uint32_t column : matrix.columns(row))
    blocks.emplace_back(static_cast<Index>(column), matrix.block(row, blocks.size()));
  return blocks;
}

void expect_exactly_symmetric(const BlockMatrix& matrix, std::span<const std::uint8_t> free) {
  for (Index row = 0; row < matrix.size(); ++row) {
    const auto columns = matrix.columns(row);
    EXPECT_TRUE(std::is_sorted(columns.begin(), columns.end()));
    EXPECT_EQ(columns.empty(), at(free, row) == 0);
    for (const auto& [column, block] : row_of(matrix, row)) {
      if (at(free, column) == 0) continue;
      const auto back = row_of(matrix, column);
      const auto found = std::ranges::find(back, row, [](const auto& other) { return other.first; });
      ASSERT_NE(found, back.end());
      EXPECT_EQ(to_eigen(block), to_eigen(found->second).transpose());
    }
  }
}

TEST(BlockMatrix, HasASymmetricPatternAndExactlySymmetricBlocks) {
  const System s(1);
  expect_exactly_symmetric(s.matrix, s.free);
}

/// If lambda / mu differs between tets, terms are added up by another loop.
TEST(BlockMatrix, TakesTetsOfDifferentPoissonRatios) {
  const Bodies bodies = single_body(irregular_box_mesh({3, 3, 2}, {0.3, 0.3, 0.2}, 0.2));
  const std::vector<Material> all{
      {5e4, 0.4, 1000.0, 0.0, 0.0}, {2e4, 0.1, 1000.0, 0.0, 0.0}, {9e4, -0.3, 1000.0, 0.0, 0.0}};
  std::vector<Index> of_tet(bodies.tets().size());
  for (std::size_t t = 0; t < of_tet.size(); ++t) of_tet[t] = static_cast<Index>(t % 3);
  Elements elements(bodies, Materials(all, of_tet), std::vector<std::uint8_t>(1, 0));
  const parallel::Threads threads(1);
  elements.update(threads, noisy(bodies, 0.02, 30));
  const std::vector<std::uint8_t> free(bodies.points_rest().size(), 1);
  BlockMatrix matrix(elements, free);
  matrix.assemble(threads, std::vector<double>(free.size(), 2.0));
  expect_exactly_symmetric(matrix, free);
  const auto n = 3 * static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd expected = 2.0 * Eigen::MatrixXd::Identity(n, n);
  for (Index e = 0; e < elements.size(); ++e) {
    const Tet& corners = at(elements.corners(), e);
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        Matrix3 block;
        elements.add_stiffness(e, i, j, block);
        expected.block<3, 3>(3 * at(corners, i), 3 * at(corners, j)) += to_eigen(block);
      }
    }
  }
  const double scale = expected.cwiseAbs().maxCoeff();
  for (Index row = 0; row < matrix.size(); ++row) {
    for (const auto& [column, block] : row_of(matrix, row)) {
      const Eigen::Matrix3d difference = to_eigen(block) - expected.block<3, 3>(3 * row, 3 * column);
      EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-6 * scale);
    }
  }
}

TEST(BlockMatrix, HasOneBlockForEachPointAndTwoForEachEdge) {
  const System s(1);
  const auto& points = s.free;
  std::size_t blocks = 0;
  for (Index row = 0; row < s.matrix.size(); ++row) blocks += s.matrix.columns(row).size();
  std::size_t expected = static_cast<std::size_t>(std::ranges::count(points, 1));
  for (const Edge& edge : s.bodies.edges())
    expected += std::size_t{at(points, edge[0])} + std::size_t{at(points, edge[1])};
  EXPECT_EQ(blocks, expected);
}

void expect_products_of_the_dense_matrix(System& s) {
  Eigen::MatrixXd a = s.dense();
  s.restrict(a);
  const auto x = s.random_free_vector(22);
  std::vector<simd::Padded3> padded_y(x.size(), {9.0, 9.0, 9.0, 9.0});
  s.system.multiply_exactly(s.threads, padded(x), padded_y);
  const auto y = unpadded(padded_y);
  const Eigen::VectorXd expected = a * to_eigen(x);
  EXPECT_LT((to_eigen(y) - expected).cwiseAbs().maxCoeff(), 1e-13 * expected.cwiseAbs().maxCoeff());
  std::vector<float> rows(3 * s.matrix.row_count(), 9.0F);
  const double inner = s.system.multiply(s.threads, quads_by_row(s, x), rows);
  EXPECT_LT((to_eigen(by_point(s, rows)) - expected).norm(), 1e-6 * expected.norm());
  EXPECT_NEAR(inner, to_eigen(x).dot(expected), 1e-5 * std::abs(inner));
  for (std::size_t i = 0; i < y.size(); ++i) {
    if (s.free[i] == 0) {
      EXPECT_EQ(y[i], Vec3{});
    }
  }
}

TEST(LinearSystem, ProductEqualsTheDenseMatrixWithCouplingsAndFixedPoints) {
  System s(1);
  expect_products_of_the_dense_matrix(s);
}

/// Lists of who is coupled with whom are kept from one set() to the next; nothing of them may be stale.
TEST(LinearSystem, ProductIsThatOfTheLastCouplings) {
  System s(3);
  const std::vector<Coupling> all = s.list;
  const auto check = [&](const char* change) {
    SCOPED_TRACE(change);
    s.couplings.set(s.threads, s.list, time_step, s.free);
    s.system.update_preconditioner(s.threads);
    expect_products_of_the_dense_matrix(s);
  };
  for (Coupling& c : s.list) c.stiffness = 3.0 * c.stiffness;
  check("other values");
  s.list[300].coefficients[1] *= 0.5;
  check("one other coefficient");
  s.list[599].points[2] = 47;
  check("one other point");
  s.list.resize(100);
  check("fewer");
  s.list = all;
  check("more");
  s.couplings.set(s.threads, {}, time_step, s.free);
  check("after none");
  std::ranges::reverse(s.list);
  check("another order");
}

TEST(LinearSystem, PreconditionerIsTheInverseOfTheDiagonalBlocks) {
  System s(1);
  const Eigen::MatrixXd a = s.dense();
  const auto r = random_vectors(s.free.size(), 1.0, 23);
  for (std::size_t i = 0; i < s.free.size(); ++i) {
    Vec3 z;
    if (s.free[i] != 0) {
      const auto row = static_cast<std::size_t>(s.matrix.row_of_point()[i]);
      const float* place = s.system.inverse_diagonal().data() + simd::slice_symmetric * (row / 16) + row % 16;
      const auto entry = [&](std::size_t k) { return static_cast<double>(place[16 * k]); };
      z = SymmetricMatrix3{entry(0), entry(1), entry(2), entry(3), entry(4), entry(5)} * r[i];
    }
    const auto at_row = 3 * static_cast<Eigen::Index>(i);
    const Eigen::Matrix3d block = a.block<3, 3>(at_row, at_row);
    const Eigen::Vector3d expected = block.inverse() * to_eigen(r[i]);
    if (s.free[i] == 0) {
      EXPECT_EQ(z, Vec3{});
    } else {
      EXPECT_LT((to_eigen(z) - expected).norm(), 1e-4 * expected.norm());
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
  const SolveReport report = solve(s, solver, b, x, {1e-13, 2000});
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

TEST(ConjugateGradients, ReportTheTrueResidual) {
  System s(1);
  Eigen::MatrixXd a = s.dense();
  s.restrict(a);
  const auto b = s.random_free_vector(25);
  ConjugateGradients solver;
  for (const int cap : {0, 1, 4}) {
    std::vector<Vec3> x(b.size());
    const SolveReport report =
        solve(s, solver, b, x, {.tolerance = 1e-12, .max_iterations = cap, .least_residual = 0.5});
    EXPECT_FALSE(report.converged);
    EXPECT_EQ(report.iterations, cap);
    const double residual = (to_eigen(b) - a * to_eigen(x)).norm();
    const double scale = std::max(to_eigen(b).norm(), 0.5);
    EXPECT_NEAR(report.relative_residual, residual / scale, 1e-12);
  }
}

/// The estimate must not be far below the true error, nor far above it.
TEST(ConjugateGradients, EndAtTheRequestedError) {
  System s(1);
  Eigen::MatrixXd a = s.dense();
  s.restrict(a);
  ConjugateGradients solver;
  for (const unsigned seed : {50U, 51U, 52U}) {
    const auto b = s.random_free_vector(seed);
    const Eigen::VectorXd expected = a.llt().solve(to_eigen(b));
    for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-6, 1e-9}) {
      std::vector<Vec3> x(b.size());
      const SolveReport report =
          solve(s, solver, b, x, {.tolerance = tolerance, .max_iterations = 2000, .of_solution = true});
      EXPECT_TRUE(report.converged);
      const double size = norm_by_mass(s, expected, 1.0);
      const double by_mass = norm_by_mass(s, to_eigen(x) - expected, 1.0) / size;
      EXPECT_LT(by_mass, tolerance) << seed;
      EXPECT_LE(report.relative_error, tolerance);
      const Eigen::VectorXd e = to_eigen(x) - expected;
      const double in_energy = std::sqrt(e.dot(a * e)) / size;
      EXPECT_LT(in_energy, 1.2 * tolerance);
      EXPECT_GT(in_energy, 0.02 * tolerance) << "too many iterations";
    }
  }
}

TEST(ConjugateGradients, MakeAFixedNumberOfIterations) {
  System s(1);
  const auto b = s.random_free_vector(53);
  ConjugateGradients solver;
  std::vector<Vec3> capped(b.size());
  solve(s, solver, b, capped, {1e-15, 7});
  std::vector<Vec3> x(b.size());
  const SolveReport report =
      solve(s, solver, b, x, {.tolerance = 0.5, .max_iterations = 3, .fixed_iterations = 7});
  EXPECT_EQ(report.iterations, 7);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(x, capped);
}

TEST(ConjugateGradients, UseAGoodGuessAndDropABadOne) {
  System s(1);
  const auto b = s.random_free_vector(26);
  ConjugateGradients solver;
  std::vector<Vec3> x(b.size());
  const int cold = solve(s, solver, b, x, {1e-10, 2000}).iterations;
  const auto solution = x;
  EXPECT_LE(solve(s, solver, b, x, {1e-9, 2000}).iterations, 1);
  auto bad = s.random_free_vector(27);
  for (Vec3& v : bad) v = 1e9 * v;
  EXPECT_EQ(solve(s, solver, b, bad, {1e-10, 2000}).iterations, cold);
  EXPECT_EQ(bad, solution);
}

TEST(ConjugateGradients, GiveExactlyZeroForAZeroRightSide) {
  System s(1);
  auto x = s.random_free_vector(28);
  const std::vector<Vec3> b(x.size());
  ConjugateGradients solver;
  const SolveReport report = solve(s, solver, b, x, {1e-10, 10});
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.iterations, 0);
  EXPECT_EQ(largest(x), 0.0);
}

TEST(ConjugateGradients, GiveTheSameBitsForEveryThreadCount) {
  System reference(1);
  const auto b = reference.random_free_vector(29);
  std::vector<Vec3> expected(b.size());
  ConjugateGradients solver;
  solve(reference, solver, b, expected, {1e-8, 100});
  for (const int threads : {2, 3, 7}) {
    System s(threads);
    std::vector<Vec3> x(b.size());
    solve(s, solver, b, x, {1e-8, 100});
    EXPECT_EQ(x, expected) << threads;
  }
}

}  // namespace
}  // namespace palpate::fem::test
