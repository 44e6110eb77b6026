#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "fem/dynamics.hpp"
#include "fem/meshes.hpp"
#include "fem/rest_factor.hpp"
#include "fem/sparse_cholesky.hpp"
#include "fem/system.hpp"

namespace palpate::fem::test {
namespace {

/// The pattern of the free rows of a system, both ways.
struct Pattern {
  explicit Pattern(const System& s) {
    for (const Index point : s.matrix.point_of_row()) {
      for (const std::uint32_t other : s.matrix.columns(point)) {
        if (at(s.matrix.row_of_point(), other) >= 0) columns.push_back(at(s.matrix.row_of_point(), other));
      }
      begin.push_back(static_cast<Index>(columns.size()));
    }
  }
  std::vector<Index> begin{0};
  std::vector<Index> columns;
};

TEST(SparseCholesky, CountsTheBlocksThatTheFactorHas) {
  const System s(1);
  const Pattern pattern(s);
  const auto order = minimum_degree_order(pattern.begin, pattern.columns);
  auto sorted = order;
  std::ranges::sort(sorted);
  for (std::size_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], static_cast<Index>(i));
  const auto counts = factor_counts(pattern.begin, pattern.columns, order);
  std::vector<Index> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) at(place, order[k]) = static_cast<Index>(k);
  BlockEntries entries;
  for (std::size_t row = 0; row < order.size(); ++row) {
    for (Index k = pattern.begin[row]; k < pattern.begin[row + 1]; ++k) {
      const Index column = at(pattern.columns, k);
      const double value = column == static_cast<Index>(row) ? 100.0 : -1.0;
      if (place[row] >= at(place, column))
        entries.push_back({place[row], at(place, column), {{value, 0, 0, 0, value, 0, 0, 0, value}}});
    }
  }
  const BlockFactor factor = block_cholesky(static_cast<Index>(order.size()), entries);
  for (std::size_t k = 0; k < counts.size(); ++k)
    EXPECT_EQ(factor.column_begin[k + 1] - factor.column_begin[k], counts[k]) << k;
}

/// Positions of all points, turned as a whole.
std::vector<Vec3> turned(const System& s, const Matrix3& turn) {
  std::vector<Vec3> positions;
  for (const Vec3& p : s.bodies.points_rest()) positions.push_back(turn * p + Vec3{0.3, -0.2, 0.1});
  return positions;
}

/// A body that is only turned is solved by one application.
TEST(RestFactor, IsTheInverseOfABodyThatIsOnlyTurned) {
  System s(1);
  s.couplings.set({}, time_step, s.free);
  s.list.clear();
  RestFactor factor(s.matrix);
  ASSERT_TRUE(factor.patience().has_value());
  std::mt19937_64 random(101);
  for (int i = 0; i < 3; ++i) {
    const auto positions = turned(s, random_rotation(random));
    s.elements.update(s.threads, positions);
    s.matrix.assemble(s.threads, s.diagonal);
    s.system.update_preconditioner(s.threads);
    Eigen::MatrixXd a = s.dense();
    s.restrict(a);
    const auto r = s.random_free_vector(102);
    auto z = floats_by_row(s, s.random_free_vector(103));
    factor.update(s.threads, s.couplings, positions);
    const double inner = factor.apply(s.threads, floats_by_row(s, r), z);
    const Eigen::VectorXd expected = a.llt().solve(to_eigen(r));
    EXPECT_LT((to_eigen(by_point(s, z)) - expected).norm(), 1e-3 * expected.norm());
    EXPECT_NEAR(inner, to_eigen(r).dot(expected), 1e-3 * std::abs(inner));
  }
}

/// Points in couplings keep what they had; the others make up a symmetric positive definite P^-1.
TEST(RestFactor, LeavesPointsInCouplingsToJacobiAndStaysSymmetric) {
  System s(1);
  const auto positions = noisy(s.bodies, 0.02, 104);
  RestFactor factor(s.matrix);
  factor.patience();
  factor.update(s.threads, s.couplings, positions);
  const auto apply = [&](const std::vector<Vec3>& r) {
    auto z = floats_by_row(s, std::vector<Vec3>(r.size()));
    factor.apply(s.threads, floats_by_row(s, r), z);
    return by_point(s, z);
  };
  const auto r = s.random_free_vector(105);
  const auto q = s.random_free_vector(106);
  auto start = s.random_free_vector(107);
  auto z = floats_by_row(s, start);
  factor.apply(s.threads, floats_by_row(s, r), z);
  const auto found = by_point(s, z);
  int held = 0;
  for (std::size_t p = 0; p < s.free.size(); ++p) {
    if (s.free[p] == 0 || !s.couplings.holds(static_cast<Index>(p))) continue;
    ++held;
    EXPECT_LT(length(found[p] - start[p]), 1e-6);
  }
  EXPECT_GT(held, 10);
  const double one = to_eigen(q).dot(to_eigen(apply(r)));
  const double other = to_eigen(r).dot(to_eigen(apply(q)));
  EXPECT_NEAR(one, other, 1e-4 * to_eigen(apply(r)).norm() * to_eigen(q).norm());
  EXPECT_GT(to_eigen(r).dot(to_eigen(apply(r))), 0.0);
}

/// A stiff bar, fixed at one end, bent and let go.
struct Bar {
  explicit Bar(int thread_count)
      : bodies(single_body(irregular_box_mesh({16, 3, 3}, {0.8, 0.1, 0.1}, 0.2))),
        dynamics(bodies, std::vector<Material>(1, {1e7, 0.4, 1000.0, 0.0, 1e-3}),
                 select(bodies, [](const Vec3& p) { return p.x == 0.0; }), std::vector<std::uint8_t>(1, 0),
                 parallel::Threads(thread_count)) {
    std::vector<Vec3> bent;
    for (const Vec3& p : bodies.points_rest()) {
      const double a = 1.5 * p.x;  // of a circle
      bent.push_back({(1.0 / 1.5 - p.z) * std::sin(a), p.y, 1.0 / 1.5 - (1.0 / 1.5 - p.z) * std::cos(a)});
    }
    dynamics.set_positions(bent);
  }
  SolveReport solve(const SolveGoal& goal) {
    dynamics.begin_step(0.01, {0.0, 0.0, -9.81}, {});
    return dynamics.solve({}, goal);
  }
  Bodies bodies;
  Dynamics dynamics;
};

TEST(RestFactor, SolvesABentBarInFewIterationsToTheErrorAskedFor) {
  Bar exact(1);
  exact.solve({.tolerance = 1e-12, .max_iterations = 9000, .preconditioner = Preconditioner::jacobi});
  const Eigen::VectorXd expected = to_eigen(exact.dynamics.mean_velocities());
  for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-6}) {
    SolveGoal goal{.tolerance = tolerance,
                   .max_iterations = 2000,
                   .of_solution = true,
                   .preconditioner = Preconditioner::jacobi};
    Bar first(1);
    const SolveReport jacobi = first.solve(goal);
    goal.preconditioner = Preconditioner::factor;
    Bar second(1);
    const SolveReport report = second.solve(goal);
    EXPECT_TRUE(report.factor);
    EXPECT_TRUE(report.converged);
    EXPECT_LT(5 * report.iterations, jacobi.iterations) << tolerance;
    const Eigen::VectorXd found = to_eigen(second.dynamics.mean_velocities());
    EXPECT_LT((found - expected).norm(), 2.0 * tolerance * expected.norm()) << report.iterations;
  }
}

TEST(RestFactor, AutomaticGoesToItByCountsAndStays) {
  Bar bar(1);
  SolveGoal goal{.tolerance = 1e-6,
                 .max_iterations = 2000,
                 .of_solution = true,
                 .preconditioner = Preconditioner::automatic};
  const SolveReport first = bar.solve(goal);
  EXPECT_TRUE(first.factor);
  EXPECT_EQ(first.stage, Stage::factor);
  bar.dynamics.end_step();
  const SolveReport second = bar.solve(goal);
  EXPECT_TRUE(second.factor);
  EXPECT_LT(second.iterations, first.iterations);
}

TEST(RestFactor, GivesTheSameBitsForEveryThreadCount) {
  Bar reference(1);
  const SolveGoal goal{.tolerance = 1e-5,
                       .max_iterations = 300,
                       .of_solution = true,
                       .preconditioner = Preconditioner::factor};
  reference.solve(goal);
  for (const int threads : {2, 5}) {
    Bar bar(threads);
    bar.solve(goal);
    EXPECT_TRUE(std::ranges::equal(bar.dynamics.mean_velocities(), reference.dynamics.mean_velocities()));
  }
}

}  // namespace
}  // namespace palpate::fem::test
