#pragma once

#include <cstddef>
#include <vector>

namespace palpate::fem {

/// Estimates the error of conjugate gradients in the norm of A, from the step lengths alone.
///
/// Iteration k lowers |e|_A^2 by d_k = step_k (r_k, z_k) (Hestenes & Stiefel 1952, theorem 6:1). So the sum
/// of d_l .. d_k is a lower bound of |e_l|_A^2, and the bound improves with the number of iterations after l.
/// Meurant, Papez & Tichy, "Accurate error estimation in CG", Numer. Algorithms 88 (2021), section 4: |e_k|^2
/// ~ S d_k. S is the largest ratio of that sum to d_l in earlier iterations l, back to where the sum was 10^4
/// d_k. Deviation: their method determines a delay; here S d_k is used without a delay.
class ErrorEstimate {
 public:
  void clear();
  /// Adds d_k of the next iteration. O(k).
  void add(double decrease);
  /// Estimate of |e_k|_A before the iteration of the last add(); the error now is smaller. Infinite while
  /// there are too few iterations.
  [[nodiscard]] double error() const { return error_; }

 private:
  std::vector<double> decreases_;
  std::vector<double> tails_;  ///< sum of the decreases from each on
  double error_ = 0.0;
};

/// Estimates the error of conjugate gradients in the mass norm, for fast convergence. The sum of all later
/// changes of the solution bounds the error. Later changes are assumed to shrink like earlier ones: |e_k| ~ S
/// |change k|, where S is the largest ratio, over the last changes, of the sum of all changes from one on to
/// that change. The energy norm of the error depends on the stiffness of the tissue; this estimate is the
/// error of positions.
class ChangeEstimate {
 public:
  /// Begins a sequence of changes.
  /// \param window  >= 1; the largest of so many last changes counts as the last one. With contacts and
  ///     multigrid, single changes are small although the error is not. There is no estimate before as many
  ///     changes, and two.
  void begin(std::size_t window);
  /// Adds the size of the next change. O(k).
  void add(double size);
  /// Estimate of the error before the last change; the current error is smaller. Infinite while there are too
  /// few changes.
  [[nodiscard]] double error() const { return error_; }
  /// The estimate if the next change, which has not been made yet, has this size.
  [[nodiscard]] double before(double size) const;

 private:
  std::size_t window_ = 1;
  std::vector<double> sizes_;
  std::vector<double> tails_;
  double ratio_ = 1.0;
  double error_ = 0.0;
};

}  // namespace palpate::fem
