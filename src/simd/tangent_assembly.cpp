#include <array>

#include "simd/sliced_rows.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/tangent_assembly.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

#include "simd/slice_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR && !HWY_HAVE_SCALABLE

using BlockLanes = std::array<FloatV, 9>;

/// Sum of the blocks of some terms, one row per lane. Each lane adds up its terms in their order.
HWY_INLINE BlockLanes sum_terms(const TangentAssembly& rows, std::size_t first, std::size_t last,
                                std::size_t lane) {
  const Floats d;
  const hn::RebindToUnsigned<Floats> du;
  const hn::FixedTag<float, 4> four;
  BlockLanes sum;
  sum.fill(hn::Zero(d));
  alignas(64) std::array<std::uint32_t, slice_rows> places;
  for (std::size_t t = first; t < last; ++t) {
    const auto term = hn::LoadU(du, rows.terms + slice_rows * t + lane);
    hn::Store(hn::ShiftRight<1>(term), du, places.data());
    const auto load_from = [&](std::size_t number) {
      return transposed([&](std::size_t i) { return hn::LoadU(four, rows.blocks + places[i] + number); });
    };
    const auto back = hn::RebindMask(d, hn::Ne(hn::And(term, hn::Set(du, 1)), hn::Zero(du)));
    const auto add = [&](std::size_t k, FloatV own, FloatV other) {
      sum[k] = hn::Add(sum[k], hn::IfThenElse(back, other, own));
    };
    const QuadLanes a = load_from(0);
    const QuadLanes b = load_from(4);
    sum[0] = hn::Add(sum[0], a.x);
    sum[4] = hn::Add(sum[4], b.x);
    sum[8] = hn::Add(sum[8], load_from(5).w);
    add(1, a.y, a.w);
    add(3, a.w, a.y);
    add(2, a.z, b.z);
    add(6, b.z, a.z);
    add(5, b.y, b.w);
    add(7, b.w, b.y);
  }
  return sum;
}

void assemble_tangent_slices(const TangentAssembly& rows, float* values, std::size_t begin, std::size_t end) {
  const Floats d;
  const std::uint32_t* terms = rows.term_begin;
  for (std::size_t slot = rows.slot_begin[begin]; slot < rows.slot_begin[end]; ++slot) {
    for (std::size_t lane = 0; lane < slice_rows; lane += float_lanes) {
      const BlockLanes sum = sum_terms(rows, terms[slot], terms[slot + 1], lane);
      float* place = values + slot_values * slot + lane;
      for (std::size_t k = 0; k < 9; ++k) hn::StoreU(sum[k], d, place + slice_rows * k);
    }
  }
}

void sum_diagonals(const std::uint32_t* slot_begin, const float* values, const float* masses,
                   float* diagonals, std::size_t begin, std::size_t end) {
  constexpr std::array<std::size_t, 6> upper{0, 4, 8, 1, 2, 5};
  const Floats d;
  for (std::size_t slice = begin; slice < end; ++slice) {
    for (std::size_t lane = 0; lane < slice_rows; lane += float_lanes) {
      std::array<FloatV, 6> sums;
      sums.fill(hn::Zero(d));
      for (std::size_t slot = slot_begin[slice]; slot < slot_begin[slice + 1]; ++slot) {
        const float* place = values + slot_values * slot + lane;
        for (std::size_t k = 0; k < 6; ++k)
          sums[k] = hn::Add(sums[k], hn::LoadU(d, place + slice_rows * upper[k]));
      }
      const FloatV mass = hn::LoadU(d, masses + slice_rows * slice + lane);
      float* place = diagonals + slice_symmetric * slice + lane;
      for (std::size_t k = 0; k < 6; ++k)
        hn::StoreU(k < 3 ? hn::Sub(mass, sums[k]) : hn::Neg(sums[k]), d, place + slice_rows * k);
    }
  }
}

#else

using scalar::assemble_tangent_slices;
using scalar::sum_diagonals;

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(assemble_tangent_slices);
HWY_EXPORT(sum_diagonals);

void assemble_tangent_slices(const TangentAssembly& rows, float* values, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(assemble_tangent_slices)(rows, values, begin, end);
}

void sum_diagonals(const std::uint32_t* slot_begin, const float* values, const float* masses,
                   float* diagonals, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(sum_diagonals)(slot_begin, values, masses, diagonals, begin, end);
}

}  // namespace palpate::simd
#endif
