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
  /// The tolerance is of the error of the solution, relative to the solution; false: of the residual,
  /// relative to the right side.
  bool of_solution = false;
  Preconditioner preconditioner = Preconditioner::jacobi;
  /// Iterations of block Jacobi that did not suffice in an earlier solve (SolveReport); 0: none.
  int jacobi_iterations = 0;
  /// Exact number of iterations, regardless of the error; 0: until the tolerance is reached.
  int fixed_iterations = 0;
  /// Lower bounds of what the tolerance is relative to.
  double least_scale = 0.0;     ///< of the solution
  double least_residual = 0.0;  ///< of the right side
};

/// The result of solving a linear system.
struct SolveReport {
  int iterations = 0;  ///< products with the matrix after the first
  double relative_residual =
      0.0;  ///< |b - A x| / max(|b|, least_residual) as the recurrence has it; 0 where b = 0
  /// Estimated error of the solution / max(|x|, least_scale): by mass with multigrid, else in the norm of A,
  /// which no error by mass exceeds.
  double relative_error = 0.0;
  bool multigrid = false;  ///< the preconditioner was multigrid, at least in the end
  /// Iterations of block Jacobi that did not suffice with Preconditioner::automatic so far. The next solve
  /// begins with multigrid where that needs no more products.
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
/// A - diag(m) is positive semi-definite, so that for an error e of residual r |e| <= |e|_A <= |r|: the
/// residual is a bound, and the first two say what ErrorEstimate means for the speeds.
class ConjugateGradients {
 public:
  /// Solves A x = b over the free points of the system.
  ///
  /// \param b  (n_points), zero at points that are not free
  /// \param x  (n_points): a guess on entry, zero at points that are not free; the solution on return. A
  ///           guess that is worse than zero, by its residual, is dropped.
  /// \param multigrid  nullptr: no multigrid, regardless of the goal
  /// \param positions  (n_points), for its update()
  /// Iteration stops early, unconverged, where p^T A p is not a positive number; x stays the last good
  /// iterate.
  SolveReport solve(const parallel::Threads& threads, LinearSystem& system, std::span<const simd::Padded3> b,
                    std::span<simd::Padded3> x, const SolveGoal& goal, Multigrid* multigrid = nullptr,
                    std::span<const Vec3> positions = {});
  /// Iterations of block Jacobi after which Preconditioner::automatic takes multigrid: what a usual solve
  /// with that costs in products, with what the couplings cost on coarse levels. A count, so the same
  /// everywhere.
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
    int change_at = 0;  ///< iteration at which automatic takes multigrid
    double size_b = 0.0;
    double scale = 1.0;                ///< of the float vectors: theirs times it are the true ones
    double largest = 0.0;              ///< residual, by its plain norm, when it last was the true one
    double last_drift = 0.0;           ///< from the true residual, by mass, when it was last computed
    double last_preconditioned = 0.0;  ///< r^T z before the last iteration, unscaled
    double next_change = 0.0;          ///< size of the preconditioned true residual, by mass: of multigrid
    int iterations_since = 0;          ///< the residual last was the true one
    bool direction_holds = false;      ///< the true residual is near the one that directions come from
    bool exact_products = false;       ///< in double
    simd::VectorSums sums{};           ///< of the float vectors

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
