#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <palpate/types.hpp>

namespace palpate::simd {

/// A point in fixed-point coordinates below 2^31, in fractions of a cell from the corner of the domain
/// (docs/query.md). The name is its index, plus the bit `marked` if clusters can leave the point out.
struct alignas(16) FixedPoint {
  std::int32_t x;
  std::int32_t y;
  std::int32_t z;
  std::int32_t name;
};
inline constexpr std::uint32_t marked = std::uint32_t{1} << 31;
constexpr std::int32_t index_of_name(std::int32_t name) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(name) & ~marked);
}

/// Coarse coordinates: the lowest bits of a coordinate in 64ths of a cell. Three of them make a coarse word,
/// each with a guard bit above it (docs/query.md, "Coarse words").
struct Coarse {
  static constexpr int cell_bits = 6;   ///< the unit is 2^-6 of a cell
  static constexpr int field_bits = 9;  ///< bits per axis: coordinates repeat after 8 cells
  static constexpr std::int32_t mask = (1 << field_bits) - 1;
  /// Distance in a word from the bits of one axis to those of the next.
  static constexpr int step = field_bits + 1;
  /// One number for each axis, below 2^step.
  static constexpr std::int32_t word(std::int32_t x, std::int32_t y, std::int32_t z) {
    return x | y << step | z << (2 * step);
  }
};

/// Points in the order of their cells, with row_padding places beyond their end.
struct PointRows {
  const FixedPoint* points;   ///< by index, not in the order of cells
  const std::int32_t* words;  ///< fixed-point number >> this is the coarse coordinate
  const std::int32_t* names;  ///< names of the points, in order
  int coarse_shift;           ///< fixed-point numbers >> this are coarse
};
inline constexpr std::size_t row_padding = 16;

/// The box of positions.
struct Bounds {
  Vec3 lower;
  Vec3 upper;
  bool finite;  ///< whether all coordinates are finite; if not, the box is undefined
};

/// Sets points[i] to floor((positions[i] - lower) x scale) and keeps its name. Numbers out of range become
/// some number in range. Returns the box of the positions; there must be at least one.
Bounds place_points(std::span<const Vec3> positions, const Vec3& lower, double scale, FixedPoint* points);

/// Sets words and names of points; may read and write up to row_padding places beyond.
void coarse_words(std::span<const FixedPoint> points, int coarse_shift, std::int32_t* words,
                  std::int32_t* names);

/// The largest distance along an axis between points and references with the same names.
std::int32_t largest_motion(std::span<const FixedPoint> points, std::span<const FixedPoint> references);

/// How a key is made from fixed-point coordinates: cell = min(number >> fraction_bits, size - 1) on each
/// axis, key = i + j size_x + k size_x size_y, below 2^31.
struct KeyRule {
  int fraction_bits;
  std::array<std::int32_t, 3> size;
};
void linear_keys(std::span<const FixedPoint> points, const KeyRule& rule, std::uint32_t* keys);

}  // namespace palpate::simd
