#pragma once

#include <cstddef>
#include <cstdint>

namespace palpate::simd {

/// Indices of two dense blocks, and of the block to which their product is added.
struct BlockPair {
  std::uint32_t first;
  std::uint32_t second;
  std::uint32_t place;
};

/// Kinds of products. Blocks are stored row by row, without padding; the second block and the result have six
/// columns.
enum class BlockProduct : std::uint8_t {
  three,             ///< 3x3 times 3x6
  six,               ///< 6x6 times 6x6
  three_transposed,  ///< transpose of 3x3, times 3x6
  six_transposed,    ///< transpose of 6x6, times 6x6
  tall_transposed,   ///< transpose of 3x6, times 3x6
};

/// results[place] += first second for each pair, or first^T second. A product is summed over its inner index
/// in ascending order, then added, without fused operations: the same bits as the twin's.
void add_block_products(BlockProduct kind, const double* first, const double* second, const BlockPair* pairs,
                        std::size_t count, double* results);

/// The kernel above in plain C++.
namespace scalar {
void add_block_products(BlockProduct kind, const double* first, const double* second, const BlockPair* pairs,
                        std::size_t count, double* results);
}

}  // namespace palpate::simd
