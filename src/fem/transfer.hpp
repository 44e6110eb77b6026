#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/types.hpp>

#include "fem/small_matrix.hpp"
#include "parallel/parallel.hpp"

/// Parts of smoothed aggregation (Vanek, Mandel & Brezina, "Algebraic multigrid by smoothed aggregation",
/// Computing 56 (1996)).
namespace palpate::fem {

/// A sparse matrix of dense blocks by rows; the columns of a row ascend.
template <std::size_t N, std::size_t M>
struct BlockRows {
  std::vector<std::uint32_t> begin{0};  ///< (n_rows + 1)
  std::vector<std::uint32_t> columns;
  std::vector<Dense<N, M>> blocks;
  [[nodiscard]] std::size_t size() const { return begin.size() - 1; }
};

/// The blocks of each column, rows in ascending order.
struct ColumnLists {
  std::vector<std::uint32_t> begin;   ///< (n_columns + 1)
  std::vector<std::uint32_t> blocks;  ///< indices of blocks
  std::vector<std::uint32_t> rows;    ///< their rows
};

/// `count` columns. O(blocks).
template <std::size_t N, std::size_t M>
ColumnLists columns_of(const BlockRows<N, M>& rows, std::size_t count) {
  ColumnLists lists;
  lists.begin.assign(count + 1, 0);
  for (const std::uint32_t column : rows.columns) ++lists.begin[column + 1];
  for (std::size_t i = 0; i < count; ++i) lists.begin[i + 1] += lists.begin[i];
  std::vector<std::uint32_t> next(lists.begin.begin(), lists.begin.end() - 1);
  lists.blocks.resize(rows.columns.size());
  lists.rows.resize(rows.columns.size());
  for (std::uint32_t row = 0; row < rows.size(); ++row) {
    for (std::uint32_t k = rows.begin[row]; k < rows.begin[row + 1]; ++k) {
      const std::uint32_t place = next[rows.columns[k]]++;
      lists.blocks[place] = k;
      lists.rows[place] = row;
    }
  }
  return lists;
}

/// The transpose, rows in ascending order; `count` columns. O(blocks).
template <std::size_t N, std::size_t M>
BlockRows<M, N> transposed(const BlockRows<N, M>& rows, std::size_t count);

/// A point, or an aggregate of nodes. Its unknowns are its velocity and, for an aggregate, its angular
/// velocity times `radius`, so that both have the same scale. A radius of 0: the aggregate does not rotate,
/// since its points lie on a line.
struct Node {
  Vec3 middle;
  double radius = 0.0;
  Index body = 0;
};

/// The unknowns of node `part` if the node `whole` moves as a rigid body, as a matrix on the unknowns of
/// `whole`. N = 3: `part` is a point.
template <std::size_t N>
Dense<N, 6> rigid_motion(const Node& part, const Node& whole);

/// Neighbours of nodes, themselves included, ascending.
struct NodeGraph {
  std::span<const std::uint32_t> begin;  ///< (n_nodes + 1)
  std::span<const std::uint32_t> columns;
};

template <std::size_t N, std::size_t M>
NodeGraph graph_of(const BlockRows<N, M>& rows) {
  return {rows.begin, rows.columns};
}

/// Aggregate of each node. A node and its neighbours form an aggregate if none of them is in one yet. Nodes
/// are tried breadth first, so that aggregates lie close to each other. Then the remaining nodes join an
/// aggregate of their neighbours. All connections have equal weight. O(pattern).
std::vector<Index> aggregate(const NodeGraph& graph);

/// The nodes that the aggregates form.
std::vector<Node> nodes_of(std::span<const Index> aggregate_of_node, std::span<const Node> nodes);

/// The transfer from aggregates to nodes that reproduces all rigid motions of a body. Its energy tr(P^T A P)
/// is minimised for its pattern by two iterations of conjugate gradients (Mandel, Brezina & Vanek, "Energy
/// optimization of algebraic multigrid bases", Computing 62 (1999); Olson, Schroder & Tuminaro, "A general
/// interpolation strategy for algebraic multigrid using energy minimization", SIAM J. Sci. Comput. 33
/// (2011)). A node interpolates from the aggregates of its neighbours in the graph, which may have fewer
/// connections than the matrix.
template <std::size_t N>
BlockRows<N, 6> least_energy_transfer(const parallel::Threads& threads, const BlockRows<N, N>& a,
                                      const NodeGraph& graph, std::span<const Node> nodes,
                                      std::span<const Index> aggregate_of_node,
                                      std::span<const Node> aggregates);

/// P^T A P.
template <std::size_t N>
BlockRows<6, 6> galerkin(const parallel::Threads& threads, const BlockRows<N, N>& a,
                         const BlockRows<N, 6>& transfer, std::size_t aggregate_count);

}  // namespace palpate::fem
