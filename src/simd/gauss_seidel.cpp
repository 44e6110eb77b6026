#include "simd/gauss_seidel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/gauss_seidel.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

#include "simd/slice_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR && !HWY_HAVE_SCALABLE

using Four = hn::FixedTag<float, 4>;
using Three = std::array<FloatV, 3>;
using Matrix = std::array<FloatV, 9>;

/// Subtracts the coupling terms of a slice's rows.
HWY_INLINE void set_couplings(const CouplingRows& couplings, std::size_t slice, float* y) {
  const std::int32_t* begin = couplings.begin + slice_rows * slice;
  if (begin[0] == begin[slice_rows]) return;
  const Four d;
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
    for (std::size_t k = 0; k < 3; ++k) y[slice_rows * k + row] -= values[k];
  }
}

/// r - A z of a slice, where A acts on differences (SlicedRows).
HWY_INLINE void residual_of_slice(const SmootherRows& all, const float* r, const Quad* z, std::size_t slice,
                                  float* y) {
  const Floats d;
  const SlicedRows& rows = all.rows;
  constexpr std::size_t ahead = 4;
  for (std::size_t lane = 0; lane < slice_rows; lane += float_lanes) {
    const QuadLanes own = load_rows_of(z + slice_rows * slice + lane);
    const float* from = r + slice_values * slice + lane;
    const FloatV mass = hn::LoadU(d, rows.masses + slice_rows * slice + lane);
    FloatV y0 = hn::NegMulAdd(mass, own.x, hn::LoadU(d, from));
    FloatV y1 = hn::NegMulAdd(mass, own.y, hn::LoadU(d, from + slice_rows));
    FloatV y2 = hn::NegMulAdd(mass, own.z, hn::LoadU(d, from + 2 * slice_rows));
    const std::size_t last = rows.slot_begin[slice + 1];
    for (std::size_t slot = rows.slot_begin[slice]; slot < last; ++slot) {
      const float* values = rows.values + slot_values * slot + lane;
      for (std::size_t k = 0; k < 9; ++k) hwy::Prefetch(values + slot_values * ahead + slice_rows * k);
      const QuadLanes other = load_quads(z, rows.columns + slice_rows * slot + lane);
      const FloatV u0 = hn::Sub(own.x, other.x);
      const FloatV u1 = hn::Sub(own.y, other.y);
      const FloatV u2 = hn::Sub(own.z, other.z);
      const auto entry = [&](std::size_t k) { return hn::LoadU(d, values + slice_rows * k); };
      y0 = hn::MulAdd(entry(0), u0, hn::MulAdd(entry(1), u1, hn::MulAdd(entry(2), u2, y0)));
      y1 = hn::MulAdd(entry(3), u0, hn::MulAdd(entry(4), u1, hn::MulAdd(entry(5), u2, y1)));
      y2 = hn::MulAdd(entry(6), u0, hn::MulAdd(entry(7), u1, hn::MulAdd(entry(8), u2, y2)));
    }
    hn::Store(y0, d, y + lane);
    hn::Store(y1, d, y + slice_rows + lane);
    hn::Store(y2, d, y + 2 * slice_rows + lane);
  }
  set_couplings(all.couplings, slice, y);
}

HWY_INLINE Three load_three(const float* values) {
  const Floats d;
  return {hn::LoadU(d, values), hn::LoadU(d, values + slice_rows), hn::LoadU(d, values + 2 * slice_rows)};
}
HWY_INLINE void store_three(const Three& v, float* values) {
  const Floats d;
  for (std::size_t k = 0; k < 3; ++k) hn::StoreU(v[k], d, values + slice_rows * k);
}

/// y -= K z for one slot of a slice.
HWY_INLINE void subtract_slot(const SlicedRows& rows, const QuadLanes& z, std::size_t slot, std::size_t lane,
                              Three& y) {
  constexpr std::size_t ahead = 4;
  const Floats d;
  const float* values = rows.values + slot_values * slot + lane;
  for (std::size_t k = 0; k < 9; ++k) hwy::Prefetch(values + slot_values * ahead + slice_rows * k);
  const auto entry = [&](std::size_t k) { return hn::LoadU(d, values + slice_rows * k); };
  for (std::size_t i = 0; i < 3; ++i) {
    y[i] = hn::NegMulAdd(entry(3 * i), z.x,
                         hn::NegMulAdd(entry(3 * i + 1), z.y, hn::NegMulAdd(entry(3 * i + 2), z.z, y[i])));
  }
}

/// y minus the part of A z from earlier colours. Later rows of z are zero.
HWY_INLINE void subtract_earlier(const SlicedRows& rows, const Quad* z, std::size_t slice, std::size_t lane,
                                 Three& y) {
  for (std::size_t slot = rows.slot_begin[slice]; slot < rows.halves[slice].last_earlier; ++slot)
    subtract_slot(rows, load_quads(z, rows.columns + slice_rows * slot + lane), slot, lane, y);
}

/// y minus the part of A z from later colours.
HWY_INLINE void subtract_later(const SlicedRows& rows, const Quad* z, std::size_t slice, std::size_t lane,
                               Three& y) {
  const hn::RebindToSigned<Floats> integers;
  const SliceHalves& halves = rows.halves[slice];
  const auto first = hn::Set(integers, static_cast<std::int32_t>(halves.color_begin));
  const std::size_t last = rows.slot_begin[slice + 1];
  for (std::size_t slot = halves.first_later; slot < last; ++slot) {
    const std::uint32_t* columns = rows.columns + slice_rows * slot + lane;
    QuadLanes other = load_quads(z, columns);
    if (slot < halves.last_earlier) {
      const auto places = hn::LoadU(integers, reinterpret_cast<const std::int32_t*>(columns));
      const auto earlier = hn::RebindMask(Floats(), hn::Lt(places, first));
      other.x = hn::IfThenZeroElse(earlier, other.x);
      other.y = hn::IfThenZeroElse(earlier, other.y);
      other.z = hn::IfThenZeroElse(earlier, other.z);
    }
    subtract_slot(rows, other, slot, lane, y);
  }
}

HWY_INLINE bool has_couplings(const CouplingRows& couplings, std::size_t slice) {
  return couplings.begin[slice_rows * slice] != couplings.begin[slice_rows * (slice + 1)];
}

/// start + A v with a symmetric matrix for each row.
HWY_INLINE Three add_symmetric(const float* matrix, const Three& v, const Three& start) {
  const Floats d;
  const auto entry = [&](std::size_t k) { return hn::LoadU(d, matrix + slice_rows * k); };
  const FloatV xy = entry(3);
  const FloatV xz = entry(4);
  const FloatV yz = entry(5);
  return {hn::MulAdd(entry(0), v[0], hn::MulAdd(xy, v[1], hn::MulAdd(xz, v[2], start[0]))),
          hn::MulAdd(xy, v[0], hn::MulAdd(entry(1), v[1], hn::MulAdd(yz, v[2], start[1]))),
          hn::MulAdd(xz, v[0], hn::MulAdd(yz, v[1], hn::MulAdd(entry(2), v[2], start[2])))};
}

void relax_slices(const SmootherRows& rows, const float* r, Quad* z, const std::uint32_t* slices,
                  std::size_t count) {
  alignas(64) std::array<float, slice_values> y;
  for (std::size_t s = 0; s < count; ++s) {
    const std::size_t slice = slices[s];
    residual_of_slice(rows, r, z, slice, y.data());
    for (std::size_t lane = 0; lane < slice_rows; lane += float_lanes) {
      Quad* place = z + slice_rows * slice + lane;
      const QuadLanes own = load_rows_of(place);
      const Three sum = add_symmetric(rows.inverses + slice_symmetric * slice + lane,
                                      load_three(y.data() + lane), {own.x, own.y, own.z});
      store_rows_of({sum[0], sum[1], sum[2], hn::Zero(Floats())}, place);
    }
  }
}

void relax_from_zero(const SmootherRows& rows, const float* r, Quad* z, float* rest,
                     const std::uint32_t* slices, std::size_t count) {
  const FloatV zero = hn::Zero(Floats());
  alignas(64) std::array<float, slice_values> y;
  for (std::size_t s = 0; s < count; ++s) {
    const std::size_t slice = slices[s];
    const bool coupled = has_couplings(rows.couplings, slice);
    for (std::size_t lane = 0; lane < slice_rows; lane += float_lanes) {
      Three v = load_three(r + slice_values * slice + lane);
      subtract_earlier(rows.rows, z, slice, lane, v);
      store_three(v, y.data() + lane);
      if (coupled) store_three(v, rest + slice_values * slice + lane);
    }
    set_couplings(rows.couplings, slice, y.data());
    for (std::size_t lane = 0; lane < slice_rows; lane += float_lanes) {
      const Three sum = add_symmetric(rows.inverses + slice_symmetric * slice + lane,
                                      load_three(y.data() + lane), {zero, zero, zero});
      store_rows_of({sum[0], sum[1], sum[2], zero}, z + slice_rows * slice + lane);
    }
  }
}

HWY_INLINE Matrix load_rotation(const SmootherRows& rows, std::size_t slice, std::size_t lane) {
  const Floats d;
  Matrix m;
  for (std::size_t k = 0; k < 9; ++k)
    m[k] = hn::LoadU(d, rows.rotations + slot_values * slice + slice_rows * k + lane);
  return m;
}

void rotated_residual(const SmootherRows& rows, const float* rest, const Quad* z, Quad* t, std::size_t begin,
                      std::size_t end) {
  const FloatV zero = hn::Zero(Floats());
  alignas(64) std::array<float, slice_values> y;
  for (std::size_t slice = begin; slice < end; ++slice) {
    const bool coupled = has_couplings(rows.couplings, slice);
    for (std::size_t lane = 0; lane < slice_rows; lane += float_lanes) {
      Three v{zero, zero, zero};
      if (coupled) {
        const QuadLanes own = load_rows_of(z + slice_rows * slice + lane);
        v = add_symmetric(rows.diagonals + slice_symmetric * slice + lane,
                          {hn::Neg(own.x), hn::Neg(own.y), hn::Neg(own.z)},
                          load_three(rest + slice_values * slice + lane));
      }
      subtract_later(rows.rows, z, slice, lane, v);
      store_three(v, y.data() + lane);
    }
    set_couplings(rows.couplings, slice, y.data());
    for (std::size_t lane = 0; lane < slice_rows; lane += float_lanes) {
      const Three v = load_three(y.data() + lane);
      const Matrix m = load_rotation(rows, slice, lane);
      const auto entry = [&](std::size_t k) {
        return hn::MulAdd(m[k], v[0], hn::MulAdd(m[k + 3], v[1], hn::Mul(m[k + 6], v[2])));
      };
      store_rows_of({entry(0), entry(1), entry(2), hn::Zero(Floats())}, t + slice_rows * slice + lane);
    }
  }
}

void add_rotated(const SmootherRows& rows, const Quad* u, Quad* z, std::size_t begin, std::size_t end) {
  for (std::size_t slice = begin; slice < end; ++slice) {
    for (std::size_t lane = 0; lane < slice_rows; lane += float_lanes) {
      const Matrix m = load_rotation(rows, slice, lane);
      const QuadLanes v = load_rows_of(u + slice_rows * slice + lane);
      Quad* place = z + slice_rows * slice + lane;
      QuadLanes own = load_rows_of(place);
      own.x = hn::MulAdd(m[0], v.x, hn::MulAdd(m[1], v.y, hn::MulAdd(m[2], v.z, own.x)));
      own.y = hn::MulAdd(m[3], v.x, hn::MulAdd(m[4], v.y, hn::MulAdd(m[5], v.z, own.y)));
      own.z = hn::MulAdd(m[6], v.x, hn::MulAdd(m[7], v.y, hn::MulAdd(m[8], v.z, own.z)));
      store_rows_of(own, place);
    }
  }
}

double store_slices(const Quad* z, const float* r, float* values, std::size_t begin, std::size_t end) {
  const Floats d;
  Sum inner;
  for (std::size_t slice = begin; slice < end; ++slice) {
    for (std::size_t lane = 0; lane < slice_rows; lane += float_lanes) {
      const QuadLanes own = load_rows_of(z + slice_rows * slice + lane);
      const std::size_t place = slice_values * slice + lane;
      const Three v = load_three(r + place);
      hn::StoreU(own.x, d, values + place);
      hn::StoreU(own.y, d, values + place + slice_rows);
      hn::StoreU(own.z, d, values + place + 2 * slice_rows);
      inner.add(hn::MulAdd(v[0], own.x, hn::MulAdd(v[1], own.y, hn::Mul(v[2], own.z))));
    }
  }
  return inner.total();
}

void listed_products(const CouplingTerm* couplings, const Quad* x, Quad* products, const std::uint32_t* list,
                     std::size_t count) {
  const Four d;
  for (std::size_t i = 0; i < count; ++i) {
    const CouplingTerm& coupling = couplings[list[i]];
    auto sum = hn::Zero(d);
    for (std::size_t k = 0; k < 5; ++k) {
      const auto row = hn::Load(d, &x[coupling.rows[k]].x);
      sum = hn::MulAdd(hn::Set(d, coupling.coefficients[k]), row, sum);
    }
    const float* w = coupling.weights.data();
    const auto first = hn::Mul(hn::Load(d, w), hn::Broadcast<0>(sum));
    const auto second = hn::MulAdd(hn::Load(d, w + 4), hn::Broadcast<1>(sum), first);
    hn::Store(hn::MulAdd(hn::Load(d, w + 8), hn::Broadcast<2>(sum), second), d, &products[list[i]].x);
  }
}

#else

using scalar::add_rotated;
using scalar::listed_products;
using scalar::relax_from_zero;
using scalar::relax_slices;
using scalar::rotated_residual;
using scalar::store_slices;

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(relax_slices);
HWY_EXPORT(relax_from_zero);
HWY_EXPORT(rotated_residual);
HWY_EXPORT(add_rotated);
HWY_EXPORT(store_slices);
HWY_EXPORT(listed_products);

void relax_slices(const SmootherRows& rows, const float* r, Quad* z, const std::uint32_t* slices,
                  std::size_t count) {
  HWY_DYNAMIC_DISPATCH(relax_slices)(rows, r, z, slices, count);
}
void relax_from_zero(const SmootherRows& rows, const float* r, Quad* z, float* rest,
                     const std::uint32_t* slices, std::size_t count) {
  HWY_DYNAMIC_DISPATCH(relax_from_zero)(rows, r, z, rest, slices, count);
}
void rotated_residual(const SmootherRows& rows, const float* rest, const Quad* z, Quad* t, std::size_t begin,
                      std::size_t end) {
  HWY_DYNAMIC_DISPATCH(rotated_residual)(rows, rest, z, t, begin, end);
}
void add_rotated(const SmootherRows& rows, const Quad* u, Quad* z, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(add_rotated)(rows, u, z, begin, end);
}
double store_slices(const Quad* z, const float* r, float* values, std::size_t begin, std::size_t end) {
  return HWY_DYNAMIC_DISPATCH(store_slices)(z, r, values, begin, end);
}
void listed_products(const CouplingTerm* couplings, const Quad* x, Quad* products, const std::uint32_t* list,
                     std::size_t count) {
  HWY_DYNAMIC_DISPATCH(listed_products)(couplings, x, products, list, count);
}

}  // namespace palpate::simd
#endif
