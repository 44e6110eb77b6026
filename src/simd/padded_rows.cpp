#include "simd/padded_rows.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/padded_rows.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own header after foreach_target.h.
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
/// A vector of six: each value in a lane of its own, however many vectors that takes.
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

/// s += block x, or s -= block x, of so many columns.
template <bool subtract, std::size_t columns>
HWY_INLINE void add_block(SixV& s, const float* block, const float* x) {
  const Eight d;
  for (std::size_t k = 0; k < columns; ++k) {
    const EightV factor = hn::Set(d, x[k]);
    for (std::size_t p = 0; p < parts; ++p) {
      const EightV column = hn::Load(d, block + 8 * k + lanes * p);
      s[p] = subtract ? hn::NegMulAdd(column, factor, s[p]) : hn::MulAdd(column, factor, s[p]);
    }
  }
}

template <bool subtract>
HWY_INLINE void add_row(SixV& s, const PaddedRows& a, const Six* x, std::size_t first, std::size_t last) {
  for (std::size_t k = first; k < last; ++k)
    add_block<subtract, 6>(s, a.blocks + six_by_six * k, x[a.columns[k]].values.data());
}

/// The blocks of a row with columns in [low, high).
template <class Body>
HWY_INLINE void for_columns(const PaddedRows& a, std::size_t row, std::size_t low, std::size_t high,
                            Body&& body) {
  for (std::size_t k = a.begin[row]; k < a.begin[row + 1]; ++k) {
    const std::size_t column = a.columns[k];
    if (column >= low && column < high) body(k);
  }
}

HWY_INLINE void subtract_columns(SixV& s, const SixMatrix& a, const Six* x, std::size_t row, std::size_t low,
                                 std::size_t high) {
  for (const PaddedRows* part : {&a.first, &a.second}) {
    for_columns(*part, row, low, high, [&](std::size_t k) {
      add_block<true, 6>(s, part->blocks + six_by_six * k, x[part->columns[k]].values.data());
    });
  }
}

HWY_INLINE void relax_row(const SixMatrix& a, const SixV& s, Six* x, std::size_t row) {
  Six right;
  store(s, right.values.data());
  SixV result = zero();
  add_block<false, 6>(result, a.inverses + six_by_six * row, right.values.data());
  store(result, x[row].values.data());
}

#endif

}  // namespace

#if HWY_TARGET != HWY_SCALAR && !HWY_HAVE_SCALABLE

void gather_points(const PaddedRows& a, const Quad* x, Six* y, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    SixV s = zero();
    for (std::size_t k = a.begin[row]; k < a.begin[row + 1]; ++k)
      add_block<false, 3>(s, a.blocks + six_by_three * k, &x[a.columns[k]].x);
    store(s, y[row].values.data());
  }
}

void spread_to_points(const PaddedRows& a, const Six* x, Quad* y, std::size_t begin, std::size_t end) {
  const hn::FixedTag<float, 4> d;
  for (std::size_t row = begin; row < end; ++row) {
    auto s = hn::Zero(d);
    for (std::size_t k = a.begin[row]; k < a.begin[row + 1]; ++k) {
      const float* block = a.blocks + three_by_six * k;
      const Six& v = x[a.columns[k]];
      for (std::size_t c = 0; c < 6; ++c)
        s = hn::MulAdd(hn::Load(d, block + 4 * c), hn::Set(d, v.values[c]), s);
    }
    hn::Store(s, d, &y[row].x);
  }
}

void multiply_six(const PaddedRows& a, const Six* x, Six* y, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    SixV s = zero();
    add_row<false>(s, a, x, a.begin[row], a.begin[row + 1]);
    store(s, y[row].values.data());
  }
}

void add_six(const PaddedRows& a, const Six* x, Six* y, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    SixV s = load(y[row].values.data());
    add_row<false>(s, a, x, a.begin[row], a.begin[row + 1]);
    store(s, y[row].values.data());
  }
}

void relax_forward(const SixMatrix& a, const Six* b, Six* x, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    SixV s = load(b[row].values.data());
    subtract_columns(s, a, x, row, begin, row);
    relax_row(a, s, x, row);
  }
}

void relax_backward(const SixMatrix& a, const Six* b, Six* x, std::size_t begin, std::size_t end) {
  for (std::size_t row = end; row-- > begin;) {
    SixV s = load(b[row].values.data());
    subtract_columns(s, a, x, row, begin, end);
    relax_row(a, s, x, row);
  }
}

void residual_above(const SixMatrix& a, const Six* x, Six* r, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    SixV s = zero();
    subtract_columns(s, a, x, row, row, ~std::size_t{0});
    store(s, r[row].values.data());
  }
}

#else

using scalar::add_six;
using scalar::gather_points;
using scalar::multiply_six;
using scalar::relax_backward;
using scalar::relax_forward;
using scalar::residual_above;
using scalar::spread_to_points;

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(gather_points);
HWY_EXPORT(spread_to_points);
HWY_EXPORT(multiply_six);
HWY_EXPORT(add_six);
HWY_EXPORT(relax_forward);
HWY_EXPORT(relax_backward);
HWY_EXPORT(residual_above);

void gather_points(const PaddedRows& a, const Quad* x, Six* y, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(gather_points)(a, x, y, begin, end);
}
void spread_to_points(const PaddedRows& a, const Six* x, Quad* y, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(spread_to_points)(a, x, y, begin, end);
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
void residual_above(const SixMatrix& a, const Six* x, Six* r, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(residual_above)(a, x, r, begin, end);
}

}  // namespace palpate::simd
#endif
