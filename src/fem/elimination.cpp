#include "fem/elimination.hpp"

#include <cmath>
#include <utility>

namespace palpate::fem {

bool solve_by_elimination(double* m, std::size_t stride, std::size_t n, double* x) {
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i) {
      if (std::abs(m[stride * i + k]) > std::abs(m[stride * pivot + k])) pivot = i;
    }
    if (!(std::abs(m[stride * pivot + k]) > 0.0)) return false;
    if (pivot != k) {
      for (std::size_t j = k; j < n; ++j) std::swap(m[stride * k + j], m[stride * pivot + j]);
      std::swap(x[k], x[pivot]);
    }
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = m[stride * i + k] / m[stride * k + k];
      if (factor == 0.0) continue;
      for (std::size_t j = k + 1; j < n; ++j) m[stride * i + j] -= factor * m[stride * k + j];
      x[i] -= factor * x[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) x[k] -= m[stride * k + j] * x[j];
    x[k] /= m[stride * k + k];
  }
  return true;
}

}  // namespace palpate::fem
