#pragma once

#include <span>
#include <vector>

#include "fem/linear_system.hpp"
#include "parallel/parallel.hpp"
#include "simd/aligned.hpp"

namespace palpate::fem {

/// A few iterations of conjugate gradients with block Jacobi, as a variable preconditioner (Axelsson &
/// Vassilevski, SIAM J. Matrix Anal. Appl. 12 (1991)): z ~ A^-1 r. Vectors are in float, by rows,
/// simd::slice_values a slice. Sums have a fixed order, so the bits are the same for every thread count.
/// Keeps its memory between calls.
class InnerSolve {
 public:
  /// Starts from z = 0 and returns the number of iterations. Call after update_preconditioner() of the
  /// system. O(n_blocks) an iteration. \param most  largest number of iterations, >= 1 \param reduction stops
  /// when the norm of the residual has fallen to this fraction
  int apply(const parallel::Threads& threads, LinearSystem& system, std::span<const float> r,
            std::span<float> z, int most, double reduction);

 private:
  simd::VectorSums advance(const parallel::Threads& threads, const simd::GradientVectors& vectors,
                           double step);

  simd::AlignedVector<float> residual_;
  simd::AlignedVector<float> preconditioned_;
  simd::AlignedVector<float> product_;
  simd::AlignedVector<float> zero_;  ///< the guess
  simd::AlignedVector<simd::Quad> direction_;
  std::vector<simd::VectorSums> partial_;
};

}  // namespace palpate::fem
