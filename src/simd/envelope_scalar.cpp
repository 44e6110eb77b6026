// The kernels of envelope.cpp in plain C++. Targets without vectors run these.
#include <algorithm>
#include <cmath>

#include "simd/envelope.hpp"

namespace palpate::simd::scalar {
namespace {

constexpr std::size_t n = 6;

/// Entry (i, j) of a block.
double& entry(double* block, std::size_t i, std::size_t j) {
  return block[envelope_vector * j + i];
}

/// s -= a b^T
void subtract_product(double* s, double* a, double* b) {
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      for (std::size_t k = 0; k < n; ++k) entry(s, i, j) -= entry(a, i, k) * entry(b, j, k);
    }
  }
}

/// x <- x l^-T, with l a factored diagonal block.
void solve_right(double* x, double* l) {
  for (std::size_t row = 0; row < n; ++row) {
    for (std::size_t j = 0; j < n; ++j) {
      for (std::size_t k = 0; k < j; ++k) entry(x, row, j) -= entry(x, row, k) * entry(l, j, k);
      entry(x, row, j) *= entry(l, j, j);
    }
  }
}

void factor_diagonal(double* a) {
  constexpr double rounding = 1e-13;
  for (std::size_t j = 0; j < n; ++j) {
    const double before = entry(a, j, j);
    for (std::size_t i = j; i < n; ++i) {
      for (std::size_t k = 0; k < j; ++k) entry(a, i, j) -= entry(a, i, k) * entry(a, j, k);
    }
    const double pivot = entry(a, j, j);
    const double inverse = pivot > rounding * before ? 1.0 / std::sqrt(pivot) : 0.0;
    entry(a, j, j) = inverse;
    for (std::size_t i = j + 1; i < n; ++i) entry(a, i, j) *= inverse;
  }
}

double* block(const Envelope& a, std::size_t row, std::size_t column) {
  return a.blocks + envelope_block * (a.begin[row] + column);
}

}  // namespace

void factor_envelope(const Envelope& a) {
  for (std::size_t row = 0; row < a.rows; ++row) {
    const auto first = static_cast<std::size_t>(a.first[row]);
    for (std::size_t column = first; column <= row; ++column) {
      double* s = block(a, row, column);
      for (std::size_t k = std::max(first, static_cast<std::size_t>(a.first[column])); k < column; ++k)
        subtract_product(s, block(a, row, k), block(a, column, k));
      if (column == row) {
        factor_diagonal(s);
        continue;
      }
      solve_right(s, block(a, column, column));
      double* other = a.transposed + (s - a.blocks);
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < n; ++j) entry(other, j, i) = entry(s, i, j);
      }
    }
  }
}

void solve_envelope(const Envelope& a, double* x) {
  for (std::size_t row = 0; row < a.rows; ++row) {
    double* y = x + envelope_vector * row;
    for (auto column = static_cast<std::size_t>(a.first[row]); column < row; ++column) {
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < n; ++k)
          y[i] -= entry(block(a, row, column), i, k) * x[envelope_vector * column + k];
      }
    }
    double* l = block(a, row, row);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 0; k < i; ++k) y[i] -= entry(l, i, k) * y[k];
      y[i] *= entry(l, i, i);
    }
  }
  for (std::size_t row = a.rows; row-- > 0;) {
    double* y = x + envelope_vector * row;
    double* l = block(a, row, row);
    for (std::size_t i = n; i-- > 0;) {
      for (std::size_t k = i + 1; k < n; ++k) y[i] -= entry(l, k, i) * y[k];
      y[i] *= entry(l, i, i);
    }
    for (auto column = static_cast<std::size_t>(a.first[row]); column < row; ++column) {
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < n; ++k)
          x[envelope_vector * column + i] -= entry(block(a, row, column), k, i) * y[k];
      }
    }
  }
}

}  // namespace palpate::simd::scalar
