#pragma once

#include <array>
#include <cstdint>

#include "grid/lattice.hpp"

namespace palpate {

/// The Lebesgue (Z-order) curve over a lattice (paper 5, "Z-curves"; Pascucci & Frank 2001): the bits of i, j
/// and k alternate, i lowest. 21 bits per axis fill 63 bits.
///
/// Deviation: of each axis only the bits that its size needs are used. Where all axes need the same number,
/// this is the plain interleave; in a flat or long domain it leaves out bits that are always zero, so that
/// indices stay below 8 times the number of cells.
class ZOrder {
 public:
  ZOrder() = default;
  /// \param size  cells along each axis, each in [1, 2^21]
  explicit ZOrder(const Cell& size);

  /// The bits of one coordinate, at their positions in the index. The index is the sum over the axes.
  [[nodiscard]] std::uint64_t part(std::size_t axis, std::int32_t coordinate) const {
    const auto c = static_cast<std::uint32_t>(coordinate);
    const auto& spread = spread_[axis];
    return spread[0][c & (chunk_ - 1)] | spread[1][(c >> chunk_bits_) & (chunk_ - 1)] |
           spread[2][c >> (2 * chunk_bits_)];
  }
  [[nodiscard]] std::uint64_t index(const Cell& cell) const {
    return part(0, cell[0]) | part(1, cell[1]) | part(2, cell[2]);
  }
  /// The inverse of index(). O(bits).
  [[nodiscard]] Cell cell_of(std::uint64_t index) const;
  /// Bits of an index; all indices are below 2^bits().
  [[nodiscard]] int bits() const { return bits_; }
  /// The number of bits of `axis` among the lowest `count` bits of an index. So 2^count consecutive indices,
  /// aligned, are a box of 2^low_bits(0, count) x 2^low_bits(1, count) x 2^low_bits(2, count) cells.
  [[nodiscard]] int low_bits(std::size_t axis, int count) const;

 private:
  static constexpr int axis_bits_ = 21;
  static constexpr int chunk_bits_ = 7;  ///< three tables of 128 per axis: 9 KiB in all, and 1 KiB per axis
                                         ///< in use where it has at most 128 cells
  static constexpr std::uint32_t chunk_ = 1U << chunk_bits_;

  std::array<std::array<std::array<std::uint64_t, chunk_>, 3>, 3> spread_{};  ///< [axis][7 bits each][bits]
  std::array<std::uint8_t, std::size_t{3} * axis_bits_> axis_of_bit_{};
  int bits_ = 0;
};

}  // namespace palpate
