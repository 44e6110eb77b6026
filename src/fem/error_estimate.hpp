#pragma once

#include <cstddef>
#include <vector>

namespace palpate::fem {

/// The error of conjugate gradients in the norm of A, from the step lengths alone.
///
/// Iteration k lowers |e|_A^2 by d_k = step_k (r_k, z_k) (Hestenes & Stiefel 1952, theorem 6:1), so that the
/// sum of d_l .. d_k is a lower bound of |e_l|_A^2, and the better the more iterations follow l. Meurant,
/// Papez & Tichy, "Accurate error estimation in CG", Numer. Algorithms 88 (2021), section 4: how far d_k
/// alone is from |e_k|_A^2 is taken from the iterations before, |e_k|^2 ~ S d_k with S the largest ratio of
/// that sum to d_l, over the l since the sum was 10^4 times what d_k is. Deviation: theirs finds how long to
/// wait; this takes S d_k as the estimate, with no wait.
class ErrorEstimate {
 public:
  /// \param enough  iterations before there is an estimate
  void clear(std::size_t enough = 4);
  /// Takes d_k of the next iteration. O(k).
  void add(double decrease);
  /// What the next iteration would lower it by, if its step is as long as the last: where each lowers it a
  /// lot, that says how large the error is now, without an iteration more. Twice that, as steps differ.
  void look_ahead(double next_decrease);
  /// Estimate of |e_k|_A before the iteration of the last add(): the error now is smaller. Infinite before
  /// there are enough iterations to judge by.
  [[nodiscard]] double error() const { return error_; }

 private:
  std::vector<double> decreases_;
  std::vector<double> tails_;  ///< sum of the decreases from each on
  std::size_t enough_ = 4;
  double ratio_ = 1.0;
  double error_ = 0.0;
};

}  // namespace palpate::fem
