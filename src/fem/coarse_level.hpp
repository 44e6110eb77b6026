#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fem/coarsest_factor.hpp"
#include "fem/coupling.hpp"
#include "fem/transfer.hpp"
#include "parallel/parallel.hpp"
#include "simd/aligned.hpp"
#include "simd/padded_rows.hpp"

namespace palpate::fem {

/// Jacobians of couplings on a level: one 3x6 block (relative velocity per unknown) per coupling and node.
struct CouplingParts {
  struct Part {
    std::uint32_t node = 0;
    Dense<3, 6> motion{};
  };
  std::vector<std::uint32_t> begin;  ///< (n_couplings + 1) into parts
  std::vector<std::uint32_t> count;  ///< (n_couplings) number of used parts from there
  std::vector<Part> parts;

  [[nodiscard]] std::span<const Part> of(std::size_t coupling) const {
    return std::span(parts).subspan(begin[coupling], count[coupling]);
  }
  /// The Jacobian block of a coupling at a node; appended if missing.
  Part& part(std::size_t coupling, std::uint32_t node);
  /// Reserves most[c] blocks for coupling c and marks all as unused.
  void reset(std::size_t couplings, const std::vector<std::uint32_t>& most);
};

/// Blocks in float, in the layout of the kernels.
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

/// A level of a hierarchy below the finest, with six unknowns a node. The matrix of the bodies is constant;
/// each update() makes a new one of the couplings.
class CoarseLevel {
 public:
  explicit CoarseLevel(BlockRows<6, 6> bodies);
  /// \param transfer  from the nodes of the next level
  void connect(const BlockRows<6, 6>& transfer, std::size_t next_count);

  [[nodiscard]] std::size_t size() const { return bodies_.size(); }
  [[nodiscard]] const BlockRows<6, 6>& bodies() const { return bodies_; }
  [[nodiscard]] const BlockRows<6, 6>& couplings() const { return coupled_; }
  [[nodiscard]] CouplingParts& parts() { return parts_; }
  /// Right side and solution of this level (n_nodes).
  [[nodiscard]] std::span<simd::Six> right_side() { return right_side_; }
  [[nodiscard]] std::span<simd::Six> solution() { return solution_; }

  /// Copies the couplings from parts(), and passes them to the next level.
  /// \param next  nullptr: this is the coarsest.
  void update(const parallel::Threads& threads, const CouplingSystem& couplings, CoarseLevel* next);
  /// Solves from zero by two cycles of Gauss-Seidel and the levels below; exactly on the coarsest level.
  void solve(const parallel::Threads& threads, std::span<CoarseLevel> below);

 private:
  /// A coupling that holds a node.
  struct Entry {
    std::uint32_t coupling = 0;
    std::uint32_t part = 0;
  };
  void list_couplings();
  void find_columns(const parallel::Threads& threads);
  void add_blocks(const parallel::Threads& threads, const CouplingSystem& couplings);
  void invert_diagonal(std::size_t node);
  void hand_on(const parallel::Threads& threads, CouplingParts& next);
  template <class Body>
  void for_each_column(std::size_t node, std::vector<std::uint32_t>& place, Body&& body);
  void correct(const parallel::Threads& threads, std::span<CoarseLevel> below,
               std::span<const simd::Six> change);
  [[nodiscard]] simd::SixMatrix matrix() const;

  BlockRows<6, 6> bodies_;
  PaddedBlocks beside_;       ///< of the bodies, without the diagonal
  PaddedBlocks transfer_;     ///< from the next level
  PaddedBlocks restriction_;  ///< to the next level
  CouplingParts parts_;
  std::vector<std::uint32_t> entry_begin_;  ///< (n_nodes + 1)
  std::vector<std::uint32_t> next_entry_;   ///< scratch
  std::vector<Entry> entries_;
  BlockRows<6, 6> coupled_;  ///< of the couplings, with the diagonal
  PaddedBlocks coupled_beside_;
  std::vector<std::vector<std::uint32_t>> places_;  ///< of each chunk, by node: scratch
  std::vector<std::uint8_t> changed_;               ///< 1: couplings add to the diagonal
  simd::AlignedVector<float> inverses_;
  simd::AlignedVector<simd::Six> right_side_;
  simd::AlignedVector<simd::Six> solution_;
  simd::AlignedVector<simd::Six> residual_;
  simd::AlignedVector<simd::Six> change_;  ///< scratch
  std::vector<std::uint32_t> most_parts_;  ///< scratch
  CoarsestFactor factor_;
};

}  // namespace palpate::fem
