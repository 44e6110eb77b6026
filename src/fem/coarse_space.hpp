#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "fem/block_matrix.hpp"
#include "fem/coupling.hpp"
#include "fem/envelope_cholesky.hpp"
#include "parallel/parallel.hpp"

namespace palpate::fem {

/// The second level of a preconditioner: the motions of aggregates of points as rigid bodies, six each,
/// solved exactly. What block Jacobi finds slowly, the motion of whole parts and the forces that contacts
/// pass on from body to body, is found at once.
///
/// With Z the rigid motions of the aggregates at the positions of the step, correct() adds Z (Z^T A Z)^-1 Z^T
/// r to a preconditioned residual (two-level additive Schwarz: Toselli & Widlund, "Domain Decomposition
/// Methods", 2005, chapter 3). A is that of LinearSystem, couplings included. Aggregates are made once, from
/// the positions at rest; which meet is found anew in each update(), as contacts change. The same bits for
/// every thread count.
class CoarseSpace {
 public:
  /// Aggregates of free points, each of one body, by halving boxes of points along their longest side until
  /// they have few enough points: so many that all bodies together have some hundred aggregates at most,
  /// unless there are more bodies. O(n_points log n_points).
  CoarseSpace(const Bodies& bodies, std::span<const std::uint8_t> free);

  [[nodiscard]] Index size() const { return static_cast<Index>(members_.begin.size()) - 1; }  ///< aggregates
  /// Aggregate of each point (n_points), -1 where it is not free.
  [[nodiscard]] std::span<const Index> aggregate_of_point() const { return aggregate_of_point_; }

  /// Z^T A Z and its factor, at these positions (n_points x 3).
  void update(const parallel::Threads& threads, const BlockMatrix& matrix, const CouplingSystem& couplings,
              std::span<const Vec3> positions);
  /// z += Z (Z^T A Z)^-1 Z^T r; returns the sum of r times what was added. Vectors are by rows of the matrix
  /// of the last update(), simd::slice_values a slice. O(n_points).
  double correct(const parallel::Threads& threads, std::span<const float> r, std::span<float> z);

 private:
  /// Part of a coupling in an aggregate: the rows of J Z there, three by six.
  struct Share {
    Index aggregate = -1;
    std::array<double, 18> motion{};
  };
  struct CouplingShares {
    std::array<Share, 5> shares;
    std::size_t count = 0;
  };
  void find_neighbors(const BlockMatrix& matrix);
  void place_offsets(const parallel::Threads& threads, std::span<const Vec3> positions);
  void share_couplings(const parallel::Threads& threads, const CouplingSystem& couplings);
  void join_neighbors();
  void order_aggregates();
  void add_blocks(const BlockMatrix& matrix, Index aggregate);
  void add_couplings(const CouplingSystem& couplings);

  std::vector<Index> aggregate_of_point_;
  Rows members_;                        ///< points of each aggregate, ascending
  std::vector<std::uint64_t> pattern_;  ///< pairs (a, b) of aggregates that share a block, both ways
  std::vector<std::uint64_t> pairs_;    ///< those and the ones that couplings join
  std::vector<Index> neighbor_begin_;   ///< (n_aggregates + 1) into pairs_
  std::vector<Index> order_;            ///< aggregates in the order of rows
  std::vector<Index> row_;              ///< of each aggregate
  std::vector<Index> first_;            ///< of each row
  std::vector<Index> degree_order_;     ///< scratch
  std::vector<std::size_t> place_;      ///< (n_points) in vectors by rows
  std::vector<simd::Padded3> offsets_;  ///< (n_points) from the middle of the aggregate
  std::vector<CouplingShares> shares_;  ///< of each coupling
  EnvelopeCholesky factor_;
  std::vector<Vector6> coarse_;   ///< by row
  std::vector<double> products_;  ///< by row
};

}  // namespace palpate::fem
