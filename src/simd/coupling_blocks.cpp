#include "simd/coupling_blocks.hpp"

#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/coupling_blocks.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR && !HWY_HAVE_SCALABLE

namespace {
namespace hn = hwy::HWY_NAMESPACE;

using Row = hn::CappedTag<double, row_of_six>;
constexpr std::size_t lanes = hn::MaxLanes(Row());
constexpr std::size_t parts = row_of_six / lanes;
using RowV = std::array<hn::Vec<Row>, parts>;

HWY_INLINE RowV load(const double* values) {
  RowV v;
  for (std::size_t p = 0; p < parts; ++p) v[p] = hn::Load(Row(), values + lanes * p);
  return v;
}
HWY_INLINE RowV load(const float* values) {
  const hn::Rebind<float, Row> floats;
  RowV v;
  for (std::size_t p = 0; p < parts; ++p) v[p] = hn::PromoteTo(Row(), hn::Load(floats, values + lanes * p));
  return v;
}
HWY_INLINE void store(const RowV& v, double* values) {
  for (std::size_t p = 0; p < parts; ++p) hn::Store(v[p], Row(), values + lanes * p);
}
/// s += factor v
HWY_INLINE void add(double factor, const RowV& v, RowV& s) {
  const auto all = hn::Set(Row(), factor);
  for (std::size_t p = 0; p < parts; ++p) s[p] = hn::MulAdd(all, v[p], s[p]);
}

/// result += a^T b
template <std::size_t rows>
HWY_INLINE void add_outer_product(const double* a, const double* b, double* result) {
  std::array<RowV, rows> row;
  for (std::size_t k = 0; k < rows; ++k) row[k] = load(b + row_of_six * k);
  for (std::size_t i = 0; i < 6; ++i) {
    RowV sum = load(result + row_of_six * i);
    for (std::size_t k = 0; k < rows; ++k) add(a[row_of_six * k + i], row[k], sum);
    store(sum, result + row_of_six * i);
  }
}

/// result += a b
template <std::size_t rows>
HWY_INLINE void add_transfer(const double* a, const float* b, double* result) {
  std::array<RowV, rows> sums;
  for (std::size_t i = 0; i < rows; ++i) sums[i] = load(result + row_of_six * i);
  for (std::size_t k = 0; k < 6; ++k) {
    const RowV row = load(b + row_of_six * k);
    for (std::size_t i = 0; i < rows; ++i) add(a[row_of_six * i + k], row, sums[i]);
  }
  for (std::size_t i = 0; i < rows; ++i) store(sums[i], result + row_of_six * i);
}

}  // namespace

void add_outer_products(const double* jacobians, const BlockTerm* terms, std::size_t count, double* results) {
  for (std::size_t t = 0; t < count; ++t) {
    const double* a = jacobians + three_rows * terms[t].first;
    const double* b = jacobians + three_rows * terms[t].second;
    double* result = results + six_rows * terms[t].place;
    if (terms[t].rows == 1) {
      add_outer_product<1>(a, b, result);
    } else {
      add_outer_product<3>(a, b, result);
    }
  }
}

void add_transfers(const double* first, const float* second, const BlockTerm* terms, std::size_t count,
                   double* results) {
  for (std::size_t t = 0; t < count; ++t) {
    const double* a = first + three_rows * terms[t].first;
    const float* b = second + six_rows * terms[t].second;
    double* result = results + three_rows * terms[t].place;
    if (terms[t].rows == 1) {
      add_transfer<1>(a, b, result);
    } else {
      add_transfer<3>(a, b, result);
    }
  }
}

#else

using scalar::add_outer_products;
using scalar::add_transfers;

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(add_outer_products);
HWY_EXPORT(add_transfers);

void add_outer_products(const double* jacobians, const BlockTerm* terms, std::size_t count, double* results) {
  HWY_DYNAMIC_DISPATCH(add_outer_products)(jacobians, terms, count, results);
}
void add_transfers(const double* first, const float* second, const BlockTerm* terms, std::size_t count,
                   double* results) {
  HWY_DYNAMIC_DISPATCH(add_transfers)(first, second, terms, count, results);
}

namespace scalar {

void add_outer_products(const double* jacobians, const BlockTerm* terms, std::size_t count, double* results) {
  for (std::size_t t = 0; t < count; ++t) {
    const double* a = jacobians + three_rows * terms[t].first;
    const double* b = jacobians + three_rows * terms[t].second;
    double* result = results + six_rows * terms[t].place;
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = 0; j < 6; ++j) {
        for (std::size_t k = 0; k < terms[t].rows; ++k)
          result[row_of_six * i + j] += a[row_of_six * k + i] * b[row_of_six * k + j];
      }
    }
  }
}

void add_transfers(const double* first, const float* second, const BlockTerm* terms, std::size_t count,
                   double* results) {
  for (std::size_t t = 0; t < count; ++t) {
    const double* a = first + three_rows * terms[t].first;
    const float* b = second + six_rows * terms[t].second;
    double* result = results + three_rows * terms[t].place;
    for (std::size_t i = 0; i < terms[t].rows; ++i) {
      for (std::size_t j = 0; j < 6; ++j) {
        for (std::size_t k = 0; k < 6; ++k)
          result[row_of_six * i + j] += a[row_of_six * i + k] * static_cast<double>(b[row_of_six * k + j]);
      }
    }
  }
}

}  // namespace scalar
}  // namespace palpate::simd
#endif
