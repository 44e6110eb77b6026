// The kernels of contact_rates.cpp in plain C++, with the same bits.
#include <array>

#include "simd/contact_rates.hpp"

namespace palpate::simd::scalar {
namespace {

double wide(float x) {
  return static_cast<double>(x);
}

bool is_zero(const double* m) {
  bool zero = true;
  for (std::size_t e = 0; e < 9; ++e) zero = zero && m[e] == 0.0;
  return zero;
}

/// Rows of J of a contact.
struct Rates {
  const float* x;
  const float* y;
  const float* z;
  Rates(const ContactRates& rates, std::size_t contact)
      : x(rates.values + rates.stride * 3 * contact), y(x + rates.stride), z(y + rates.stride) {}
};

/// a x_l + b y_l + c z_l
double combination(const Rates& j, std::size_t l, double a, double b, double c) {
  return a * wide(j.x[l]) + b * wide(j.y[l]) + c * wide(j.z[l]);
}

double dot(const float* row, const double* c, std::size_t n) {
  static_assert(direction_lanes == 8);
  std::array<double, direction_lanes> p{};
  for (std::size_t i = 0; i < n; i += direction_lanes) {
    for (std::size_t lane = 0; lane < direction_lanes; ++lane) p[lane] += wide(row[i + lane]) * c[i + lane];
  }
  return ((p[0] + p[4]) + (p[2] + p[6])) + ((p[1] + p[5]) + (p[3] + p[7]));
}

}  // namespace

void combine_rates(const ContactRates& rates, const double* c, Vec3* u, std::size_t begin, std::size_t end) {
  for (std::size_t k = begin; k < end; ++k) {
    const Rates j(rates, k);
    u[k] = {dot(j.x, c, rates.n), dot(j.y, c, rates.n), dot(j.z, c, rates.n)};
  }
}

void project_forces(const ContactRates& rates, const Vec3* f, double* sum, std::size_t begin,
                    std::size_t end) {
  for (std::size_t k = begin; k < end; ++k) {
    if (f[k] == Vec3{}) continue;
    const Rates j(rates, k);
    for (std::size_t i = 0; i < rates.n; ++i) sum[i] += combination(j, i, f[k].x, f[k].y, f[k].z);
  }
}

void add_stiffness(const ContactRates& rates, const double* h, double* sum, std::size_t begin,
                   std::size_t end) {
  for (std::size_t k = begin; k < end; ++k) {
    const double* m = h + 9 * k;
    if (is_zero(m)) continue;
    const Rates j(rates, k);
    for (std::size_t l = 0; l < rates.n; ++l) {
      const double x = combination(j, l, m[0], m[1], m[2]);
      const double y = combination(j, l, m[3], m[4], m[5]);
      const double z = combination(j, l, m[6], m[7], m[8]);
      for (std::size_t i = 0; i < rates.n; ++i) {
        double& entry = sum[rates.stride * i + l];
        entry = ((entry + wide(j.x[i]) * x) + wide(j.y[i]) * y) + wide(j.z[i]) * z;
      }
    }
  }
}

void add_stiffness_row(const ContactRates& rates, const double* h, std::size_t i, double* row, double* column,
                       std::size_t begin, std::size_t end) {
  for (std::size_t k = begin; k < end; ++k) {
    const double* m = h + 9 * k;
    if (is_zero(m)) continue;
    const Rates j(rates, k);
    std::array<double, 3> left{};
    std::array<double, 3> right{};
    for (std::size_t e = 0; e < 3; ++e) {
      left[e] = combination(j, i, m[e], m[3 + e], m[6 + e]);
      right[e] = combination(j, i, m[3 * e], m[3 * e + 1], m[3 * e + 2]);
    }
    for (std::size_t l = 0; l < rates.n; ++l) {
      row[l] += combination(j, l, left[0], left[1], left[2]);
      column[l] += combination(j, l, right[0], right[1], right[2]);
    }
  }
}

}  // namespace palpate::simd::scalar
