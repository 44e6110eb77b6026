#pragma once

#include <span>
#include <vector>

#include "fem/small_matrix.hpp"
#include "simd/block_products.hpp"

namespace palpate::fem {

/// results[place] += the product of blocks, for each pair (simd/block_products.hpp).
template <std::size_t A, std::size_t B, std::size_t C>
void add_products(simd::BlockProduct kind, const std::vector<std::array<double, A>>& first,
                  const std::vector<std::array<double, B>>& second, std::span<const simd::BlockPair> pairs,
                  std::span<std::array<double, C>> results) {
  if (pairs.empty()) return;
  simd::add_block_products(kind, first.data()->data(), second.data()->data(), pairs.data(), pairs.size(),
                           results.data()->data());
}

}  // namespace palpate::fem
