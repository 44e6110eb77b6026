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
/// Aggregates, transfers and the coarse matrices of bodies are made of each body by itself, from its shape at
/// rest, and anew where the time step changes or, at the positions that there are then, where many iterations
/// have been made by solves that took too many. From there on transfers turn with the points, P_i = R_i
/// P_i(reference), so that coarse unknowns stay in the frame of the reference: exact where a body turns as a
/// whole. Couplings are taken to all levels in each update(): P^T J_c^T W_c J_c P. The coarsest level,
/// all bodies together, is factored. Symmetric and positive definite; the same bits for every thread count.
class Multigrid {
 public:
  /// \param matrix  must outlive it. O(1).
  explicit Multigrid(const BlockMatrix& matrix) : matrix_(&matrix) {}

  /// Makes the hierarchy where there is none of this system yet; then rotations at these positions
  /// (n_points x 3), and the couplings' part of all levels: in a step anew where there are others or the last
  /// solve was slow. The system is as update_preconditioner() left it.
  void update(const parallel::Threads& threads, const LinearSystem& system, std::span<const Vec3> positions);
  /// A step begins: its first update() renews the couplings, so that nothing depends on steps before.
  void begin_step() { outdated_ = true; }
  /// z = P^-1 r, by rows, simd::slice_values a slice; returns the sum of r z.
  double apply(const parallel::Threads& threads, LinearSystem& system, std::span<const float> r,
               std::span<float> z);

  /// Counts a solve with it, of so many iterations.
  void count(int iterations);
  /// What later solves depend on, as part of a state: the positions that the hierarchy is made at (n_points),
  /// empty for rest, and the iterations that count against it.
  [[nodiscard]] const std::vector<Vec3>& reference() const { return reference_; }
  [[nodiscard]] int stale_iterations() const { return stale_iterations_; }
  void set_reference(std::span<const Vec3> reference, int stale_iterations);

  /// Levels below the finest, and blocks of all levels over those of the finest, by their numbers.
  [[nodiscard]] std::span<const CoarseLevel> levels() const { return levels_; }
  [[nodiscard]] double operator_complexity() const;

 private:
  [[nodiscard]] bool is_current() const;
  void build(const parallel::Threads& threads);
  [[nodiscard]] std::span<const Vec3> reference_positions() const;
  [[nodiscard]] std::vector<Matrix3> element_rotations() const;
  [[nodiscard]] std::vector<Matrix3> domain_rotations() const;
  [[nodiscard]] BlockRows<0, 0> element_graph() const;
  [[nodiscard]] BlockRows<3, 3> matrix_at_reference() const;
  [[nodiscard]] std::vector<Node> points_as_nodes() const;
  void connect_rows(const BlockRows<3, 6>& transfer, std::size_t count);
  void place_edges();
  void rotate(const parallel::Threads& threads, std::span<const Vec3> positions);
  void set_couplings(const parallel::Threads& threads, const CouplingSystem& couplings);

  const BlockMatrix* matrix_;
  std::vector<Vec3> reference_;
  int stale_iterations_ = 0;
  std::vector<double> factors_;      ///< of the elements, when it was made
  std::vector<double> diagonal_;     ///< the same of the points
  std::vector<std::uint32_t> rows_;  ///< that have a point: the nodes of the finest level
  std::vector<std::uint32_t> node_of_row_;
  PaddedBlocks transfer_;     ///< by row
  PaddedBlocks restriction_;  ///< columns are rows
  std::vector<CoarseLevel> levels_;
  std::vector<GaussSeidel> smoother_;  ///< one, once it is made
  simd::AlignedVector<float> edges_;   ///< simd::RotationRows
  simd::AlignedVector<float> rotations_;
  std::vector<Vec3> rotated_at_;  ///< (n_points) positions that rotations_ are of, or empty
  bool outdated_ = true;          ///< coarse levels are of other positions or couplings than they should be
  std::size_t taken_ = 0;         ///< couplings that they have taken
  simd::AlignedVector<simd::Quad> positions_;  ///< by row
  simd::AlignedVector<simd::Quad> vector_;     ///< by row
  simd::AlignedVector<simd::Quad> rotated_;    ///< by row
  std::vector<std::uint32_t> most_parts_;      ///< scratch
  std::vector<double> partial_;
};

}  // namespace palpate::fem
