#include "simd/sliced_rows.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/sliced_rows.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

#include "simd/slice_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR && !HWY_HAVE_SCALABLE

void coupling_products(const CouplingTerm* couplings, const Quad* x, Quad* products, std::size_t begin,
                       std::size_t end) {
  const hn::FixedTag<float, 4> d;
  for (std::size_t c = begin; c < end; ++c) {
    const CouplingTerm& coupling = couplings[c];
    auto sum = hn::Zero(d);
    for (std::size_t k = 0; k < 5; ++k) {
      const auto row = hn::Load(d, &x[coupling.rows[k]].x);
      sum = hn::MulAdd(hn::Set(d, coupling.coefficients[k]), row, sum);
    }
    const float* w = coupling.weights.data();
    const auto first = hn::Mul(hn::Load(d, w), hn::Broadcast<0>(sum));
    const auto second = hn::MulAdd(hn::Load(d, w + 4), hn::Broadcast<1>(sum), first);
    hn::Store(hn::MulAdd(hn::Load(d, w + 8), hn::Broadcast<2>(sum), second), d, &products[c].x);
  }
}

/// Adds the coupling terms of a slice's rows.
HWY_INLINE void add_couplings(const CouplingRows& couplings, std::size_t slice, float* y) {
  const std::int32_t* begin = couplings.begin + slice_rows * slice;
  if (begin[0] == begin[slice_rows]) return;
  const hn::FixedTag<float, 4> d;
  for (std::size_t row = 0; row < slice_rows; ++row) {
    if (begin[row] == begin[row + 1]) continue;
    auto sum = hn::Zero(d);
    for (std::int32_t e = begin[row]; e < begin[row + 1]; ++e) {
      const CouplingEntry& entry = couplings.entries[e];
      sum =
          hn::MulAdd(hn::Set(d, entry.coefficient), hn::Load(d, &couplings.products[entry.coupling].x), sum);
    }
    alignas(16) std::array<float, 4> values;
    hn::Store(sum, d, values.data());
    for (std::size_t k = 0; k < 3; ++k) y[slice_rows * k + row] += values[k];
  }
}

/// Prefetch distance in slots. It was the best of 4, 8 and 16, both for values in memory and in the
/// last-level cache.
constexpr std::size_t ahead = 4;

/// Prefetches the slot's values of some lanes. Beyond the last slot the address is never read.
HWY_INLINE void prefetch_slot(const SlicedRows& rows, std::size_t slot, std::size_t lane) {
  for (std::size_t k = 0; k < 9; ++k) hwy::Prefetch(rows.values + slot_values * slot + slice_rows * k + lane);
  hwy::Prefetch(rows.columns + slice_rows * slot + lane);
}

HWY_INLINE void multiply_slice(const SlicedRows& rows, const Quad* x, float* y, std::size_t slice,
                               std::size_t lane) {
  const Floats d;
  const QuadLanes own = load_rows_of(x + slice_rows * slice + lane);
  FloatV y0 = hn::Zero(d);
  FloatV y1 = y0;
  FloatV y2 = y0;
  const std::size_t last = rows.slot_begin[slice + 1];
  for (std::size_t slot = rows.slot_begin[slice]; slot < last; ++slot) {
    const float* values = rows.values + slot_values * slot + lane;
    prefetch_slot(rows, slot + ahead, lane);
    const QuadLanes other = load_quads(x, rows.columns + slice_rows * slot + lane);
    const FloatV u0 = hn::Sub(other.x, own.x);
    const FloatV u1 = hn::Sub(other.y, own.y);
    const FloatV u2 = hn::Sub(other.z, own.z);
    const auto entry = [&](std::size_t k) { return hn::LoadU(d, values + slice_rows * k); };
    y0 = hn::MulAdd(entry(0), u0, hn::MulAdd(entry(1), u1, hn::MulAdd(entry(2), u2, y0)));
    y1 = hn::MulAdd(entry(3), u0, hn::MulAdd(entry(4), u1, hn::MulAdd(entry(5), u2, y1)));
    y2 = hn::MulAdd(entry(6), u0, hn::MulAdd(entry(7), u1, hn::MulAdd(entry(8), u2, y2)));
  }
  const FloatV mass = hn::LoadU(d, rows.masses + slice_rows * slice + lane);
  float* place = y + slice_values * slice + lane;
  hn::StoreU(hn::MulAdd(mass, own.x, y0), d, place);
  hn::StoreU(hn::MulAdd(mass, own.y, y1), d, place + slice_rows);
  hn::StoreU(hn::MulAdd(mass, own.z, y2), d, place + 2 * slice_rows);
}

double multiply_slices(const SlicedRows& rows, const CouplingRows& couplings, const Quad* x, float* y,
                       std::size_t begin, std::size_t end) {
  const Floats d;
  Sum inner;
  for (std::size_t slice = begin; slice < end; ++slice) {
    for (std::size_t lane = 0; lane < slice_rows; lane += float_lanes)
      multiply_slice(rows, x, y, slice, lane);
    add_couplings(couplings, slice, y + slice_values * slice);
    for (std::size_t lane = 0; lane < slice_rows; lane += float_lanes) {
      const QuadLanes own = load_rows_of(x + slice_rows * slice + lane);
      const float* place = y + slice_values * slice + lane;
      const FloatV first = hn::Mul(own.x, hn::LoadU(d, place));
      const FloatV second = hn::MulAdd(own.y, hn::LoadU(d, place + slice_rows), first);
      inner.add(hn::MulAdd(own.z, hn::LoadU(d, place + 2 * slice_rows), second));
    }
  }
  return inner.total();
}

HWY_INLINE void invert_lanes(const float* blocks, float* inverses) {
  const Floats d;
  const FloatV zero = hn::Zero(d);
  const FloatV one = hn::Set(d, 1.0F);
  const auto entry = [&](std::size_t k) { return hn::LoadU(d, blocks + slice_rows * k); };
  const FloatV xx = entry(0);
  const FloatV yy = entry(1);
  const FloatV zz = entry(2);
  const auto root = [&](FloatV a) { return hn::Div(one, hn::Sqrt(a)); };
  const FloatV g00 = root(xx);
  const FloatV l10 = hn::Mul(entry(3), g00);
  const FloatV l20 = hn::Mul(entry(4), g00);
  const FloatV pivot1 = hn::NegMulAdd(l10, l10, yy);
  const FloatV g11 = root(pivot1);
  const FloatV l21 = hn::Mul(hn::NegMulAdd(l20, l10, entry(5)), g11);
  const FloatV pivot2 = hn::NegMulAdd(l21, l21, hn::NegMulAdd(l20, l20, zz));
  const FloatV g22 = root(pivot2);
  const FloatV g10 = hn::Neg(hn::Mul(l10, hn::Mul(g00, g11)));
  const FloatV g21 = hn::Neg(hn::Mul(l21, hn::Mul(g11, g22)));
  const FloatV g20 = hn::Neg(hn::Mul(hn::MulAdd(l20, g00, hn::Mul(l21, g10)), g22));
  const std::array<FloatV, 6> full{hn::MulAdd(g00, g00, hn::MulAdd(g10, g10, hn::Mul(g20, g20))),
                                   hn::MulAdd(g11, g11, hn::Mul(g21, g21)),
                                   hn::Mul(g22, g22),
                                   hn::MulAdd(g10, g11, hn::Mul(g20, g21)),
                                   hn::Mul(g20, g22),
                                   hn::Mul(g21, g22)};
  const std::array<FloatV, 6> simple{hn::Div(one, xx), hn::Div(one, yy), hn::Div(one, zz), zero, zero, zero};
  const auto good = hn::And(hn::Gt(pivot1, zero), hn::Gt(pivot2, zero));
  const auto used = hn::Gt(xx, zero);
  for (std::size_t k = 0; k < 6; ++k) {
    hn::StoreU(hn::IfThenElseZero(used, hn::IfThenElse(good, full[k], simple[k])), d,
               inverses + slice_rows * k);
  }
}

void invert_slices(const float* blocks, float* inverses, std::size_t begin, std::size_t end) {
  for (std::size_t slice = begin; slice < end; ++slice) {
    for (std::size_t lane = 0; lane < slice_rows; lane += float_lanes)
      invert_lanes(blocks + slice_symmetric * slice + lane, inverses + slice_symmetric * slice + lane);
  }
}

VectorSums advance_slices(const GradientVectors& v, float step, std::size_t begin, std::size_t end) {
  const Floats d;
  const FloatV factor = hn::Set(d, step);
  Sum rr;
  Sum by_mass;
  Sum rz;
  Sum xx;
  for (std::size_t i = begin * slice_rows; i < end * slice_rows; i += float_lanes) {
    const std::size_t slice = i / slice_rows;
    const std::size_t place = slice_values * slice + i % slice_rows;
    const auto three = [&](const float* from) {
      return std::array{hn::LoadU(d, from + place), hn::LoadU(d, from + place + slice_rows),
                        hn::LoadU(d, from + place + 2 * slice_rows)};
    };
    const QuadLanes p = load_rows_of(v.direction + i);
    const std::array<FloatV, 3> direction{p.x, p.y, p.z};
    auto x = three(v.solution);
    auto r = three(v.residual);
    const auto q = three(v.product);
    const auto guess = three(v.guess);
    FloatV r_square = hn::Zero(d);
    FloatV x_square = r_square;
    for (std::size_t k = 0; k < 3; ++k) {
      x[k] = hn::MulAdd(factor, direction[k], x[k]);
      r[k] = hn::NegMulAdd(factor, q[k], r[k]);
      hn::StoreU(x[k], d, v.solution + place + slice_rows * k);
      hn::StoreU(r[k], d, v.residual + place + slice_rows * k);
      const FloatV whole = hn::Add(guess[k], x[k]);
      r_square = hn::MulAdd(r[k], r[k], r_square);
      x_square = hn::MulAdd(whole, whole, x_square);
    }
    const float* inverse = v.inverse_diagonal + slice_symmetric * slice + i % slice_rows;
    const auto entry = [&](std::size_t k) { return hn::LoadU(d, inverse + slice_rows * k); };
    const FloatV xy = entry(3);
    const FloatV xz = entry(4);
    const FloatV yz = entry(5);
    const std::array<FloatV, 3> z{hn::MulAdd(entry(0), r[0], hn::MulAdd(xy, r[1], hn::Mul(xz, r[2]))),
                                  hn::MulAdd(xy, r[0], hn::MulAdd(entry(1), r[1], hn::Mul(yz, r[2]))),
                                  hn::MulAdd(xz, r[0], hn::MulAdd(yz, r[1], hn::Mul(entry(2), r[2])))};
    for (std::size_t k = 0; k < 3; ++k) hn::StoreU(z[k], d, v.preconditioned + place + slice_rows * k);
    rr.add(r_square);
    by_mass.add(hn::Mul(r_square, hn::LoadU(d, v.inverse_masses + i)));
    rz.add(hn::MulAdd(r[0], z[0], hn::MulAdd(r[1], z[1], hn::Mul(r[2], z[2]))));
    xx.add(hn::Mul(x_square, hn::LoadU(d, v.masses + i)));
  }
  return {rr.total(), by_mass.total(), rz.total(), xx.total()};
}

void update_directions(const GradientVectors& v, float beta, std::size_t begin, std::size_t end) {
  const Floats d;
  const FloatV factor = hn::Set(d, beta);
  for (std::size_t i = begin * slice_rows; i < end * slice_rows; i += float_lanes) {
    const float* z = v.preconditioned + slice_values * (i / slice_rows) + i % slice_rows;
    QuadLanes p = load_rows_of(v.direction + i);
    p.x = hn::MulAdd(factor, p.x, hn::LoadU(d, z));
    p.y = hn::MulAdd(factor, p.y, hn::LoadU(d, z + slice_rows));
    p.z = hn::MulAdd(factor, p.z, hn::LoadU(d, z + 2 * slice_rows));
    store_rows_of(p, v.direction + i);
  }
}

#else

using scalar::advance_slices;
using scalar::coupling_products;
using scalar::invert_slices;
using scalar::multiply_slices;
using scalar::update_directions;

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(coupling_products);
HWY_EXPORT(multiply_slices);
HWY_EXPORT(invert_slices);
HWY_EXPORT(advance_slices);
HWY_EXPORT(update_directions);

void coupling_products(const CouplingTerm* couplings, const Quad* x, Quad* products, std::size_t begin,
                       std::size_t end) {
  HWY_DYNAMIC_DISPATCH(coupling_products)(couplings, x, products, begin, end);
}
double multiply_slices(const SlicedRows& rows, const CouplingRows& couplings, const Quad* x, float* y,
                       std::size_t begin, std::size_t end) {
  return HWY_DYNAMIC_DISPATCH(multiply_slices)(rows, couplings, x, y, begin, end);
}
void invert_slices(const float* blocks, float* inverses, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(invert_slices)(blocks, inverses, begin, end);
}
VectorSums advance_slices(const GradientVectors& vectors, float step, std::size_t begin, std::size_t end) {
  return HWY_DYNAMIC_DISPATCH(advance_slices)(vectors, step, begin, end);
}
void update_directions(const GradientVectors& vectors, float beta, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(update_directions)(vectors, beta, begin, end);
}

}  // namespace palpate::simd
#endif
