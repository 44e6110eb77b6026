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
/// The restriction is exact: rows of points that are not free give zero, and vectors are zero there, so their
/// columns have no part either. Refers to B and W, which must outlive it.
class LinearSystem {
 public:
  /// \param free  (n_points) 1 where a point may move; its row of B must not be empty
  LinearSystem(const BlockMatrix& blocks, CouplingSystem& couplings, std::vector<std::uint8_t> free);

  [[nodiscard]] std::size_t size() const { return free_.size(); }  ///< n_points
  [[nodiscard]] std::span<const std::uint8_t> free() const { return free_; }

  /// Inverts the diagonal blocks of A as they are now. O(n_points).
  void update_preconditioner(const parallel::Threads& threads);

  /// y = A x at free points, 0 elsewhere; x is (n_points x 3). O(n_blocks).
  void multiply(const parallel::Threads& threads, std::span<const Vec3> x, std::span<Vec3> y);
  /// Point i of the inverted diagonal of A times r; 0 where the point is not free.
  [[nodiscard]] Vec3 precondition(std::size_t i, const Vec3& r) const { return inverse_diagonal_[i] * r; }

 private:
  const BlockMatrix* blocks_;
  CouplingSystem* couplings_;
  std::vector<std::uint8_t> free_;
  std::vector<SymmetricMatrix3> inverse_diagonal_;
};

}  // namespace palpate::fem
