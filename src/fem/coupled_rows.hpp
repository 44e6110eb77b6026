#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "simd/aligned.hpp"
#include "simd/coupling_blocks.hpp"

namespace palpate::fem {

/// The matrix of the couplings on a level. Columns of a row ascend, and the pattern is symmetric.
struct CoupledRows {
  std::vector<std::uint32_t> begin;  ///< (n_nodes + 1)
  std::vector<std::uint32_t> columns;
  simd::AlignedVector<double> blocks;  ///< simd::six_rows for each; below the diagonal not set
  /// The block of a row and a column of its pattern.
  [[nodiscard]] const double* block(std::size_t row, std::uint32_t column) const;
};

}  // namespace palpate::fem
