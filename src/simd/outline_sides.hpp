#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <palpate/types.hpp>

namespace palpate::simd {

/// The sides of a triangle, one per lane, as seen along a straight line. Side i is opposite to corner i.
struct OutlineSides {
  static constexpr std::size_t most = 4;
  using Points = std::array<Index, most>;
  // The fourth lane must have valid indices.
  Points from{};                     ///< first corner of each side
  Points to{};                       ///< second corner
  std::array<Points, 3> neighbor{};  ///< corners of the triangle beyond the side; any where there is none
  // Outputs of find_sides():
  alignas(32) std::array<double, most> x;  ///< shortest displacement from the line to the side, across it
  alignas(32) std::array<double, most> y;
  alignas(32) std::array<double, most> z;
  alignas(32) std::array<double, most> distance;  ///< its length
  alignas(32) std::array<double, most> length2;   ///< squared length of the side, across the line
  /// Sine of the angle between the line and the triangle beyond; positive if the line leaves through it.
  alignas(32) std::array<double, most> facing;
};

/// \param origin     a point of the line
/// \param direction  unit
void find_sides(const Vec3* positions, const Vec3& origin, const Vec3& direction, OutlineSides& sides);

}  // namespace palpate::simd
