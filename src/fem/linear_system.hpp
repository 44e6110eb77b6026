#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fem/block_matrix.hpp"
#include "fem/coupling.hpp"

namespace palpate::fem {

/// The matrix of a step, A = B + W with B a BlockMatrix and W a CouplingSystem, restricted to the free
/// points, and its block-Jacobi preconditioner.
///
/// There are two products with it. The exact one is in double and by point: the stiffness of each element
/// times the vectors at its corners. The other is in float, by rows of B, and two or three times as fast:
/// solvers iterate with it. They differ by the rounding of B's blocks.
///
/// The restriction is exact: rows of points that are not free give zero, and vectors are zero there, so their
/// columns have no effect either. Refers to B and W, which must outlive it.
class LinearSystem {
 public:
  /// \param free  (n_points) 1: may move; the same as for B and W
  LinearSystem(const BlockMatrix& blocks, CouplingSystem& couplings, std::vector<std::uint8_t> free);

  [[nodiscard]] std::size_t size() const { return free_.size(); }  ///< n_points
  [[nodiscard]] std::span<const std::uint8_t> free() const { return free_; }
  [[nodiscard]] const BlockMatrix& blocks() const { return *blocks_; }
  [[nodiscard]] const CouplingSystem& couplings() const { return *couplings_; }
  [[nodiscard]] CouplingSystem& couplings() { return *couplings_; }

  /// Lower bound of A by row: m, since A - diag(m) is positive semi-definite. And its inverse, 0 in padding
  /// rows.
  [[nodiscard]] std::span<const float> masses() const { return blocks_->masses(); }
  [[nodiscard]] std::span<const float> inverse_masses() const { return inverse_masses_; }

  /// Whether floats are too coarse for products with A: rounding of stiffness is not small compared with the
  /// masses. O(n_points).
  [[nodiscard]] bool needs_exact_products(const parallel::Threads& threads);

  /// Largest change of velocity that a residual would give to a body if it were rigid and free: its root mean
  /// square by mass, times the root of the mass of all free points, so that it compares with norms by mass.
  /// Without couplings, this is the rigid part of the error of that body. Bodies with points that are not
  /// free are left out. In double, so that elastic forces, which add up to zero, have no effect. O(n_points),
  /// parallel over bodies.
  [[nodiscard]] double rigid_change(const parallel::Threads& threads, std::span<const simd::Padded3> residual,
                                    std::span<const Vec3> positions);

  /// Copies the couplings and inverts the diagonal blocks of A as they are now. O(n_points).
  void update_preconditioner(const parallel::Threads& threads);

  /// y = A x at free points, 0 elsewhere, in double; x and y are (n_points). x may be nonzero at points that
  /// are not free. O(n_elements).
  void multiply_exactly(const parallel::Threads& threads, std::span<const simd::Padded3> x,
                        std::span<simd::Padded3> y);
  /// y = B x: the same without the couplings.
  void multiply_blocks_exactly(const parallel::Threads& threads, std::span<const simd::Padded3> x,
                               std::span<simd::Padded3> y);
  /// y = A x by rows, in float; returns the sum of x y. O(n_blocks).
  /// \param x  (row_count)
  /// \param y  simd::slice_values a slice
  double multiply(const parallel::Threads& threads, std::span<const simd::Quad> x, std::span<float> y);
  /// The diagonal blocks of A, simd::slice_symmetric a slice.
  [[nodiscard]] std::span<const float> diagonal() const { return diagonal_; }
  /// The inverted diagonal blocks of A, simd::slice_symmetric a slice.
  [[nodiscard]] std::span<const float> inverse_diagonal() const { return inverse_diagonal_; }

 private:
  struct PointRange {
    std::size_t begin = 0;
    std::size_t end = 0;
  };
  struct RigidChange {
    double mass = 0.0;              ///< of the free points
    double squared_velocity = 0.0;  ///< mean by mass
  };
  [[nodiscard]] RigidChange rigid_change(const PointRange& points, std::span<const simd::Padded3> residual,
                                         std::span<const Vec3> positions) const;
  template <class OfPoint>
  void add_blocks(const parallel::Threads& threads, std::span<const simd::Padded3> x,
                  std::span<simd::Padded3> y, OfPoint&& of_point);

  const BlockMatrix* blocks_;
  CouplingSystem* couplings_;
  std::vector<std::uint8_t> free_;
  std::vector<Index> body_of_point_;  ///< -1: no element
  std::vector<PointRange> bodies_;    ///< those that have elements
  std::vector<RigidChange> changes_;  ///< of each of them, scratch
  simd::AlignedVector<float> inverse_masses_;
  simd::AlignedVector<float> diagonal_;  ///< diagonal blocks with couplings
  simd::AlignedVector<float> inverse_diagonal_;
  std::vector<double> partial_;
};

}  // namespace palpate::fem
