#include "fem/envelope_cholesky.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t n = 6;

/// s -= a b^T
void subtract_product(Block6& s, const Block6& a, const Block6& b) {
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      double sum = 0.0;
      for (std::size_t k = 0; k < n; ++k) sum += a[n * i + k] * b[n * j + k];
      s[n * i + j] -= sum;
    }
  }
}

/// x <- x l^-T, with l a factored diagonal block.
void solve_right(Block6& x, const Block6& l) {
  for (std::size_t row = 0; row < n; ++row) {
    for (std::size_t j = 0; j < n; ++j) {
      double sum = x[n * row + j];
      for (std::size_t k = 0; k < j; ++k) sum -= x[n * row + k] * l[n * j + k];
      x[n * row + j] = sum * l[n * j + j];
    }
  }
}

}  // namespace

void EnvelopeCholesky::reset(std::span<const Index> first) {
  first_.assign(first.begin(), first.end());
  resize_with_room(begin_, first.size());
  std::size_t count = 0;
  for (std::size_t row = 0; row < first.size(); ++row) {
    begin_[row] = count - static_cast<std::size_t>(first[row]);
    count += row + 1 - static_cast<std::size_t>(first[row]);
  }
  assign_with_room(blocks_, count, Block6{});
}

Block6& EnvelopeCholesky::block(Index row, Index column) {
  return blocks_[at(begin_, row) + static_cast<std::size_t>(column)];
}

void EnvelopeCholesky::factor_diagonal(Block6& a) {
  constexpr double rounding = 1e-13;
  for (std::size_t j = 0; j < n; ++j) {
    double pivot = a[n * j + j];
    const double before = a[n * j + j];
    for (std::size_t k = 0; k < j; ++k) pivot -= a[n * j + k] * a[n * j + k];
    const double inverse = pivot > rounding * before ? 1.0 / std::sqrt(pivot) : 0.0;
    for (std::size_t i = j + 1; i < n; ++i) {
      double sum = a[n * i + j];
      for (std::size_t k = 0; k < j; ++k) sum -= a[n * i + k] * a[n * j + k];
      a[n * i + j] = sum * inverse;
    }
    a[n * j + j] = inverse;
  }
}

void EnvelopeCholesky::factor() {
  for (Index row = 0; row < size(); ++row) {
    for (Index column = at(first_, row); column <= row; ++column) {
      Block6& s = block(row, column);
      for (Index k = std::max(at(first_, row), at(first_, column)); k < column; ++k)
        subtract_product(s, at_place(row, k), at_place(column, k));
      if (column < row) {
        solve_right(s, at_place(column, column));
      } else {
        factor_diagonal(s);
      }
    }
  }
}

void EnvelopeCholesky::solve(std::span<Vector6> b) const {
  for (Index row = 0; row < size(); ++row) {
    Vector6& y = at(b, row);
    for (Index column = at(first_, row); column < row; ++column) {
      const Block6& l = at_place(row, column);
      const Vector6& x = at(b, column);
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < n; ++k) y[i] -= l[n * i + k] * x[k];
      }
    }
    const Block6& l = at_place(row, row);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 0; k < i; ++k) y[i] -= l[n * i + k] * y[k];
      y[i] *= l[n * i + i];
    }
  }
  for (Index row = size() - 1; row >= 0; --row) {
    Vector6& x = at(b, row);
    const Block6& diagonal = at_place(row, row);
    for (std::size_t i = n; i-- > 0;) {
      for (std::size_t k = i + 1; k < n; ++k) x[i] -= diagonal[n * k + i] * x[k];
      x[i] *= diagonal[n * i + i];
    }
    for (Index column = at(first_, row); column < row; ++column) {
      const Block6& l = at_place(row, column);
      Vector6& y = at(b, column);
      for (std::size_t k = 0; k < n; ++k) {
        for (std::size_t i = 0; i < n; ++i) y[i] -= l[n * k + i] * x[k];
      }
    }
  }
}

}  // namespace palpate::fem
