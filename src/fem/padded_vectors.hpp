#pragma once

#include <cstddef>
#include <span>

#include "geometry/vector.hpp"
#include "simd/padded.hpp"
#include "simd/sliced_rows.hpp"

/// Access to vectors by point in double, and by row in float slices.
namespace palpate::fem {

inline Vec3 unpadded(const simd::Padded3& a) {
  return {a.x, a.y, a.z};
}
inline simd::Padded3 padded(const Vec3& a) {
  return {a.x, a.y, a.z, 0.0};
}

/// Stores a vector in a row of four.
inline void store(const Vec3& a, double* row) {
  row[0] = a.x;
  row[1] = a.y;
  row[2] = a.z;
  row[3] = 0.0;
}

/// Position of a row in vectors by slices.
inline std::size_t place_of(std::size_t row) {
  return simd::slice_values * (row / simd::slice_rows) + row % simd::slice_rows;
}

/// Stores factor times value in a row.
inline void set_row(std::span<float> vector, std::size_t row, const Vec3& value, double factor = 1.0) {
  float* place = &vector[place_of(row)];
  place[0] = static_cast<float>(factor * value.x);
  place[simd::slice_rows] = static_cast<float>(factor * value.y);
  place[2 * simd::slice_rows] = static_cast<float>(factor * value.z);
}

/// factor times the value of a row.
inline Vec3 get_row(std::span<const float> vector, std::size_t row, double factor = 1.0) {
  const float* place = &vector[place_of(row)];
  return {factor * static_cast<double>(place[0]), factor * static_cast<double>(place[simd::slice_rows]),
          factor * static_cast<double>(place[2 * simd::slice_rows])};
}

}  // namespace palpate::fem
