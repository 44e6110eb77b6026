// The hierarchy and its V-cycle, against dense matrices of Eigen.
#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "fem/meshes.hpp"
#include "fem/multigrid.hpp"
#include "fem/system.hpp"

namespace palpate::fem::test {
namespace {

/// A system with three nodes or more on its first level.
BlockRows<3, 3> random_matrix(std::vector<Node>& nodes) {
  const Bodies bodies = single_body(irregular_box_mesh({5, 4, 4}, {0.5, 0.4, 0.4}, 0.2));
  Elements elements(bodies, std::vector<Material>(1, {5e4, 0.4, 1000.0, 0.0, 0.0}),
                    std::vector<std::uint8_t>(1, 0));
  elements.update(one_thread, bodies.points_rest());
  const Eigen::MatrixXd k = dense_stiffness(elements, bodies.points_rest().size());
  BlockRows<3, 3> a;
  for (Eigen::Index i = 0; i < k.rows() / 3; ++i) {
    nodes.push_back({.middle = bodies.points_rest()[static_cast<std::size_t>(i)]});
    for (Eigen::Index j = 0; j < k.rows() / 3; ++j) {
      Eigen::Matrix<double, 3, 3, Eigen::RowMajor> block = k.block<3, 3>(3 * i, 3 * j);
      if (i == j) block.diagonal().array() += 10.0;
      if (block.norm() == 0.0) continue;
      a.columns.push_back(static_cast<std::uint32_t>(j));
      a.blocks.emplace_back();
      std::copy(block.data(), block.data() + 9, a.blocks.back().begin());
    }
    a.begin.push_back(static_cast<std::uint32_t>(a.columns.size()));
  }
  return a;
}

template <std::size_t N, std::size_t M>
Eigen::MatrixXd dense(const BlockRows<N, M>& rows, std::size_t columns) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(N * rows.size()),
                                                 static_cast<Eigen::Index>(M * columns));
  for (std::size_t row = 0; row < rows.size(); ++row) {
    for (std::uint32_t k = rows.begin[row]; k < rows.begin[row + 1]; ++k) {
      result.block<N, M>(static_cast<Eigen::Index>(N * row), static_cast<Eigen::Index>(M * rows.columns[k])) =
          Eigen::Map<const Eigen::Matrix<double, N, M, Eigen::RowMajor>>(rows.blocks[k].data());
    }
  }
  return result;
}

TEST(Transfer, HasAllRigidMotionsAndLessEnergyThanAggregates) {
  std::vector<Node> nodes;
  const BlockRows<3, 3> a = random_matrix(nodes);
  const std::vector<Index> of = aggregate(graph_of(a));
  const std::vector<Node> aggregates = nodes_of(of, nodes);
  ASSERT_GE(aggregates.size(), 3U);
  const BlockRows<3, 6> transfer =
      least_energy_transfer<3>(one_thread, a, graph_of(a), nodes, of, aggregates);
  const Eigen::MatrixXd p = dense(transfer, aggregates.size());
  const Node whole{.middle = {0.1, -0.2, 0.3}, .radius = 0.7};
  for (Eigen::Index mode = 0; mode < 6; ++mode) {
    Eigen::VectorXd coarse(p.cols());
    Eigen::VectorXd expected(p.rows());
    for (std::size_t k = 0; k < aggregates.size(); ++k) {
      const Dense<6, 6> motion = rigid_motion<6>(aggregates[k], whole);
      for (std::size_t i = 0; i < 6; ++i)
        coarse[static_cast<Eigen::Index>(6 * k + i)] = motion[6 * i + static_cast<std::size_t>(mode)];
    }
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      const Dense<3, 6> motion = rigid_motion<3>(nodes[k], whole);
      for (std::size_t i = 0; i < 3; ++i)
        expected[static_cast<Eigen::Index>(3 * k + i)] = motion[6 * i + static_cast<std::size_t>(mode)];
    }
    EXPECT_LT((p * coarse - expected).norm(), 1e-12 * expected.norm()) << mode;
  }
  BlockRows<3, 6> rigid = transfer;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (std::uint32_t k = rigid.begin[i]; k < rigid.begin[i + 1]; ++k) {
      const auto own = static_cast<std::uint32_t>(of[i]);
      rigid.blocks[k] = rigid.columns[k] == own ? rigid_motion<3>(nodes[i], aggregates[own]) : Dense<3, 6>{};
    }
  }
  const Eigen::MatrixXd t = dense(rigid, aggregates.size());
  const Eigen::MatrixXd full = dense(a, a.size());
  EXPECT_LT((p.transpose() * full * p).trace(), 0.5 * (t.transpose() * full * t).trace());
}

TEST(Transfer, GalerkinProductEqualsTheDenseOne) {
  std::vector<Node> nodes;
  const BlockRows<3, 3> a = random_matrix(nodes);
  const std::vector<Index> of = aggregate(graph_of(a));
  const std::vector<Node> aggregates = nodes_of(of, nodes);
  const BlockRows<3, 6> transfer =
      least_energy_transfer<3>(one_thread, a, graph_of(a), nodes, of, aggregates);
  const Eigen::MatrixXd p = dense(transfer, aggregates.size());
  const Eigen::MatrixXd expected = p.transpose() * dense(a, a.size()) * p;
  for (const int threads : {1, 3}) {
    const BlockRows<6, 6> coarse = galerkin<3>(parallel::Threads(threads), a, transfer, aggregates.size());
    EXPECT_LT((dense(coarse, aggregates.size()) - expected).norm(), 1e-13 * expected.norm());
  }
}

/// Every point is in an aggregate, and no aggregate has points of two bodies.
TEST(Transfer, AggregatesAreNeighbours) {
  std::vector<Node> nodes;
  const BlockRows<3, 3> a = random_matrix(nodes);
  const std::vector<Index> of = aggregate(graph_of(a));
  const Index count = std::ranges::max(of) + 1;
  EXPECT_LT(8 * count, static_cast<Index>(of.size()));
  std::vector<int> members(static_cast<std::size_t>(count));
  for (const Index own : of) {
    ASSERT_GE(own, 0);
    ++at(members, own);
  }
  EXPECT_GE(std::ranges::min(members), 4);
}

/// An aggregate of two points, or of points on a line, has no rotation.
TEST(Transfer, WhatLiesOnALineDoesNotTurn) {
  const std::vector<Node> nodes{{.middle = {0, 0, 0}}, {.middle = {1, 1, 0}}, {.middle = {3, 3, 0}}};
  const std::vector<Index> together{0, 0, 0};
  EXPECT_EQ(nodes_of(together, nodes)[0].radius, 0.0);
  std::vector<Node> bent = nodes;
  bent[2].middle.x = 2.0;
  EXPECT_GT(nodes_of(together, bent)[0].radius, 0.0);
}

Eigen::MatrixXd preconditioner(System& s, Multigrid& multigrid) {
  const auto n = 3 * static_cast<Eigen::Index>(s.free.size());
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(n, n);
  std::vector<float> z(3 * s.matrix.row_count());
  for (Eigen::Index k = 0; k < n; ++k) {
    if (at(s.free, k / 3) == 0) continue;
    std::vector<Vec3> unit(s.free.size());
    (k % 3 == 0 ? at(unit, k / 3).x : k % 3 == 1 ? at(unit, k / 3).y : at(unit, k / 3).z) = 1.0;
    const double inner = multigrid.apply(s.threads, s.system, floats_by_row(s, unit), z);
    result.col(k) = to_eigen(by_point(s, z));
    EXPECT_NEAR(inner, result(k, k), 1e-6 * std::abs(inner));
  }
  return result;
}

/// Eigenvalues of the preconditioner times the matrix, ascending.
Eigen::VectorXd spectrum(System& s) {
  Multigrid multigrid(s.matrix);
  multigrid.update(s.threads, s.system, noisy(s.bodies, 0.02, 20));
  const Eigen::MatrixXd b = preconditioner(s, multigrid);
  EXPECT_LT((b - b.transpose()).norm(), 1e-5 * b.norm());
  Eigen::MatrixXd a = s.dense();
  s.restrict(a);
  Eigen::MatrixXd whole = 0.5 * (b + b.transpose());
  for (std::size_t i = 0; i < s.free.size(); ++i) {
    if (s.free[i] == 0)
      whole.block<3, 3>(3 * static_cast<Eigen::Index>(i), 3 * static_cast<Eigen::Index>(i)).setIdentity();
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(a);
  EXPECT_EQ(factor.info(), Eigen::Success);
  const Eigen::MatrixXd l = factor.matrixL();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(l.transpose() * whole * l, Eigen::EigenvaluesOnly)
      .eigenvalues();
}

/// With couplings between points of different colours and of the same colour.
TEST(Multigrid, IsSymmetricAndPositiveAndNearTheInverse) {
  System s(1);
  const Eigen::VectorXd values = spectrum(s);
  EXPECT_GT(values.minCoeff(), 0.02);
  EXPECT_LT(values.maxCoeff(), 1.5);
}

/// A light body held only by couplings moves rigidly against them, so coarse matrices must contain them all.
TEST(Multigrid, CoarseMatricesHaveTheCouplings) {
  System s(1, false);
  for (double& mass : s.diagonal) mass *= 1e-4;
  s.matrix.assemble(s.threads, s.diagonal);
  s.system.update_preconditioner(s.threads);
  const Eigen::VectorXd values = spectrum(s);
  EXPECT_GT(values.minCoeff(), 0.02);
  EXPECT_LT(values.maxCoeff(), 1.5);
}

/// After slow solves the hierarchy is rebuilt at the next positions. Rebuilding it from its reference gives
/// the same bits.
TEST(Multigrid, IsRebuiltAfterSlowSolvesAndFromItsReference) {
  System s(1);
  const auto positions = noisy(s.bodies, 0.02, 20);
  const auto r = floats_by_row(s, s.random_free_vector(8));
  const auto result = [&](Multigrid& multigrid) {
    std::vector<float> z(r.size());
    multigrid.update(s.threads, s.system, positions);
    multigrid.apply(s.threads, s.system, r, z);
    return z;
  };
  Multigrid multigrid(s.matrix);
  const auto at_rest = result(multigrid);
  for (int solve = 0; solve < 100; ++solve) multigrid.count(20);
  EXPECT_EQ(result(multigrid), at_rest) << "no solve took too many";
  for (int solve = 0; solve < 4; ++solve) multigrid.count(60);
  const auto recomputed = result(multigrid);
  EXPECT_NE(recomputed, at_rest);
  EXPECT_EQ(multigrid.reference(), positions);
  EXPECT_EQ(multigrid.stale_iterations(), 0);
  Multigrid resumed(s.matrix);
  resumed.set_reference(multigrid.reference(), multigrid.stale_iterations());
  EXPECT_EQ(result(resumed), recomputed);
}

/// For a body that has only rotated, the result is rotated.
TEST(Multigrid, TurnsWithTheBody) {
  std::mt19937_64 random(5);
  const Matrix3 some_rotation = random_rotation(random);
  System s(1);
  s.couplings.set(parallel::Threads(1), {}, time_step, s.free);
  const auto positions_of = [&](const Matrix3& r) {
    return mapped(s.bodies, [&](const Vec3& p) { return r * p + Vec3{0.3, -0.2, 0.1}; });
  };
  const auto turned = [&](const std::vector<Vec3>& v, const Matrix3& r) {
    std::vector<Vec3> result;
    for (const Vec3& x : v) result.push_back(r * x);
    return result;
  };
  const auto r = s.random_free_vector(7);
  std::vector<Eigen::VectorXd> results;
  for (const Matrix3& rotation : {identity(), some_rotation}) {
    s.elements.update(s.threads, positions_of(rotation));
    s.matrix.assemble(s.threads, s.diagonal);
    s.system.update_preconditioner(s.threads);
    Multigrid multigrid(s.matrix);
    multigrid.update(s.threads, s.system, positions_of(rotation));
    std::vector<float> z(3 * s.matrix.row_count());
    multigrid.apply(s.threads, s.system, floats_by_row(s, turned(r, rotation)), z);
    const auto back = from_eigen(to_eigen(rotation).transpose());
    results.push_back(to_eigen(turned(by_point(s, z), back)));
  }
  EXPECT_LT((results[1] - results[0]).norm(), 1e-4 * results[0].norm());
}

}  // namespace
}  // namespace palpate::fem::test
