// The loops of direction_rows.hpp, compiled once for each target: lanes are explicit, so that each compiler
// finds the vectors and none changes the order of a sum. No include guard: one inclusion a target.
#include <array>

inline bool is_zero(const double* m) {
  bool zero = true;
  for (std::size_t e = 0; e < 9; ++e) zero = zero && m[e] == 0.0;
  return zero;
}

/// Sums of products by lanes: a slice at a time in float, which many lanes take at once.
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

inline void combine_rates(const ContactRates& rates, const double* c, Vec3* u, std::size_t begin,
                          std::size_t end) {
  constexpr std::size_t lanes = direction_lanes;
  for (std::size_t k = begin; k < end; ++k) {
    std::array<double, 3> sums{};
    for (std::size_t e = 0; e < 3; ++e) {
      const double* j = rates.values + rates.stride * (3 * k + e);
      std::array<double, lanes> parts{};
      for (std::size_t i = 0; i < rates.n; i += lanes) {
        for (std::size_t lane = 0; lane < lanes; ++lane) parts[lane] += j[i + lane] * c[i + lane];
      }
      for (const double part : parts) sums[e] += part;
    }
    u[k] = {sums[0], sums[1], sums[2]};
  }
}

inline void project_forces(const ContactRates& rates, const Vec3* f, double* sum, std::size_t begin,
                           std::size_t end) {
  for (std::size_t k = begin; k < end; ++k) {
    if (f[k].x == 0.0 && f[k].y == 0.0 && f[k].z == 0.0) continue;
    const double* x = rates.values + rates.stride * 3 * k;
    const double* y = x + rates.stride;
    const double* z = y + rates.stride;
    for (std::size_t i = 0; i < rates.n; ++i) sum[i] += x[i] * f[k].x + y[i] * f[k].y + z[i] * f[k].z;
  }
}

inline void add_stiffness(const ContactRates& rates, const double* h, double* sum, std::size_t begin,
                          std::size_t end) {
  constexpr std::size_t most = 64;
  alignas(64) std::array<double, 3 * most> turned;
  for (std::size_t k = begin; k < end; ++k) {
    const double* m = h + 9 * k;
    if (is_zero(m)) continue;
    const double* x = rates.values + rates.stride * 3 * k;
    const double* y = x + rates.stride;
    const double* z = y + rates.stride;
    for (std::size_t i = 0; i < rates.n; ++i) {
      turned[i] = m[0] * x[i] + m[1] * y[i] + m[2] * z[i];
      turned[most + i] = m[3] * x[i] + m[4] * y[i] + m[5] * z[i];
      turned[2 * most + i] = m[6] * x[i] + m[7] * y[i] + m[8] * z[i];
    }
    for (std::size_t i = 0; i < rates.n; ++i) {
      double* row = sum + rates.stride * i;
      for (std::size_t l = 0; l < rates.n; ++l)
        row[l] += x[i] * turned[l] + y[i] * turned[most + l] + z[i] * turned[2 * most + l];
    }
  }
}

inline void add_stiffness_row(const ContactRates& rates, const double* h, std::size_t i, double* row,
                              double* column, std::size_t begin, std::size_t end) {
  for (std::size_t k = begin; k < end; ++k) {
    const double* m = h + 9 * k;
    if (is_zero(m)) continue;
    const double* x = rates.values + rates.stride * 3 * k;
    const double* y = x + rates.stride;
    const double* z = y + rates.stride;
    std::array<double, 3> left{};
    std::array<double, 3> right{};
    for (std::size_t e = 0; e < 3; ++e) {
      left[e] = x[i] * m[e] + y[i] * m[3 + e] + z[i] * m[6 + e];
      right[e] = m[3 * e] * x[i] + m[3 * e + 1] * y[i] + m[3 * e + 2] * z[i];
    }
    for (std::size_t l = 0; l < rates.n; ++l) {
      row[l] += left[0] * x[l] + left[1] * y[l] + left[2] * z[l];
      column[l] += right[0] * x[l] + right[1] * y[l] + right[2] * z[l];
    }
  }
}
