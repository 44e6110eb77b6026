#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "fem/elements.hpp"
#include "fem/matrix.hpp"
#include "parallel/parallel.hpp"

namespace palpate::fem {

/// A square matrix of 3x3 blocks in compressed rows, one row a point: the pattern of the element stiffness,
/// which is symmetric. Points that no element uses have an empty row.
///
/// Assembly gathers: each row adds up its own elements, ascending, so that no two threads write one block and
/// the bits do not depend on the thread count.
class BlockMatrix {
 public:
  /// Pattern: each point of an element, with itself and with the other corners of its elements. O(n_elements
  /// log).
  BlockMatrix(const Elements& elements, Index point_count);

  [[nodiscard]] Index size() const { return static_cast<Index>(row_begin_.size()) - 1; }  ///< n_points

  /// diagonal[i] I on the diagonal plus the sum over elements e of factors[e] K'_e as of Elements::update().
  /// \param diagonal  (n_points); entries of points that no element uses are ignored
  /// \param factors   (n_elements)
  void assemble(const parallel::Threads& threads, const Elements& elements, std::span<const double> diagonal,
                std::span<const double> factors);

  /// Points of a row's blocks, ascending, and the blocks.
  [[nodiscard]] std::span<const Index> columns(Index row) const;
  [[nodiscard]] std::span<const Matrix3> blocks(Index row) const;
  /// The block on the diagonal; zero where the row is empty.
  [[nodiscard]] Matrix3 diagonal_block(Index row) const;
  /// Row `row` of the product with x (n_points x 3), summed in the order of the columns.
  [[nodiscard]] Vec3 row_product(Index row, std::span<const Vec3> x) const;

  /// Elements at a point, ascending.
  [[nodiscard]] const Rows& elements_of_point() const { return elements_of_point_; }
  /// Corner of the point in each element of elements_of_point(), entry by entry.
  [[nodiscard]] std::span<const std::uint8_t> corner_of_point() const { return corner_of_point_; }

 private:
  void gather_incidences(const Elements& elements, Index point_count);
  void build_pattern(const Elements& elements);
  void assemble_row(const Elements& elements, Index row, double diagonal, std::span<const double> factors);

  Rows elements_of_point_;
  std::vector<std::uint8_t> corner_of_point_;
  std::vector<std::array<Index, 4>> places_;  ///< per incidence: place in the row of the block of each corner
  std::vector<Index> row_begin_;
  std::vector<Index> columns_;
  std::vector<Matrix3> blocks_;
  std::vector<Index> diagonal_place_;  ///< (n_points), -1 where the row is empty
};

}  // namespace palpate::fem
