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

/// When a solve stops. Residuals are measured in the Euclidean norm. Solutions are measured in the mass norm,
/// |x|^2 = sum m_i x_i^2, with the masses of LinearSystem.
struct SolveGoal {
  /// Allowed drift of a float residual from the true one, as a fraction of the tolerance.
  static constexpr double drift = 0.1;
  double tolerance = 0.0;  ///< >= 0
  int max_iterations = 0;  ///< cap, >= 0
  /// true: the tolerance is for the error, relative to the solution; false: for the residual, relative to the
  /// right side.
  bool of_solution = false;
  Preconditioner preconditioner = Preconditioner::jacobi;
  /// The solution only predicts positions, so it takes few iterations, perhaps of block Jacobi.
  bool rough = false;
  /// Number of block-Jacobi iterations that were not enough in an earlier solve (SolveReport), or 0.
  int jacobi_iterations = 0;
  /// Error for each unit of the bound of the error, in an earlier solve with contacts (SolveReport), or 0.
  double error_per_bound = 0.0;
  /// Exact number of iterations, regardless of the error; 0: until the tolerance is reached.
  int fixed_iterations = 0;
  /// Lower bounds of the two norms that the tolerance is relative to.
  double least_scale = 0.0;     ///< of the solution
  double least_residual = 0.0;  ///< of the right side
  /// Norm of the solution for loads alone: a failed solve of stiff bodies may not be larger.
  double load_scale = 0.0;

  /// Whether the rigid part of the error is small. Contacts make its bound larger than the error.
  /// \param change  LinearSystem::rigid_change() of the residual
  /// \param unit    norm of the solution
  [[nodiscard]] bool allows_rigid_change(double change, double unit) const {
    constexpr double of_contacts = 30.0;
    return !of_solution || change <= of_contacts * tolerance * unit;
  }
};

/// The result of solving a linear system.
struct SolveReport {
  int iterations = 0;              ///< products with the matrix after the first
  double relative_residual = 0.0;  ///< |b - A x| / max(|b|, least_residual), from the recurrence; 0 if b = 0
  /// Estimated error of the solution / max(|x|, least_scale). With multigrid it is in the mass norm,
  /// otherwise in the norm of A, which is an upper bound of the mass norm.
  double relative_error = 0.0;
  bool multigrid = false;  ///< the last preconditioner was multigrid
  /// Number of block-Jacobi iterations that were not enough so far, with Preconditioner::automatic. The next
  /// solve begins with multigrid if that needs no more products.
  int jacobi_iterations = 0;
  /// Of the last solve with contacts that was long enough to know its error: the estimate, divided by the
  /// bound that follows from the residual (ContactSolver).
  double error_per_bound = 0.0;
  bool converged = false;  ///< the goal is reached
  int solves = 1;          ///< number of solves that these iterations belong to
};

/// Preconditioned conjugate gradients (Hestenes & Stiefel, J. Res. NBS 49 (1952); preconditioned as in Saad,
/// "Iterative Methods for Sparse Linear Systems", 2nd ed., algorithm 9.1). An iteration has three passes: the
/// product with p^T A p; the update of solution, residual and preconditioned residual, with all sums; the
/// next direction. Sums have a fixed order, so the bits are the same for every thread count. Keeps its memory
/// between solves.
///
/// Iterations are in float, with a float matrix, on a residual scaled to about 1. Their sum is checked in
/// double: if the true residual differs from that of the iterations by more than the goal allows, it replaces
/// it (residual replacement: van der Vorst & Ye, SIAM J. Sci. Comput. 22 (2000)). Iterations continue until
/// both agree. If the stiffness is too large for a float matrix, products are in double.
///
/// A - diag(m) is positive semi-definite. So an error e with the residual r has |e| <= |e|_A <= |r|. The
/// residual bounds the error; and ErrorEstimate, an estimate of |e|_A, bounds the error in the mass norm.
class ConjugateGradients {
 public:
  /// Solves A x = b over the free points of the system.
  ///
  /// \param b  (n_points), zero at points that are not free
  /// \param x  (n_points). On entry a guess, zero at points that are not free; on return the solution. If the
  ///     residual of the guess is larger than that of zero, zero is used
  /// \param multigrid  nullptr: no multigrid, regardless of the goal
  /// \param positions  (n_points), for Multigrid::update()
  ///
  /// Iteration stops early, not converged, if p^T A p is not a positive number. Then x is the last good
  /// iterate.
  SolveReport solve(const parallel::Threads& threads, LinearSystem& system, std::span<const simd::Padded3> b,
                    std::span<simd::Padded3> x, const SolveGoal& goal, Multigrid* multigrid = nullptr,
                    std::span<const Vec3> positions = {});
  /// Number of block-Jacobi iterations after which Preconditioner::automatic changes to multigrid: the cost
  /// of a typical multigrid solve, in products, including couplings on coarse levels. It is a count and not a
  /// time, so it is the same on every machine.
  static int patience(const LinearSystem& system);
  /// Whether Preconditioner::automatic starts with block Jacobi. \param failed  iterations of it that were
  /// not enough so far \param most  patience()
  static bool tries_jacobi(int failed, int most);

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
    int change_at = 0;  ///< iteration at which `automatic` changes to multigrid
    double size_b = 0.0;
    double scale = 1.0;    ///< factor from float vectors to true ones
    double largest = 0.0;  ///< Euclidean norm of the residual when it was last replaced by the true one
    double loaded_by_mass = 0.0;  ///< squared norm of the float residual at that time, by 1 / mass
    double last_drift = 0.0;  ///< last computed distance between float and true residual, in the mass norm
    double last_preconditioned = 0.0;  ///< r^T z before the last iteration, unscaled
    double next_change = 0.0;          ///< with multigrid: mass norm of the preconditioned true residual
    int iterations_since = 0;          ///< iterations since the residual was last replaced
    bool direction_holds =
        false;  ///< the true residual is close to the recurrence, so directions stay conjugate
    bool exact_products = false;  ///< products in double
    bool stiff = false;           ///< LinearSystem::needs_exact_products()
    double rigid_change = 0.0;    ///< LinearSystem::rigid_change() of the true residual
    simd::VectorSums sums{};      ///< of the float vectors

    [[nodiscard]] double residual_unit() const { return std::max(size_b, goal.least_residual); }
    [[nodiscard]] double solution_unit() const {
      return std::max(scale * std::sqrt(sums.solution), goal.least_scale);
    }
    [[nodiscard]] bool rigid_part_is_small() const {
      return goal.allows_rigid_change(rigid_change, solution_unit());
    }
    /// Whether the goal is reached according to a bound, not an estimate.
    [[nodiscard]] bool bounded(const SolveReport& report) const {
      return !goal.of_solution || scale * std::sqrt(sums.by_mass) <= report.relative_error * solution_unit();
    }
  };
  double start(Run& run);
  static bool diverges(const Run& run);
  bool is_worse_than_zero(const Run& run);
  void find_rigid_change(Run& run);
  void find_residual(Run& run);
  void load(Run& run);
  void flush(Run& run);
  void discard(Run& run);
  bool check_true_residual(Run& run, SolveReport& report);
  double replace(Run& run, const SolveReport& report);
  void choose(Run& run, SolveReport& report);
  static bool may_change(const Run& run);
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

  // One value for each point, in double.
  std::vector<simd::Padded3> residual_;
  std::vector<simd::Padded3> product_;
  // One value for each row, in float and scaled.
  simd::AlignedVector<float> row_residual_;
  simd::AlignedVector<float> row_preconditioned_;
  simd::AlignedVector<float> row_product_;
  simd::AlignedVector<float> row_solution_;  ///< the part of the solution since row_guess_ was set
  simd::AlignedVector<float> row_guess_;     ///< the solution when it was last added up
  simd::AlignedVector<simd::Quad> direction_;
  std::vector<simd::VectorSums> partial_;
  std::vector<double> partial_sums_;
  ErrorEstimate estimate_;
  ChangeEstimate change_estimate_;  ///< with multigrid
};

}  // namespace palpate::fem
