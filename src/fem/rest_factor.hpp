#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <palpate/types.hpp>

#include "fem/block_matrix.hpp"
#include "fem/coupling.hpp"
#include "parallel/parallel.hpp"
#include "simd/aligned.hpp"
#include "simd/factor_columns.hpp"

namespace palpate::fem {

/// A preconditioner for stiff bodies: the Cholesky factor L of the system at rest, without couplings, wrapped
/// in the rotations R of the points, P^-1 = R (L L^T)^-1 R^T. A body that only turns is solved by one
/// application (warp cancelling: Hecht, Lee, Shewchuk & O'Brien, "Updated sparse Cholesky factors for
/// corotational elastodynamics", ACM TOG 31 (2012), section 3, without the updates). Points that couplings
/// hold are left to block Jacobi, since a contact that the factor does not know would spoil it: there rows
/// and columns of P^-1 are taken out, so that it stays positive definite.
///
/// Factored once, in double, by Eigen's simplicial Cholesky in the order of approximate minimum degree of the
/// points, then kept in float. Anew only where the time step changes.
class RestFactor {
 public:
  /// \param matrix  must outlive it. O(1).
  explicit RestFactor(const BlockMatrix& matrix) : matrix_(&matrix) {}

  /// Iterations of block Jacobi that take as long as a usual solve with the factor; none where the factor
  /// would be too large. From the pattern alone: the same for every machine. The first call orders the
  /// points.
  std::optional<int> patience();
  /// Factors where there is no factor of this system yet; then rotations at these positions (n_points x 3),
  /// and which rows are taken. O(n_blocks).
  void update(const parallel::Threads& threads, const CouplingSystem& couplings,
              std::span<const Vec3> positions);
  /// Where a row is taken z = P^-1 r, by rows, simd::slice_values a slice; returns the sum of r z over all
  /// rows. O(blocks of L).
  double apply(const parallel::Threads& threads, std::span<const float> r, std::span<float> z);

 private:
  void order();
  void factor();
  void place_edges();
  [[nodiscard]] simd::TurnedRows rows();

  const BlockMatrix* matrix_;
  bool ordered_ = false;
  bool fits_ = false;
  std::vector<Index> order_;                 ///< rows in the order of the factor, body by body
  std::vector<std::uint32_t> body_begin_;    ///< (n_bodies + 1) into order_
  std::vector<double> factors_;              ///< of the elements, when it was factored
  std::vector<double> diagonal_;             ///< the same of the points
  std::vector<std::uint32_t> column_begin_;  ///< simd::FactorColumns
  std::vector<std::uint32_t> block_rows_;
  simd::AlignedVector<float> blocks_;
  simd::AlignedVector<float> inverses_;
  std::vector<std::uint32_t> places_;  ///< simd::TurnedRows
  simd::AlignedVector<float> edges_;
  simd::AlignedVector<float> taken_;
  simd::AlignedVector<float> rotations_;
  simd::AlignedVector<simd::Quad> positions_;  ///< by row
  simd::AlignedVector<simd::Quad> vector_;     ///< in the order of the factor, scratch
  std::vector<double> partial_;
};

}  // namespace palpate::fem
