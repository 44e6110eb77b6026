#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "fem/contact_solver.hpp"
#include "fem/padded_vectors.hpp"

namespace palpate::fem {

/// State of a solve.
struct ContactSolver::Run {
  const parallel::Threads& threads;
  const ContactProblem& problem;
  std::span<const simd::Padded3> b;
  std::span<simd::Padded3> x;
  const SolveGoal& goal;
  Multigrid& multigrid;
  std::span<const Vec3> positions;
  SolveReport report{};
  int change_at = std::numeric_limits<int>::max();  ///< iteration at which `automatic` changes to multigrid
  double scale = 1.0;                               ///< the true residual is the float residual times this
  double guess_by_mass = 0.0;                       ///< x^T M x at c = 0
  double squares = 0.0;                             ///< |residual|^2, scaled
  double by_mass = 0.0;                             ///< squared size of the float residual, weighted by 1 / m
  double decrease = 0.0;       ///< z^T r of the last direction: decrease of the energy for a unit of c
  double size = 0.0;           ///< mass norm of x
  int residual_checks = 0;     ///< number of checks of the true residual
  double past_residual = 0.0;  ///< true size of the residual at step `past`, N s
  int inner = 1;               ///< largest number of iterations that make a direction
  int steps = 0;               ///< steps in the span
  int past = 0;                ///< number of steps at the last check of the number of directions
  int renew_at = 0;            ///< iteration at which the preconditioner is renewed
  bool broken = false;         ///< the last direction was linearly dependent
  bool exact_products = false;
  bool stiff = false;         ///< LinearSystem::needs_exact_products()
  double rigid_change = 0.0;  ///< LinearSystem::rigid_change() of the true residual

  [[nodiscard]] std::span<Coupling> contacts() const {
    return problem.couplings.subspan(problem.couplings.size() - problem.laws.size());
  }
  [[nodiscard]] std::span<const Index> points() const { return problem.system->blocks().point_of_row(); }
  [[nodiscard]] double residual() const { return scale * std::sqrt(squares); }
  /// Bound of the error in the mass norm: A is at least the matrix of the masses.
  [[nodiscard]] double error_bound() const { return scale * std::sqrt(by_mass); }
  [[nodiscard]] double solution_unit() const { return std::max(size, goal.least_scale); }
  [[nodiscard]] bool reached() const {
    return (goal.of_solution ? report.relative_error : report.relative_residual) <= goal.tolerance;
  }
  [[nodiscard]] bool rigid_part_is_small() const {
    return goal.allows_rigid_change(rigid_change, solution_unit());
  }
  /// Relative velocity of a coupling with this part of the solution.
  [[nodiscard]] Vec3 relative_velocity(const Coupling& coupling, double part = 1.0) const {
    Vec3 u;
    for (std::size_t i = 0; i < 5; ++i) {
      const Index point = coupling.points[i];
      if (point < 0) continue;
      u += coupling.coefficients[i] * (unpadded(at(problem.base, point)) + part * unpadded(at(x, point)));
    }
    return u;
  }
};

}  // namespace palpate::fem
