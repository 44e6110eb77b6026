#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fem/coarsest_factor.hpp"
#include "fem/coupled_rows.hpp"
#include "fem/coupling.hpp"
#include "fem/transfer.hpp"
#include "parallel/parallel.hpp"
#include "simd/aligned.hpp"
#include "simd/coupling_blocks.hpp"
#include "simd/padded_rows.hpp"

namespace palpate::fem {

/// Rows V with V^T V = W, of the symmetric positive semi-definite weight W of a coupling. Contacts without
/// friction have one row.
struct WeightRows {
  std::uint8_t count = 0;  ///< 0: W is zero; 1; or 3, of which the last may be zero
  Dense<3, 3> rows{};
};
/// By Cholesky's method with pivots. Up to 1e-9 of the trace of W may be lost.
[[nodiscard]] WeightRows weight_rows(const SymmetricMatrix3& weight);

/// Weighted Jacobians of the couplings on a level: for each coupling and node a block of one or three rows of
/// six. It maps the node's unknowns to V u, with the relative velocity u and V of WeightRows. So the
/// couplings' matrix is the sum of J^T J.
struct CouplingJacobians {
  std::vector<std::uint32_t> begin;     ///< (n_couplings + 1) first block of each coupling
  std::vector<std::uint32_t> count;     ///< (n_couplings) number of blocks in use
  std::vector<std::uint8_t> rows;       ///< (n_couplings) of a block: 1 or 3; 0: no block
  std::vector<std::uint32_t> nodes;     ///< of each block
  simd::AlignedVector<double> motions;  ///< simd::three_rows for each block

  /// Nodes of a coupling.
  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t coupling) const {
    return std::span(nodes).subspan(begin[coupling], count[coupling]);
  }
  /// Index of the block of a coupling at a node; a block of zeros is appended if there is none.
  std::uint32_t block(std::size_t coupling, std::uint32_t node);
  /// Reserves limits[c] blocks for coupling c and marks all as unused.
  void reset(std::size_t couplings, const std::vector<std::uint32_t>& limits);
};

/// Matrix blocks in float, in the layout of the kernels.
struct PaddedBlocks {
  std::vector<std::uint32_t> begin{0};
  std::vector<std::uint32_t> columns;
  simd::AlignedVector<float> blocks;
  [[nodiscard]] simd::PaddedRows rows() const { return {begin.data(), columns.data(), blocks.data()}; }
};
/// Stores a block of N x M with padded columns.
template <std::size_t N, std::size_t M>
void store_padded(const Dense<N, M>& block, float* place);
template <std::size_t N, std::size_t M>
PaddedBlocks padded(const BlockRows<N, M>& rows);

/// A level of the multigrid hierarchy below the finest, with six unknowns for each node. The matrix of the
/// bodies is constant. Each update() makes the matrix of the couplings again.
class CoarseLevel {
 public:
  explicit CoarseLevel(BlockRows<6, 6> bodies);
  /// \param transfer  from the nodes of the next level to this one
  void connect(const BlockRows<6, 6>& transfer, std::size_t next_count);

  [[nodiscard]] std::size_t size() const { return bodies_.size(); }
  [[nodiscard]] const BlockRows<6, 6>& bodies() const { return bodies_; }
  [[nodiscard]] CouplingJacobians& jacobians() { return jacobians_; }
  /// Right side and solution of this level (n_nodes).
  [[nodiscard]] std::span<simd::Six> right_side() { return right_side_; }
  [[nodiscard]] std::span<simd::Six> solution() { return solution_; }

  /// Makes the couplings' matrix from jacobians(), and passes the Jacobians to the next level.
  /// \param next  nullptr: this is the coarsest level
  void update(const parallel::Threads& threads, CoarseLevel* next);
  /// Solves from zero by two cycles of Gauss-Seidel and the levels below; on the coarsest level exactly.
  void solve(const parallel::Threads& threads, std::span<CoarseLevel> below);

 private:
  /// A coupling that acts on a node.
  struct Entry {
    std::uint32_t coupling = 0;
    std::uint32_t block = 0;
  };
  void list_couplings();
  [[nodiscard]] std::span<const Entry> entries(std::size_t node) const;
  void find_columns(const parallel::Threads& threads);
  void add_blocks(const parallel::Threads& threads);
  void store_blocks(const parallel::Threads& threads);
  void invert_diagonal(std::size_t node);
  void coarsen_couplings(const parallel::Threads& threads, CouplingJacobians& next);
  void correct(const parallel::Threads& threads, std::span<CoarseLevel> below,
               std::span<const simd::Six> change);
  [[nodiscard]] simd::SixMatrix matrix() const;

  BlockRows<6, 6> bodies_;
  PaddedBlocks off_diagonal_;                  ///< blocks of the bodies' matrix off the diagonal
  PaddedBlocks transfer_;                      ///< interpolation from the next level
  PaddedBlocks restriction_;                   ///< restriction to the next level
  std::vector<std::uint32_t> restriction_of_;  ///< for each block of transfer_, its transpose in restriction_
  CouplingJacobians jacobians_;
  std::vector<std::uint32_t> entry_begin_;  ///< (n_nodes + 1) into entries_
  std::vector<std::uint32_t> next_entry_;   ///< scratch
  std::vector<Entry> entries_;
  CoupledRows coupled_;
  PaddedBlocks coupled_off_diagonal_;
  /// Scratch of a chunk.
  struct Chunk {
    std::vector<std::uint32_t> places;  ///< by node
    std::vector<std::uint32_t> columns;
    std::vector<simd::BlockTerm> terms;
  };
  std::vector<Chunk> chunks_;
  std::vector<Chunk> coupling_chunks_;
  std::vector<std::uint8_t> changed_;  ///< 1: couplings add to the diagonal
  simd::AlignedVector<float> inverses_;
  simd::AlignedVector<simd::Six> right_side_;
  simd::AlignedVector<simd::Six> solution_;
  simd::AlignedVector<simd::Six> residual_;
  simd::AlignedVector<simd::Six> change_;    ///< scratch
  std::vector<std::uint32_t> block_limits_;  ///< scratch
  CoarsestFactor factor_;
};

}  // namespace palpate::fem
