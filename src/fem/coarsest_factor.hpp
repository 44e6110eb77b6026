#pragma once

#include <span>
#include <vector>

#include "fem/coupled_rows.hpp"
#include "fem/envelope_cholesky.hpp"
#include "fem/transfer.hpp"
#include "simd/padded_rows.hpp"

namespace palpate::fem {

/// The coarsest level of a hierarchy, solved exactly: all bodies together, with the couplings between them.
/// Each update() orders the rows again, since contacts change.
class CoarsestFactor {
 public:
  /// Factors the sum of two matrices. O(sum of squared row lengths).
  void update(const BlockRows<6, 6>& bodies, const CoupledRows& couplings);
  /// x = A^-1 b. O(blocks of the factor).
  void solve(std::span<const simd::Six> b, std::span<simd::Six> x);

 private:
  void order(const NodeGraph& bodies, const NodeGraph& couplings);

  std::vector<Index> order_;         ///< node of each row
  std::vector<Index> row_;           ///< row of each node
  std::vector<Index> first_;         ///< first column of each row's envelope
  std::vector<Index> degree_order_;  ///< scratch
  EnvelopeCholesky factor_;
  simd::AlignedVector<Vector6> vector_;  ///< by row
};

}  // namespace palpate::fem
