#include "fem/sparse_cholesky.hpp"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cstddef>

#include <palpate/error.hpp>

namespace palpate::fem {
namespace {

using Pattern = Eigen::SparseMatrix<double, Eigen::ColMajor, Index>;
using Cholesky = Eigen::SimplicialLLT<Pattern, Eigen::Lower, Eigen::NaturalOrdering<Index>>;

/// Inverse of a lower triangle, column by column.
std::array<float, 9> lower_inverse(const Eigen::Matrix3d& l) {
  const Eigen::Matrix3d inverse =
      l.triangularView<Eigen::Lower>().solve(Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
  std::array<float, 9> values{};
  for (int k = 0; k < 9; ++k) values[static_cast<std::size_t>(k)] = static_cast<float>(inverse(k % 3, k / 3));
  return values;
}

}  // namespace

std::vector<Index> minimum_degree_order(std::span<const Index> begin, std::span<const Index> columns) {
  const auto size = static_cast<Index>(begin.size()) - 1;
  const std::vector<double> ones(columns.size(), 1.0);
  const Eigen::Map<const Pattern> pattern(size, size, static_cast<Index>(columns.size()), begin.data(),
                                          columns.data(), ones.data());
  // The ordering asks for ascending rows, which transposing makes; as a whole the pattern is its own
  // transpose.
  const Pattern ascending = pattern.transpose();
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, Index> permutation;
  Eigen::AMDOrdering<Index>()(ascending, permutation);
  return {permutation.indices().data(), permutation.indices().data() + size};
}

std::vector<std::uint32_t> factor_counts(std::span<const Index> begin, std::span<const Index> columns,
                                         std::span<const Index> order) {
  // Row subtrees of the elimination tree: Liu, "The role of elimination trees in sparse factorization", 1990.
  std::vector<Index> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k)
    place[static_cast<std::size_t>(order[k])] = static_cast<Index>(k);
  std::vector<Index> parent(order.size(), -1);
  std::vector<Index> mark(order.size(), -1);
  std::vector<std::uint32_t> counts(order.size(), 0);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const auto row = static_cast<std::size_t>(order[k]);
    mark[k] = static_cast<Index>(k);
    for (Index entry = begin[row]; entry < begin[row + 1]; ++entry) {
      auto i =
          static_cast<std::size_t>(place[static_cast<std::size_t>(columns[static_cast<std::size_t>(entry)])]);
      while (i < k && mark[i] != static_cast<Index>(k)) {
        if (parent[i] < 0) parent[i] = static_cast<Index>(k);
        ++counts[i];
        mark[i] = static_cast<Index>(k);
        i = static_cast<std::size_t>(parent[i]);
      }
    }
  }
  return counts;
}

BlockFactor block_cholesky(Index size, std::span<const BlockEntry> entries) {
  std::vector<Eigen::Triplet<double, Index>> triplets;
  for (const BlockEntry& entry : entries) {
    for (Index k = 0; k < 9; ++k) {
      const Index row = 3 * entry.row + k / 3;
      const Index column = 3 * entry.column + k % 3;
      if (row >= column) triplets.emplace_back(row, column, entry.block(k / 3, k % 3));
    }
  }
  const Index rows_of_matrix = 3 * size;
  Pattern matrix(rows_of_matrix, rows_of_matrix);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  triplets = {};
  const Cholesky cholesky(matrix);
  if (cholesky.info() != Eigen::Success) {
    throw Error("dynamics", "factor of the system at rest", "a pivot that is not positive",
                "positive pivots");
  }
  const Pattern& l = cholesky.matrixL().nestedExpression();
  BlockFactor factor;
  factor.column_begin.push_back(0);
  for (Index j = 0; j < size; ++j) {
    // The three columns of a block column have the same rows below its diagonal block.
    const auto* const begin = l.outerIndexPtr() + 3 * static_cast<std::ptrdiff_t>(j);
    const std::array<const Index*, 3> rows{l.innerIndexPtr() + begin[0], l.innerIndexPtr() + begin[1] - 1,
                                           l.innerIndexPtr() + begin[2] - 2};
    const std::array<const double*, 3> values{l.valuePtr() + begin[0], l.valuePtr() + begin[1] - 1,
                                              l.valuePtr() + begin[2] - 2};
    Eigen::Matrix3d diagonal = Eigen::Matrix3d::Zero();
    for (int column = 0; column < 3; ++column) {
      for (int row = column; row < 3; ++row)
        diagonal(row, column) = values[static_cast<std::size_t>(column)][row];
    }
    const auto inverse = lower_inverse(diagonal);
    factor.inverses.insert(factor.inverses.end(), inverse.begin(), inverse.end());
    const Index count = begin[1] - begin[0];
    for (Index k = 3; k < count; k += 3) {
      factor.rows.push_back(static_cast<std::uint32_t>(rows[0][k] / 3));
      for (std::size_t column = 0; column < 3; ++column) {
        for (Index row = 0; row < 3; ++row)
          factor.blocks.push_back(static_cast<float>(values[column][k + row]));
      }
    }
    factor.column_begin.push_back(static_cast<std::uint32_t>(factor.rows.size()));
  }
  return factor;
}

}  // namespace palpate::fem
