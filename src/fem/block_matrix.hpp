#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "fem/elements.hpp"
#include "fem/matrix.hpp"
#include "parallel/parallel.hpp"
#include "simd/aligned.hpp"
#include "simd/sliced_rows.hpp"

namespace palpate::fem {

/// The rows of free points of a square matrix of 3x3 blocks, one row per point, in float, with the symmetric
/// pattern of the element stiffness. LinearSystem::multiply_exactly() has exact products in double.
///
/// Rows are ordered by colour, and in a colour along a Z-curve through the rest positions of each body, so
/// that neighbours in space are near in memory. Within windows they are ordered by the number of their
/// blocks, so that slices of 16 rows (simd/sliced_rows.hpp) need little padding. No two points of an element
/// have the same colour, and a slice has rows of one colour: a smoother can update them at once. Padding rows
/// of a slice have no point. Assembly gathers: each block adds up its own terms, elements ascending, so that
/// no two threads write one block and the bits do not depend on the thread count. Rows of bodies with tangent
/// blocks (Elements) come last, in separate slices. They add up the blocks of their elements and smoothing
/// domains; a row has blocks with all points of its domains.
class BlockMatrix {
 public:
  /// Pattern: each free point of an element, with itself and with the other points of its elements and
  /// smoothing domains. Throws Error for 2^28 elements or more, or 2^31 values of tangent blocks.
  /// O(n_elements log).
  /// \param elements  must outlive it
  /// \param free      (n_points) 1: has a row
  BlockMatrix(const Elements& elements, std::span<const std::uint8_t> free);

  [[nodiscard]] Index size() const { return static_cast<Index>(diagonal_.size()); }  ///< n_points

  /// diagonal[i] I on the diagonal plus the sum over elements of K'_e times its factor, as of
  /// Elements::update().
  /// \param diagonal  (n_points), > 0; of points without a row ignored
  void assemble(const parallel::Threads& threads, std::span<const double> diagonal);

  [[nodiscard]] const Elements& elements() const { return *elements_; }
  /// Points of the blocks in a point's row, ascending; empty where it has no row.
  [[nodiscard]] std::span<const std::uint32_t> columns(Index point) const;
  /// Block number `place` of a point's row; its column is columns(point)[place].
  [[nodiscard]] Matrix3 block(Index point, std::size_t place) const;
  /// The diagonal of the last assemble() (n_points).
  [[nodiscard]] std::span<const double> diagonal() const { return diagonal_; }

  /// Number of rows, with the padding of the last slice; at least one padding row exists, the row of zeros.
  [[nodiscard]] std::size_t row_count() const { return simd::slice_rows * slice_count(); }
  [[nodiscard]] std::size_t slice_count() const { return slot_begin_.size() - 1; }
  [[nodiscard]] std::span<const Index> row_of_point() const { return row_of_point_; }  ///< -1: no row
  [[nodiscard]] std::span<const Index> point_of_row() const { return point_of_row_; }  ///< -1: padding
  /// Slices of each colour, ascending. The last slice has no colour: its rows are zero.
  [[nodiscard]] std::span<const std::vector<std::uint32_t>> slices_of_color() const {
    return slices_of_color_;
  }
  [[nodiscard]] std::vector<Index> body_of_point() const;  ///< (n_points), 0 without an element
  /// The data for products.
  [[nodiscard]] simd::SlicedRows rows() const;
  /// The blocks on the diagonal, simd::slice_symmetric a slice, and the diagonal in float, 16 a slice.
  [[nodiscard]] std::span<const float> diagonal_blocks() const { return diagonal_blocks_; }
  [[nodiscard]] std::span<const float> masses() const { return masses_; }
  [[nodiscard]] std::size_t value_bytes() const { return sizeof(Slot) * slots_.size(); }

  /// Elements at a point, ascending.
  [[nodiscard]] const Rows& elements_of_point() const { return elements_of_point_; }

 private:
  struct alignas(64) Slot {
    std::array<float, simd::slot_values> values{};
  };
  void gather_corners();
  void list_columns(std::span<const std::uint8_t> free);
  std::vector<int> color_points(std::span<const Index> points);
  void order_rows(std::span<const std::uint8_t> free);
  void append_rows(std::span<const Index> points, std::span<const int> color);
  [[nodiscard]] bool is_earlier(std::uint32_t place, std::uint32_t color_begin) const;
  void pad_slice();
  [[nodiscard]] std::uint32_t tangent_term(Index element, int i, int j) const;
  [[nodiscard]] std::uint32_t empty_tangent_term() const;
  void add_tension(std::size_t row);
  void assemble_tangent(std::size_t begin, std::size_t end);
  void add_domains(std::size_t row);
  void place_domains();
  [[nodiscard]] bool has_tangent_blocks(Index point) const;
  void build_slice(std::size_t slice);
  [[nodiscard]] bool has_mixed_bodies() const;

  const Elements* elements_;
  Rows elements_of_point_;
  std::vector<std::uint32_t> corners_of_point_;  ///< as elements_of_point_
  std::vector<std::uint32_t> column_begin_;      ///< (n_points + 1)
  std::vector<std::uint32_t> columns_;           ///< points
  std::vector<std::uint32_t> slot_of_column_;    ///< as columns_; no_slot on the diagonal
  std::vector<Index> row_of_point_;
  std::vector<Index> point_of_row_;
  std::vector<std::vector<std::uint32_t>> slices_of_color_;
  std::size_t first_tangent_slice_ = 0;                ///< first slice of bodies with tangent blocks
  std::vector<std::uint32_t> slot_begin_;              ///< (n_slices + 1)
  std::vector<simd::SliceHalves> halves_;              ///< (n_slices)
  simd::AlignedVector<std::uint32_t> column_of_lane_;  ///< 16 a slot: rows
  std::vector<std::uint32_t> term_begin_;              ///< (n_slots + 1)
  simd::AlignedVector<std::uint32_t> terms_;           ///< of SlicedAssembly, or of TangentAssembly
  /// For each entry of the smoothing domains and each other point of its domain, ascending: the slot of their
  /// block within the slice.
  std::vector<std::size_t> domain_slot_begin_;  ///< (n_entries + 1)
  std::vector<std::uint16_t> domain_slots_;
  bool mixed_ = false;  ///< lambda / mu differs within a body
  std::vector<double> diagonal_;
  simd::AlignedVector<float> masses_;
  simd::AlignedVector<float> diagonal_blocks_;
  simd::AlignedVector<Slot> slots_;
};

}  // namespace palpate::fem
