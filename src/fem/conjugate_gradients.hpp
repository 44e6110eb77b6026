#pragma once

#include <span>
#include <vector>

#include <palpate/settings.hpp>

#include "fem/coarse_space.hpp"
#include "fem/error_estimate.hpp"
#include "fem/linear_system.hpp"
#include "parallel/parallel.hpp"

namespace palpate::fem {

/// When a solve stops. Residuals are measured by their plain norm, solutions by mass, |x|^2 = sum m_i x_i^2
/// with the masses of LinearSystem.
struct SolveGoal {
  double tolerance = 0.0;  ///< >= 0
  int max_iterations = 0;  ///< cap, >= 0
  /// The tolerance is of the error of the solution, relative to the solution; false: of the residual,
  /// relative to the right side.
  bool of_solution = false;
  /// Of them automatic means: block Jacobi, and two levels from patience() on.
  Preconditioner preconditioner = Preconditioner::jacobi;
  /// Exactly so many iterations, whatever the error; 0: as many as the tolerance asks for.
  int fixed_iterations = 0;
  /// Where what the tolerance is relative to is smaller, these are.
  double least_scale = 0.0;     ///< of the solution
  double least_residual = 0.0;  ///< of the right side
};

/// How a linear system was solved.
struct SolveReport {
  int iterations = 0;  ///< products with the matrix after the first
  double relative_residual =
      0.0;  ///< |b - A x| / max(|b|, least_residual) as the recurrence has it; 0 where b = 0
  /// Estimated error of the solution / max(|x|, least_scale), in the norm of A, which no error by mass
  /// exceeds.
  double relative_error = 0.0;
  bool two_level = false;  ///< the preconditioner had two levels, at least in the end
  bool converged = false;  ///< the goal is reached
};

/// Preconditioned conjugate gradients (Hestenes & Stiefel, J. Res. NBS 49 (1952), with a preconditioner as in
/// Saad, "Iterative Methods for Sparse Linear Systems", 2nd ed., algorithm 9.1), in three passes an
/// iteration: the product with p^T A p, the update of solution, residual and preconditioned residual with all
/// sums, the next direction. Sums have a fixed order: the same bits for every thread count. Keeps its memory
/// between solves.
///
/// A - diag(m) is positive semi-definite, so that for an error e of residual r |e| <= |e|_A <= |r|: the
/// residual is a bound, and the first two say what ErrorEstimate means for the speeds.
class ConjugateGradients {
 public:
  /// Solves A x = b over the free points of the system.
  ///
  /// \param b  (n_points), zero at points that are not free
  /// \param x  (n_points): a guess on entry, zero at points that are not free; the solution on return. A
  /// guess
  ///           that is worse than zero, by its residual, is dropped.
  /// \param coarse     the second level of the preconditioner; nullptr: there is none, whatever the goal says
  /// \param positions  (n_points), for its update()
  /// Iteration stops early, unconverged, where p^T A p is not a positive number; x stays the last good
  /// iterate.
  SolveReport solve(const parallel::Threads& threads, LinearSystem& system, std::span<const simd::Padded3> b,
                    std::span<simd::Padded3> x, const SolveGoal& goal, CoarseSpace* coarse = nullptr,
                    std::span<const Vec3> positions = {});
  /// Iterations after which Preconditioner::automatic takes two levels: what these cost to set up grows with
  /// the number of aggregates, about a product each.
  static int patience(const CoarseSpace& coarse) { return 50 + coarse.size(); }

 private:
  double start(const parallel::Threads& threads, LinearSystem& system, std::span<const simd::Padded3> b,
               std::span<simd::Padded3> x);
  simd::VectorSums advance(const parallel::Threads& threads, const simd::GradientVectors& vectors,
                           double step);
  void turn(const parallel::Threads& threads, const simd::GradientVectors& vectors, double turn);

  std::vector<simd::Padded3> residual_;
  std::vector<simd::Padded3> preconditioned_;
  std::vector<simd::Padded3> direction_;
  std::vector<simd::Padded3> product_;
  std::vector<simd::VectorSums> partial_;
  std::vector<double> partial_sums_;
  ErrorEstimate estimate_;
};

}  // namespace palpate::fem
