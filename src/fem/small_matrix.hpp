#pragma once

#include <array>
#include <cmath>
#include <cstddef>

/// Small dense matrices, row by row, of sizes known to the compiler.
namespace palpate::fem {

template <std::size_t N, std::size_t M>
using Dense = std::array<double, N * M>;

/// s += a b
template <std::size_t N, std::size_t K, std::size_t M>
void add_product(Dense<N, M>& s, const Dense<N, K>& a, const Dense<K, M>& b) {
  for (std::size_t i = 0; i < N; ++i) {
    std::array<double, M> sum{};  // by rows of b, so that compilers use SIMD
    for (std::size_t k = 0; k < K; ++k) {
      for (std::size_t j = 0; j < M; ++j) sum[j] += a[K * i + k] * b[M * k + j];
    }
    for (std::size_t j = 0; j < M; ++j) s[M * i + j] += sum[j];
  }
}

/// s += a^T b
template <std::size_t N, std::size_t K, std::size_t M>
void add_transposed_product(Dense<N, M>& s, const Dense<K, N>& a, const Dense<K, M>& b) {
  for (std::size_t i = 0; i < N; ++i) {
    std::array<double, M> sum{};
    for (std::size_t k = 0; k < K; ++k) {
      for (std::size_t j = 0; j < M; ++j) sum[j] += a[N * k + i] * b[M * k + j];
    }
    for (std::size_t j = 0; j < M; ++j) s[M * i + j] += sum[j];
  }
}

/// s -= a b^T
template <std::size_t N, std::size_t K, std::size_t M>
void subtract_product_transposed(Dense<N, M>& s, const Dense<N, K>& a, const Dense<M, K>& b) {
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t j = 0; j < M; ++j) {
      double sum = 0.0;
      for (std::size_t k = 0; k < K; ++k) sum += a[K * i + k] * b[K * j + k];
      s[M * i + j] -= sum;
    }
  }
}

/// The inverse of a symmetric positive semi-definite matrix, by Cholesky. A pivot that is not positive up to
/// rounding drops its variable: its row and column of the inverse are zero.
template <std::size_t N>
Dense<N, N> inverse_semi_definite(Dense<N, N> a) {
  constexpr double rounding = 1e-12;
  for (std::size_t j = 0; j < N; ++j) {
    const double before = a[N * j + j];
    double pivot = before;
    for (std::size_t k = 0; k < j; ++k) pivot -= a[N * j + k] * a[N * j + k];
    const double inverse = pivot > rounding * before ? 1.0 / std::sqrt(pivot) : 0.0;
    for (std::size_t i = j + 1; i < N; ++i) {
      double sum = a[N * i + j];
      for (std::size_t k = 0; k < j; ++k) sum -= a[N * i + k] * a[N * j + k];
      a[N * i + j] = sum * inverse;
    }
    a[N * j + j] = inverse;
  }
  Dense<N, N> g{};  // the inverse of the factor
  for (std::size_t j = 0; j < N; ++j) {
    g[N * j + j] = a[N * j + j];
    for (std::size_t i = j + 1; i < N; ++i) {
      double sum = 0.0;
      for (std::size_t k = j; k < i; ++k) sum -= a[N * i + k] * g[N * k + j];
      g[N * i + j] = sum * a[N * i + i];
    }
  }
  Dense<N, N> inverse{};
  add_transposed_product<N, N, N>(inverse, g, g);
  return inverse;
}

}  // namespace palpate::fem
