#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "fem/elements.hpp"
#include "fem/matrix.hpp"
#include "parallel/parallel.hpp"
#include "simd/block_rows.hpp"

namespace palpate::fem {

/// The rows of free points of a square matrix of 3x3 blocks, one row a point: the pattern of the element
/// stiffness, which is symmetric. Points that are not free, or that no element uses, have an empty row.
///
/// Blocks lie row by row in pairs, column by column, padded to four values (simd/block_rows.hpp): eight lanes
/// do two columns of two blocks at once, and neither assembly nor product moves values between lanes.
/// Assembly gathers: each block adds up its own terms, elements ascending, so that no two threads write one
/// block and the bits do not depend on the thread count.
class BlockMatrix {
 public:
  /// Pattern: each free point of an element, with itself and with the other corners of its elements. Throws
  /// Error where there are 2^30 elements or more, or a point has thousands of neighbours. O(n_elements log).
  /// \param free  (n_points) 1: has a row
  BlockMatrix(const Elements& elements, std::span<const std::uint8_t> free);

  [[nodiscard]] Index size() const { return static_cast<Index>(diagonal_.size()); }  ///< n_points

  /// diagonal[i] I on the diagonal plus the sum over elements of K'_e times its factor, as of
  /// Elements::update().
  /// \param diagonal  (n_points), > 0; entries of rows that are empty are ignored
  void assemble(const parallel::Threads& threads, const Elements& elements, std::span<const double> diagonal);

  /// Points of a row's blocks, ascending.
  [[nodiscard]] std::span<const std::uint32_t> columns(Index row) const;
  /// Block `place` of a row: with columns(row)[place].
  [[nodiscard]] Matrix3 block(Index row, std::size_t place) const;
  /// The block on the diagonal; zero where the row is empty.
  [[nodiscard]] SymmetricMatrix3 diagonal_block(Index row) const;
  /// The diagonal of the last assemble() (n_points).
  [[nodiscard]] std::span<const double> diagonal() const { return diagonal_; }
  /// What products read.
  [[nodiscard]] simd::BlockRows rows() const;

  /// Elements at a point, ascending.
  [[nodiscard]] const Rows& elements_of_point() const { return elements_of_point_; }
  /// The same with corners, entry by entry.
  [[nodiscard]] std::span<const simd::Incidence> incidences() const { return incidences_; }

 private:
  /// Aligned to the columns of a pair.
  struct alignas(64) BlockPair {
    std::array<double, 24> values{};
  };
  void gather_incidences(const Elements& elements);
  void build_row(const Elements& elements, Index row);
  void find_mixed_rows(const Elements& elements);

  Rows elements_of_point_;
  std::vector<std::uint32_t> pair_begin_;   ///< (n_points + 1)
  std::vector<std::uint32_t> block_count_;  ///< (n_points), without those of zeros
  std::vector<std::uint32_t> columns_;      ///< 2 a pair
  std::vector<simd::Incidence>
      incidences_;  ///< as elements_of_point_; places only where the row is not empty
  std::vector<std::uint32_t> diagonal_block_;  ///< (n_points)
  std::vector<std::uint8_t> mixed_;            ///< (n_points): 1 where lambda / mu differs within the body
  std::vector<double> diagonal_;
  std::vector<BlockPair> pairs_;
};

}  // namespace palpate::fem
