#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/types.hpp>

#include "fem/coarse_level.hpp"
#include "fem/gauss_seidel.hpp"
#include "fem/linear_system.hpp"
#include "fem/matrix.hpp"
#include "parallel/parallel.hpp"
#include "simd/aligned.hpp"
#include "simd/padded_rows.hpp"

namespace palpate::fem {

/// A preconditioner whose iterations hardly grow with size, stiffness or the shape of elements: one cycle
/// of smoothed aggregation with the rigid motions of aggregates (Vanek, Mandel & Brezina, Computing 56
/// (1996)), transfers of least energy (transfer.hpp) and Gauss-Seidel before and after (gauss_seidel.hpp).
/// Coarse levels are solved by two cycles each, which costs a fifth more and saves a third of the iterations.
///
/// Aggregates, transfers and the coarse matrices are made for each body separately, from its shape at rest.
/// They are made again if the time step changes, and after many iterations in slow solves, then at the
/// current positions (the reference). Transfers rotate with the points, P_i = R_i P_i(reference), so that
/// coarse unknowns stay in the frame of the reference: exact if a body rotates as a whole. update() adds the
/// couplings to all levels: P^T J_c^T W_c J_c P. The coarsest level, all bodies together, is factored.
/// Symmetric and positive definite; the same bits for every thread count.
class Multigrid {
 public:
  /// \param matrix  must outlive it. O(1).
  explicit Multigrid(const BlockMatrix& matrix) : matrix_(&matrix) {}

  /// Makes the hierarchy if there is none for this system; then the rotations at these positions (n_points x
  /// 3). If the number of couplings has changed or the last solve was slow, also makes the couplings' part of
  /// all levels again. Call after update_preconditioner() of the system.
  void update(const parallel::Threads& threads, const LinearSystem& system, std::span<const Vec3> positions);
  /// Begins a step: its first update() renews the couplings, so that nothing depends on earlier steps.
  void begin_step() { outdated_ = true; }
  /// z = P^-1 r, by rows, simd::slice_values a slice; returns the sum of r z.
  double apply(const parallel::Threads& threads, LinearSystem& system, std::span<const float> r,
               std::span<float> z);

  /// Records that a solve took this number of iterations.
  void count(int iterations);
  /// State that later solves depend on: the positions for which the hierarchy was made (n_points; empty: at
  /// rest), and the number of iterations of slow solves with it.
  [[nodiscard]] const std::vector<Vec3>& reference() const { return reference_; }
  [[nodiscard]] int stale_iterations() const { return stale_iterations_; }
  void set_reference(std::span<const Vec3> reference, int stale_iterations);

  /// Number of levels below the finest; number of blocks of all levels divided by that of the finest.
  [[nodiscard]] std::span<const CoarseLevel> levels() const { return levels_; }
  [[nodiscard]] double operator_complexity() const;

 private:
  [[nodiscard]] bool is_current() const;
  void build(const parallel::Threads& threads);
  [[nodiscard]] std::span<const Vec3> reference_positions() const;
  [[nodiscard]] std::vector<Matrix3> element_rotations() const;
  [[nodiscard]] std::vector<Matrix3> domain_rotations() const;
  [[nodiscard]] BlockRows<0, 0> element_graph(const BlockRows<3, 3>& matrix) const;
  /// From rest to the reference.
  struct Rotations {
    std::vector<Matrix3> elements;
    std::vector<Matrix3> domains;
  };
  [[nodiscard]] BlockRows<3, 3> matrix_at_reference(const parallel::Threads& threads) const;
  void add_stiffness(std::size_t node, const Rotations& rotations, BlockRows<3, 3>& a) const;
  [[nodiscard]] std::vector<Node> points_as_nodes() const;
  void connect_rows(const BlockRows<3, 6>& transfer, std::size_t count);
  void place_edges();
  void rotate(const parallel::Threads& threads, std::span<const Vec3> positions);
  void set_couplings(const parallel::Threads& threads, const CouplingSystem& couplings);

  const BlockMatrix* matrix_;
  std::vector<Vec3> reference_;
  int stale_iterations_ = 0;
  std::vector<double> factors_;      ///< of the elements when the hierarchy was made
  std::vector<double> diagonal_;     ///< of the points when the hierarchy was made
  std::vector<std::uint32_t> rows_;  ///< rows with a point: the nodes of the finest level
  std::vector<std::uint32_t> node_of_row_;
  PaddedBlocks transfer_;     ///< by row
  PaddedBlocks restriction_;  ///< columns are rows of the matrix
  std::vector<CoarseLevel> levels_;
  std::vector<GaussSeidel> smoother_;  ///< empty before it is made, then one item
  simd::AlignedVector<float> edges_;   ///< simd::RotationRows
  simd::AlignedVector<float> rotations_;
  std::vector<Vec3> rotated_at_;  ///< (n_points) positions for which rotations_ were computed, or empty
  bool outdated_ = true;          ///< coarse levels are not up to date with positions and couplings
  std::size_t taken_ = 0;         ///< number of couplings in the coarse levels
  simd::AlignedVector<simd::Quad> positions_;  ///< by row
  simd::AlignedVector<simd::Quad> vector_;     ///< by row
  simd::AlignedVector<simd::Quad> rotated_;    ///< by row
  std::vector<WeightRows> weights_;            ///< of couplings: scratch
  std::vector<std::uint32_t> block_limits_;    ///< scratch
  std::vector<double> partial_;
};

}  // namespace palpate::fem
