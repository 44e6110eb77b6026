#pragma once

#include <span>
#include <vector>

#include "fem/linear_system.hpp"
#include "parallel/parallel.hpp"

namespace palpate::fem {

/// How a linear system was solved.
struct SolveReport {
  int iterations = 0;  ///< products with the matrix after the first
  double relative_residual =
      0.0;                 ///< |b - A x| / max(|b|, least_scale) as the recurrence has it; 0 where b = 0
  bool converged = false;  ///< false: the cap was reached, or the matrix is not positive definite to rounding
};

/// Preconditioned conjugate gradients (Hestenes & Stiefel, J. Res. NBS 49 (1952), with a preconditioner as in
/// Saad, "Iterative Methods for Sparse Linear Systems", 2nd ed., algorithm 9.1). Sums have a fixed order: the
/// same bits for every thread count. Keeps its memory between solves.
class ConjugateGradients {
 public:
  /// Solves A x = b over the free points of the system until |b - A x| <= tolerance max(|b|, least_scale).
  ///
  /// \param b  (n_points x 3), zero at points that are not free
  /// \param x  (n_points x 3): a guess on entry, zero at points that are not free; the solution on return. A
  /// guess that
  ///           is worse than zero is dropped.
  /// Iteration stops early, unconverged, where p^T A p is not a positive number; x stays the last good
  /// iterate.
  SolveReport solve(const parallel::Threads& threads, LinearSystem& system, std::span<const Vec3> b,
                    std::span<Vec3> x, double tolerance, int max_iterations, double least_scale = 0.0);

 private:
  double start(const parallel::Threads& threads, LinearSystem& system, std::span<const Vec3> b, double norm_b,
               std::span<Vec3> x);
  double precondition(const parallel::Threads& threads, const LinearSystem& system);
  double inner_product(const parallel::Threads& threads, std::span<const Vec3> a, std::span<const Vec3> b);

  std::vector<Vec3> residual_;
  std::vector<Vec3> preconditioned_;
  std::vector<Vec3> direction_;
  std::vector<Vec3> product_;
  std::vector<double> partial_;
};

}  // namespace palpate::fem
