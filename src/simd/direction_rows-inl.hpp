// The loops of direction_rows.hpp, compiled once for each target. Lanes are explicit, so that every compiler
// vectorises the loops and keeps the order of sums. No include guard: included once per target.
#include <array>

/// Sums of products by lane. Sums over one slice are in float, since float has more lanes.
struct LaneSums {
  alignas(64) std::array<double, slice_rows> lanes{};

  void add_slice(const float* a, const float* b) {
    for (std::size_t k = 0; k < slice_rows; ++k) {
      const float x = a[k] * b[k];
      const float y = a[slice_rows + k] * b[slice_rows + k];
      const float z = a[2 * slice_rows + k] * b[2 * slice_rows + k];
      lanes[k] += static_cast<double>(x + y + z);
    }
  }
  [[nodiscard]] double sum() const {
    double total = 0.0;
    for (const double lane : lanes) total += lane;
    return total;
  }
};

inline double dot_floats(const float* a, const float* b, std::size_t n) {
  LaneSums sums;
  for (std::size_t i = 0; i < n; i += slice_values) sums.add_slice(a + i, b + i);
  return sums.sum();
}

inline TwoSums dot_two(const float* a, const float* b, const float* c, std::size_t n) {
  LaneSums first;
  LaneSums second;
  for (std::size_t i = 0; i < n; i += slice_values) {
    first.add_slice(a + i, b + i);
    second.add_slice(a + i, c + i);
  }
  return {first.sum(), second.sum()};
}

inline void subtract_combination(const FloatVectors& vectors, const float* s, float* a, std::size_t n) {
  for (std::size_t i = 0; i < n; i += slice_values) {
    alignas(64) std::array<float, slice_values> sum;
    for (std::size_t k = 0; k < slice_values; ++k) sum[k] = a[i + k];
    for (std::size_t v = 0; v < vectors.count; ++v) {
      const float* from = vectors.values + vectors.stride * v + i;
      for (std::size_t k = 0; k < slice_values; ++k) sum[k] -= s[v] * from[k];
    }
    for (std::size_t k = 0; k < slice_values; ++k) a[i + k] = sum[k];
  }
}

inline void combine_in_double(const FloatVectors& vectors, const double* s, double* a, std::size_t n) {
  for (std::size_t i = 0; i < n; i += slice_values) {
    alignas(64) std::array<double, slice_values> sum{};
    for (std::size_t v = 0; v < vectors.count; ++v) {
      const float* from = vectors.values + vectors.stride * v + i;
      for (std::size_t k = 0; k < slice_values; ++k) sum[k] += s[v] * static_cast<double>(from[k]);
    }
    for (std::size_t k = 0; k < slice_values; ++k) a[i + k] = sum[k];
  }
}
