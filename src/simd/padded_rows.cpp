#include "simd/padded_rows.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/padded_rows.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET != HWY_SCALAR && !HWY_HAVE_SCALABLE

using Eight = hn::CappedTag<float, 8>;
using EightV = hn::Vec<Eight>;
constexpr std::size_t lanes = hn::MaxLanes(Eight());
constexpr std::size_t parts = 8 / lanes;
/// A vector of six with one value per lane, in as many SIMD vectors as needed.
using SixV = std::array<EightV, parts>;

HWY_INLINE SixV load(const float* values) {
  SixV v;
  for (std::size_t p = 0; p < parts; ++p) v[p] = hn::Load(Eight(), values + lanes * p);
  return v;
}
HWY_INLINE void store(const SixV& v, float* values) {
  for (std::size_t p = 0; p < parts; ++p) hn::Store(v[p], Eight(), values + lanes * p);
}
HWY_INLINE SixV zero() {
  SixV v;
  v.fill(hn::Zero(Eight()));
  return v;
}

/// A sum of products in three parts, so that additions do not wait for each other.
struct Sums {
  std::array<SixV, 3> part;
  HWY_INLINE Sums() {
    for (SixV& sum : part) sum = zero();
  }

  /// Adds the product of a block of `columns` columns and x, of which four or eight numbers are read.
  template <std::size_t columns>
  HWY_INLINE void add(const float* block, const float* x) {
    const Eight d;
    // Shuffles within 128 bits take less time than others, and than loads of single numbers.
    const EightV first = hn::LoadDup128(d, x);
    add_column<0>(block, hn::Broadcast<0>(first));
    add_column<1>(block, hn::Broadcast<1>(first));
    add_column<2>(block, hn::Broadcast<2>(first));
    if constexpr (columns == 6) {
      const EightV last = hn::LoadDup128(d, x + 4);
      add_column<3>(block, hn::Broadcast<3>(first));
      add_column<4>(block, hn::Broadcast<0>(last));
      add_column<5>(block, hn::Broadcast<1>(last));
    }
  }
  template <std::size_t k>
  HWY_INLINE void add_column(const float* block, EightV factor) {
    for (std::size_t p = 0; p < parts; ++p)
      part[k % 3][p] = hn::MulAdd(hn::Load(Eight(), block + 8 * k + lanes * p), factor, part[k % 3][p]);
  }
  [[nodiscard]] HWY_INLINE SixV total() const {
    SixV sum;
    for (std::size_t p = 0; p < parts; ++p) sum[p] = hn::Add(hn::Add(part[0][p], part[1][p]), part[2][p]);
    return sum;
  }
};

HWY_INLINE SixV row_product(const PaddedRows& a, const Six* x, std::size_t row) {
  Sums sums;
  for (std::size_t k = a.begin[row]; k < a.begin[row + 1]; ++k)
    sums.add<6>(a.blocks + six_by_six * k, x[a.columns[k]].values.data());
  return sums.total();
}

HWY_INLINE SixV sum_of(const SixV& a, const SixV& b) {
  SixV sum;
  for (std::size_t p = 0; p < parts; ++p) sum[p] = hn::Add(a[p], b[p]);
  return sum;
}
HWY_INLINE SixV difference_of(const SixV& a, const SixV& b) {
  SixV difference;
  for (std::size_t p = 0; p < parts; ++p) difference[p] = hn::Sub(a[p], b[p]);
  return difference;
}

/// Adds the product of columns 2 c and 2 c + 1 of four values each.
/// \param values  numbers 0 to 3 of x in each 128 bits, or 4 to 7
/// \param pair    bytes of the two numbers within 128 bits, four times each
template <class Bytes>
HWY_INLINE void add_pair(const float* columns, const float* x, std::size_t c, EightV values, Bytes pair,
                         SixV& sum) {
  const Eight d;
  if constexpr (parts == 1) {
    const hn::Repartition<std::uint8_t, Eight> bytes;
    const EightV factors = hn::BitCast(d, hn::TableLookupBytes(hn::BitCast(bytes, values), pair));
    sum[0] = hn::MulAdd(hn::Load(d, columns), factors, sum[0]);
  } else {
    for (std::size_t p = 0; p < parts; ++p)
      sum[p] = hn::MulAdd(hn::Load(d, columns + lanes * p), hn::Set(d, x[2 * c + p]), sum[p]);
  }
}
/// For add_pair(): numbers 2 k and 2 k + 1.
HWY_INLINE auto bytes_of_pair(std::size_t k) {
  const hn::Repartition<std::uint8_t, Eight> bytes;
  alignas(32) std::array<std::uint8_t, 32> places;
  for (std::size_t i = 0; i < 32; ++i) places[i] = static_cast<std::uint8_t>(4 * (2 * k + i / 16) + i % 4);
  return hn::Load(bytes, places.data());
}

/// The product of those blocks of a row whose columns are in [low, high).
HWY_INLINE SixV columns_product(const SixMatrix& a, const Six* x, std::size_t row, std::size_t low,
                                std::size_t high) {
  Sums sums;
  for (const PaddedRows* part : {&a.first, &a.second}) {
    for (std::size_t k = part->begin[row]; k < part->begin[row + 1]; ++k) {
      const std::size_t column = part->columns[k];
      if (column >= low && column < high) sums.add<6>(part->blocks + six_by_six * k, x[column].values.data());
    }
  }
  return sums.total();
}

HWY_INLINE void relax_row(const SixMatrix& a, const SixV& right, Six* x, std::size_t row) {
  Six values;
  store(right, values.values.data());
  Sums sums;
  sums.add<6>(a.inverses + six_by_six * row, values.values.data());
  store(sums.total(), x[row].values.data());
}

#endif

}  // namespace

#if HWY_TARGET != HWY_SCALAR && !HWY_HAVE_SCALABLE

void multiply_six_by_three(const PaddedRows& a, const Quad* x, Six* y, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    Sums sums;
    for (std::size_t k = a.begin[row]; k < a.begin[row + 1]; ++k)
      sums.add<3>(a.blocks + six_by_three * k, &x[a.columns[k]].x);
    store(sums.total(), y[row].values.data());
  }
}

void multiply_three_by_six(const PaddedRows& a, const Six* x, Quad* y, std::size_t begin, std::size_t end) {
  // Two columns of four values in a vector of eight.
  const hn::FixedTag<float, 4> four;
  const auto lower = bytes_of_pair(0);
  const auto upper = bytes_of_pair(1);
  for (std::size_t row = begin; row < end; ++row) {
    std::array sums{zero(), zero(), zero()};
    for (std::size_t k = a.begin[row]; k < a.begin[row + 1]; ++k) {
      const float* block = a.blocks + three_by_six * k;
      const float* v = x[a.columns[k]].values.data();
      const EightV first = hn::LoadDup128(Eight(), v);
      add_pair(block, v, 0, first, lower, sums[0]);
      add_pair(block + 8, v, 1, first, upper, sums[1]);
      add_pair(block + 16, v, 2, hn::LoadDup128(Eight(), v + 4), lower, sums[2]);
    }
    Six values;
    store(sum_of(sum_of(sums[0], sums[1]), sums[2]), values.values.data());
    hn::Store(hn::Add(hn::Load(four, values.values.data()), hn::Load(four, values.values.data() + 4)), four,
              &y[row].x);
  }
}

void multiply_six(const PaddedRows& a, const Six* x, Six* y, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) store(row_product(a, x, row), y[row].values.data());
}

void add_six(const PaddedRows& a, const Six* x, Six* y, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row)
    store(sum_of(load(y[row].values.data()), row_product(a, x, row)), y[row].values.data());
}

void relax_forward(const SixMatrix& a, const Six* b, Six* x, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    const SixV known = columns_product(a, x, row, begin, row);
    relax_row(a, difference_of(load(b[row].values.data()), known), x, row);
  }
}

void relax_forward_from(const SixMatrix& a, const Six* b, Six* x, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    const SixV known = columns_product(a, x, row, begin, end);
    relax_row(a, difference_of(load(b[row].values.data()), known), x, row);
  }
}

void relax_backward(const SixMatrix& a, const Six* b, Six* x, std::size_t begin, std::size_t end) {
  for (std::size_t row = end; row-- > begin;) {
    const SixV known = columns_product(a, x, row, begin, end);
    relax_row(a, difference_of(load(b[row].values.data()), known), x, row);
  }
}

void residual_above(const SixMatrix& a, const Six* x, Six* r, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    const SixV later = columns_product(a, x, row, row, ~std::size_t{0});
    store(difference_of(zero(), later), r[row].values.data());
  }
}

#else

using scalar::add_six;
using scalar::multiply_six;
using scalar::multiply_six_by_three;
using scalar::multiply_three_by_six;
using scalar::relax_backward;
using scalar::relax_forward;
using scalar::relax_forward_from;
using scalar::residual_above;

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(multiply_six_by_three);
HWY_EXPORT(multiply_three_by_six);
HWY_EXPORT(multiply_six);
HWY_EXPORT(add_six);
HWY_EXPORT(relax_forward);
HWY_EXPORT(relax_backward);
HWY_EXPORT(relax_forward_from);
HWY_EXPORT(residual_above);

void multiply_six_by_three(const PaddedRows& a, const Quad* x, Six* y, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(multiply_six_by_three)(a, x, y, begin, end);
}
void multiply_three_by_six(const PaddedRows& a, const Six* x, Quad* y, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(multiply_three_by_six)(a, x, y, begin, end);
}
void multiply_six(const PaddedRows& a, const Six* x, Six* y, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(multiply_six)(a, x, y, begin, end);
}
void add_six(const PaddedRows& a, const Six* x, Six* y, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(add_six)(a, x, y, begin, end);
}
void relax_forward(const SixMatrix& a, const Six* b, Six* x, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(relax_forward)(a, b, x, begin, end);
}
void relax_backward(const SixMatrix& a, const Six* b, Six* x, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(relax_backward)(a, b, x, begin, end);
}
void relax_forward_from(const SixMatrix& a, const Six* b, Six* x, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(relax_forward_from)(a, b, x, begin, end);
}
void residual_above(const SixMatrix& a, const Six* x, Six* r, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(residual_above)(a, x, r, begin, end);
}

}  // namespace palpate::simd
#endif
