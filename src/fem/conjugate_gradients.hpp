#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include <palpate/settings.hpp>

#include "fem/error_estimate.hpp"
#include "fem/linear_system.hpp"
#include "fem/multigrid.hpp"
#include "parallel/parallel.hpp"

namespace palpate::fem {

/// When a solve stops. Residuals are measured by their plain norm, solutions by mass, |x|^2 = sum m_i x_i^2
/// with the masses of LinearSystem.
struct SolveGoal {
  double tolerance = 0.0;  ///< >= 0
  int max_iterations = 0;  ///< cap, >= 0
  /// true: the tolerance is for the error, relative to the solution; false: for the residual, relative to the
  /// right side.
  bool of_solution = false;
  Preconditioner preconditioner = Preconditioner::jacobi;
  /// Iterations of block Jacobi that did not suffice in an earlier solve (SolveReport), or 0.
  int jacobi_iterations = 0;
  /// Exact number of iterations, regardless of the error; 0: until the tolerance is reached.
  int fixed_iterations = 0;
  /// Lower bounds of the norms that the tolerance is relative to.
  double least_scale = 0.0;     ///< of the solution
  double least_residual = 0.0;  ///< of the right side
};

/// The result of solving a linear system.
struct SolveReport {
  int iterations = 0;              ///< products with the matrix after the first
  double relative_residual = 0.0;  ///< |b - A x| / max(|b|, least_residual) by the recurrence; 0 if b = 0
  /// Estimated error of the solution / max(|x|, least_scale): by mass with multigrid, else in the norm of A,
  /// which is an upper bound of the norm by mass.
  double relative_error = 0.0;
  bool multigrid = false;  ///< the last preconditioner was multigrid
  /// Iterations of block Jacobi that did not suffice with Preconditioner::automatic so far. The next solve
  /// begins with multigrid if that needs no more products.
  int jacobi_iterations = 0;
  bool converged = false;  ///< the goal is reached
  int solves = 1;          ///< number of solves with these iterations
};

/// Preconditioned conjugate gradients (Hestenes & Stiefel, J. Res. NBS 49 (1952), with a preconditioner as in
/// Saad, "Iterative Methods for Sparse Linear Systems", 2nd ed., algorithm 9.1), in three passes per
/// iteration: the product with p^T A p, the update of solution, residual and preconditioned residual with all
/// sums, the next direction. Sums have a fixed order, so the bits are the same for every thread count. Keeps
/// its memory between solves.
///
/// Iterations are in float, on a residual scaled to about 1, with a float matrix. Their sum is checked in
/// double: if the true residual differs from that of the iterations by more than the goal allows, it replaces
/// it (residual replacement: van der Vorst & Ye, SIAM J. Sci. Comput. 22 (2000)), and iterations continue
/// until both agree. If the stiffness is too large for a float matrix, products are in double.
///
/// A - diag(m) is positive semi-definite. So for an error e of residual r, |e| <= |e|_A <= |r|: the residual
/// bounds the error, and ErrorEstimate, which is of |e|_A, bounds the error by mass.
class ConjugateGradients {
 public:
  /// Solves A x = b over the free points of the system.
  ///
  /// \param b  (n_points), zero at points that are not free
  /// \param x  (n_points): a guess on entry, zero at points that are not free; the solution on return. A
  ///           guess that is worse than zero, by its residual, is dropped.
  /// \param multigrid  nullptr: no multigrid, regardless of the goal
  /// \param positions  (n_points), for its update()
  ///
  /// Iteration stops early, unconverged, where p^T A p is not a positive number; x stays the last good
  /// iterate.
  SolveReport solve(const parallel::Threads& threads, LinearSystem& system, std::span<const simd::Padded3> b,
                    std::span<simd::Padded3> x, const SolveGoal& goal, Multigrid* multigrid = nullptr,
                    std::span<const Vec3> positions = {});
  /// Iterations of block Jacobi after which Preconditioner::automatic changes to multigrid: the cost of a
  /// usual multigrid solve in products, including couplings on coarse levels. It is a count and not a time,
  /// so it is the same on every machine.
  static int patience(const LinearSystem& system);

 private:
  /// State of a solve.
  struct Run {
    const parallel::Threads& threads;
    LinearSystem& system;
    std::span<const simd::Padded3> b;
    std::span<simd::Padded3> x;
    const SolveGoal& goal;
    Multigrid* multigrid;
    std::span<const Vec3> positions;
    int change_at = 0;  ///< iteration at which automatic changes to multigrid
    double size_b = 0.0;
    double scale = 1.0;       ///< true vectors over float vectors
    double largest = 0.0;     ///< plain norm of the residual when it was last replaced by the true one
    double last_drift = 0.0;  ///< distance to the true residual, by mass, at its last computation
    double last_preconditioned = 0.0;  ///< r^T z before the last iteration, unscaled
    double next_change = 0.0;          ///< with multigrid: size of the preconditioned true residual, by mass
    int iterations_since = 0;          ///< iterations since the residual was the true one
    bool direction_holds =
        false;  ///< the true residual is near that of the recurrence, so directions stay conjugate
    bool exact_products = false;  ///< products in double
    simd::VectorSums sums{};      ///< of the float vectors

    [[nodiscard]] double residual_unit() const { return std::max(size_b, goal.least_residual); }
    [[nodiscard]] double solution_unit() const {
      return std::max(scale * std::sqrt(sums.solution), goal.least_scale);
    }
    /// The goal is reached by a bound, not by an estimate.
    [[nodiscard]] bool bounded(const SolveReport& report) const {
      return !goal.of_solution || scale * std::sqrt(sums.by_mass) <= report.relative_error * solution_unit();
    }
  };
  double start(const Run& run);
  void find_residual(const Run& run);
  void load(Run& run);
  void flush(Run& run);
  bool check_true_residual(Run& run, SolveReport& report);
  double replace(Run& run, const SolveReport& report);
  void choose(Run& run, SolveReport& report);
  void change(Run& run, SolveReport& report);
  void precondition(Run& run, const SolveReport& report);
  void resize(const LinearSystem& system);
  static bool reached(const SolveGoal& goal, const SolveReport& report, double fraction);
  void estimate_error(const Run& run, SolveReport& report) const;
  double drift(const Run& run);
  double direction_size(const Run& run);
  double preconditioned_size(const Run& run);
  void clear_estimates();
  double multiply(Run& run);
  simd::GradientVectors vectors(const Run& run);
  simd::VectorSums advance(const Run& run, double step);
  void next_direction(const Run& run, double beta);

  // By point, in double.
  std::vector<simd::Padded3> residual_;
  std::vector<simd::Padded3> product_;
  // By row, in float and scaled.
  simd::AlignedVector<float> row_residual_;
  simd::AlignedVector<float> row_preconditioned_;
  simd::AlignedVector<float> row_product_;
  simd::AlignedVector<float> row_solution_;  ///< since the last flush
  simd::AlignedVector<float> row_guess_;     ///< the solution at the last flush
  simd::AlignedVector<simd::Quad> direction_;
  std::vector<simd::VectorSums> partial_;
  std::vector<double> partial_sums_;
  ErrorEstimate estimate_;
  ChangeEstimate change_estimate_;  ///< with multigrid
};

}  // namespace palpate::fem
