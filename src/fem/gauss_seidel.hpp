#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fem/linear_system.hpp"
#include "parallel/parallel.hpp"
#include "simd/aligned.hpp"
#include "simd/gauss_seidel.hpp"

namespace palpate::fem {

/// Block Gauss-Seidel for the matrix of a step, colour by colour: no element connects rows of a colour, so
/// they are updated at once. Couplings between colours have their current values. For couplings within a
/// colour, a bound of the neglected terms is added to the diagonal, so that the smoother converges (l1
/// smoothing: Baker, Falgout, Kolev & Yang, "Multigrid smoothers for ultraparallel computing", SIAM J. Sci.
/// Comput. 33 (2011)). The same bits for every thread count.
class GaussSeidel {
 public:
  explicit GaussSeidel(const BlockMatrix& matrix);

  /// Copies the matrix and the couplings after LinearSystem::update_preconditioner(). O(n_points +
  /// n_couplings).
  void update(const parallel::Threads& threads, const LinearSystem& system);
  /// Sweeps over all colours for A z = r; z by rows, r by slices. The forward sweep starts from z = 0, so it
  /// needs only half of the matrix; simd::rotated_residual() needs the other half and rest().
  void forward(const parallel::Threads& threads, LinearSystem& system, std::span<const float> r,
               std::span<simd::Quad> z);
  void backward(const parallel::Threads& threads, LinearSystem& system, std::span<const float> r,
                std::span<simd::Quad> z) const;
  /// Part of the residual of the last forward(), for simd::rotated_residual().
  [[nodiscard]] const float* rest() const { return rest_.data(); }
  /// The matrix in the layout of the kernels.
  /// \param rotations  for kernels that rotate unknowns
  [[nodiscard]] simd::SmootherRows rows(const LinearSystem& system, const float* rotations) const;

 private:
  void bound_couplings(const LinearSystem& system);
  template <class Kernel>
  void relax(const parallel::Threads& threads, LinearSystem& system, std::span<simd::Quad> z,
             std::size_t color, Kernel&& kernel) const;

  const BlockMatrix* matrix_;
  std::vector<std::uint32_t> color_of_slice_;
  std::vector<std::uint32_t> coupling_begin_;     ///< (n_colors + 1): couplings of rows of a colour
  std::vector<std::uint32_t> next_;               ///< scratch
  std::vector<std::uint32_t> coupling_of_color_;  ///< ascending in each
  simd::AlignedVector<float> diagonal_;
  simd::AlignedVector<float> inverses_;
  simd::AlignedVector<float> rest_;  ///< by slices, where couplings act
};

}  // namespace palpate::fem
