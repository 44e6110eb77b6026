#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fem/block_matrix.hpp"
#include "fem/coarse_space.hpp"
#include "fem/coupling.hpp"

namespace palpate::fem {

/// The matrix of a step, A = B + W with B a BlockMatrix and W a CouplingSystem, restricted to the free
/// points, and its block-Jacobi preconditioner.
///
/// The restriction is exact: rows of points that are not free give zero, and vectors are zero there, so their
/// columns have no part either. Refers to B and W, which must outlive it.
class LinearSystem {
 public:
  /// \param free  (n_points) 1 where a point may move, those of B and W
  LinearSystem(const BlockMatrix& blocks, CouplingSystem& couplings, std::vector<std::uint8_t> free);

  [[nodiscard]] std::size_t size() const { return free_.size(); }  ///< n_points
  [[nodiscard]] std::span<const std::uint8_t> free() const { return free_; }

  /// diag(A): a lower bound of A, since the rest is positive semi-definite; 1 where not free.
  [[nodiscard]] std::span<const double> masses() const { return masses_; }
  [[nodiscard]] std::span<const double> inverse_masses() const {
    return inverse_masses_;
  }  ///< 0 where not free

  /// Takes over the masses and inverts the diagonal blocks of A as they are now. O(n_points).
  void update_preconditioner(const parallel::Threads& threads);

  /// CoarseSpace::update() with A as it is now.
  void update_coarse(const parallel::Threads& threads, CoarseSpace& coarse,
                     std::span<const Vec3> positions) const;

  /// y = A x at free points, 0 elsewhere; x and y are of (n_points). Returns the sum of x y over the free
  /// points. O(n_blocks).
  double multiply(const parallel::Threads& threads, std::span<const simd::Padded3> x,
                  std::span<simd::Padded3> y);
  /// The inverted diagonal blocks of A, 12 values a point (simd::GradientVectors); 0 where a point is not
  /// free.
  [[nodiscard]] std::span<const simd::Padded3> inverse_diagonal() const { return inverse_diagonal_; }

 private:
  const BlockMatrix* blocks_;
  CouplingSystem* couplings_;
  std::vector<std::uint8_t> free_;
  std::vector<double> masses_;
  std::vector<double> inverse_masses_;
  std::vector<simd::Padded3> inverse_diagonal_;  ///< three columns a point
  std::vector<double> partial_;
};

}  // namespace palpate::fem
