#include "simd/envelope.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/envelope.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR && !HWY_HAVE_SCALABLE

namespace {
namespace hn = hwy::HWY_NAMESPACE;

using Column = hn::CappedTag<double, envelope_vector>;
constexpr std::size_t lanes = hn::MaxLanes(Column());
constexpr std::size_t parts = envelope_vector / lanes;
using ColumnV = std::array<hn::Vec<Column>, parts>;
constexpr std::size_t n = 6;

HWY_INLINE ColumnV load(const double* values) {
  ColumnV v;
  for (std::size_t p = 0; p < parts; ++p) v[p] = hn::Load(Column(), values + lanes * p);
  return v;
}
HWY_INLINE void store(const ColumnV& v, double* values) {
  for (std::size_t p = 0; p < parts; ++p) hn::Store(v[p], Column(), values + lanes * p);
}
/// s -= factor v
HWY_INLINE void subtract(double factor, const ColumnV& v, ColumnV& s) {
  const auto all = hn::Set(Column(), factor);
  for (std::size_t p = 0; p < parts; ++p) s[p] = hn::NegMulAdd(all, v[p], s[p]);
}
HWY_INLINE void scale(double factor, ColumnV& s) {
  const auto all = hn::Set(Column(), factor);
  for (std::size_t p = 0; p < parts; ++p) s[p] = hn::Mul(all, s[p]);
}

HWY_INLINE const double* block(const Envelope& a, std::size_t row, std::size_t column) {
  return a.blocks + envelope_block * (a.begin[row] + column);
}

using Block = std::array<ColumnV, n>;

/// s -= a b^T
HWY_INLINE void subtract_product(const double* a, const double* b, Block& s) {
  for (std::size_t k = 0; k < n; ++k) {
    const ColumnV column = load(a + envelope_vector * k);
    for (std::size_t j = 0; j < n; ++j) subtract(b[envelope_vector * k + j], column, s[j]);
  }
}

/// x <- x l^-T, with l a factored diagonal block.
HWY_INLINE void solve_right(const double* l, Block& x) {
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t k = 0; k < j; ++k) subtract(l[envelope_vector * k + j], x[k], x[j]);
    scale(l[envelope_vector * j + j], x[j]);
  }
}

/// The factor of a diagonal block. Leaves the part above its diagonal.
HWY_INLINE void factor_diagonal(double* a) {
  constexpr double rounding = 1e-13;
  for (std::size_t j = 0; j < n; ++j) {
    double* column = a + envelope_vector * j;
    const double before = column[j];
    for (std::size_t k = 0; k < j; ++k) {
      const double* other = a + envelope_vector * k;
      for (std::size_t i = j; i < n; ++i) column[i] -= other[i] * other[j];
    }
    const double inverse = column[j] > rounding * before ? 1.0 / std::sqrt(column[j]) : 0.0;
    column[j] = inverse;
    for (std::size_t i = j + 1; i < n; ++i) column[i] *= inverse;
  }
}

}  // namespace

void factor_envelope(const Envelope& a) {
  for (std::size_t row = 0; row < a.rows; ++row) {
    const auto first = static_cast<std::size_t>(a.first[row]);
    for (std::size_t column = first; column <= row; ++column) {
      double* place = a.blocks + envelope_block * (a.begin[row] + column);
      Block s;
      for (std::size_t j = 0; j < n; ++j) s[j] = load(place + envelope_vector * j);
      for (std::size_t k = std::max(first, static_cast<std::size_t>(a.first[column])); k < column; ++k)
        subtract_product(block(a, row, k), block(a, column, k), s);
      if (column < row) solve_right(block(a, column, column), s);
      for (std::size_t j = 0; j < n; ++j) store(s[j], place + envelope_vector * j);
      if (column == row) {
        factor_diagonal(place);
        continue;
      }
      double* other = a.transposed + (place - a.blocks);
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < n; ++j) other[envelope_vector * i + j] = place[envelope_vector * j + i];
      }
    }
  }
}

void solve_envelope(const Envelope& a, double* x) {
  for (std::size_t row = 0; row < a.rows; ++row) {
    double* y = x + envelope_vector * row;
    ColumnV even = load(y);
    ColumnV odd = load(y);
    scale(0.0, odd);
    for (auto column = static_cast<std::size_t>(a.first[row]); column < row; ++column) {
      const double* l = block(a, row, column);
      const double* other = x + envelope_vector * column;
      for (std::size_t k = 0; k < n; ++k)
        subtract(other[k], load(l + envelope_vector * k), k % 2 == 0 ? even : odd);
    }
    for (std::size_t p = 0; p < parts; ++p) even[p] = hn::Add(even[p], odd[p]);
    store(even, y);
    const double* l = block(a, row, row);
    for (std::size_t k = 0; k < n; ++k) {
      y[k] *= l[envelope_vector * k + k];
      for (std::size_t i = k + 1; i < n; ++i) y[i] -= l[envelope_vector * k + i] * y[k];
    }
  }
  for (std::size_t row = a.rows; row-- > 0;) {
    double* own = x + envelope_vector * row;
    const double* diagonal = block(a, row, row);
    for (std::size_t i = n; i-- > 0;) {
      for (std::size_t k = i + 1; k < n; ++k) own[i] -= diagonal[envelope_vector * i + k] * own[k];
      own[i] *= diagonal[envelope_vector * i + i];
    }
    for (auto column = static_cast<std::size_t>(a.first[row]); column < row; ++column) {
      const double* l = a.transposed + envelope_block * (a.begin[row] + column);
      ColumnV y = load(x + envelope_vector * column);
      for (std::size_t k = 0; k < n; ++k) subtract(own[k], load(l + envelope_vector * k), y);
      store(y, x + envelope_vector * column);
    }
  }
}

#else

using scalar::factor_envelope;
using scalar::solve_envelope;

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(factor_envelope);
HWY_EXPORT(solve_envelope);

void factor_envelope(const Envelope& a) {
  HWY_DYNAMIC_DISPATCH(factor_envelope)(a);
}
void solve_envelope(const Envelope& a, double* x) {
  HWY_DYNAMIC_DISPATCH(solve_envelope)(a, x);
}

}  // namespace palpate::simd
#endif
