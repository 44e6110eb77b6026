#include <array>

#include "simd/sliced_rows.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/slice_assembly.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

#include "simd/slice_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR && !HWY_HAVE_SCALABLE

/// Sum of a_i a_j^T; also of r a_i a_j^T if r differs between elements.
template <bool mixed>
struct TermSums {
  std::array<FloatV, 9> x;
  std::array<FloatV, mixed ? 9 : 1> scaled;
  FloatV ratio;
};

template <bool mixed>
HWY_INLINE TermSums<mixed> add_terms(const SlicedAssembly& rows, std::size_t first, std::size_t last,
                                     std::size_t lane) {
  const Floats d;
  const hn::RebindToUnsigned<Floats> du;
  const FloatV zero = hn::Zero(d);
  TermSums<mixed> sums{{zero, zero, zero, zero, zero, zero, zero, zero, zero}, {}, zero};
  if constexpr (mixed) sums.scaled = sums.x;
  alignas(64) std::array<std::uint32_t, slice_rows> own;
  alignas(64) std::array<std::uint32_t, slice_rows> other;
  for (std::size_t t = first; t < last; ++t) {
    const auto term = hn::LoadU(du, rows.terms + slice_rows * t + lane);
    const auto corner_i = hn::ShiftRight<2>(term);
    hn::Store(corner_i, du, own.data());
    hn::Store(hn::Or(hn::AndNot(hn::Set(du, 3), corner_i), hn::And(term, hn::Set(du, 3))), du, other.data());
    const QuadLanes a = load_quads(rows.gradients, own.data());
    const QuadLanes b = load_quads(rows.gradients, other.data());
    if (t == first) sums.ratio = a.w;
    const std::array<FloatV, 3> left{a.x, a.y, a.z};
    const std::array<FloatV, 3> right{b.x, b.y, b.z};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        sums.x[3 * i + j] = hn::MulAdd(left[i], right[j], sums.x[3 * i + j]);
        if constexpr (mixed)
          sums.scaled[3 * i + j] = hn::MulAdd(a.w, hn::Mul(left[i], right[j]), sums.scaled[3 * i + j]);
      }
    }
  }
  return sums;
}

/// r X + X^T + tr(X) I
template <bool mixed>
HWY_INLINE std::array<FloatV, 9> whole_blocks(const TermSums<mixed>& sums) {
  const std::array<FloatV, 9>& x = sums.x;
  const FloatV trace = hn::Add(x[0], hn::Add(x[4], x[8]));
  const auto entry = [&](std::size_t i, std::size_t j) {
    const FloatV back = i == j ? hn::Add(x[3 * i + j], trace) : x[3 * j + i];
    if constexpr (mixed) return hn::Add(sums.scaled[3 * i + j], back);
    return hn::MulAdd(sums.ratio, x[3 * i + j], back);
  };
  return {entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 0), entry(1, 1),
          entry(1, 2), entry(2, 0), entry(2, 1), entry(2, 2)};
}

/// Places of the entries xx, yy, zz, xy, xz, yz in a block.
constexpr std::array<std::size_t, 6> upper{0, 4, 8, 1, 2, 5};
using Sums = std::array<FloatV, 6>;

template <bool mixed>
HWY_INLINE void assemble_slice(const SlicedAssembly& rows, float* values, float* diagonals,
                               std::size_t slice) {
  const Floats d;
  const std::size_t first = rows.slot_begin[slice];
  const std::size_t last = rows.slot_begin[slice + 1];
  const std::uint32_t* begin = rows.term_begin;
  std::array<Sums, slice_rows / float_lanes> sums;
  for (Sums& sum : sums) sum.fill(hn::Zero(d));
  for (std::size_t slot = first; slot < last; ++slot) {
    for (std::size_t lane = 0; lane < slice_rows; lane += float_lanes) {
      const auto block = whole_blocks(add_terms<mixed>(rows, begin[slot], begin[slot + 1], lane));
      float* place = values + slot_values * slot + lane;
      for (std::size_t k = 0; k < 9; ++k) hn::StoreU(block[k], d, place + slice_rows * k);
      Sums& sum = sums[lane / float_lanes];
      for (std::size_t k = 0; k < 6; ++k) sum[k] = hn::Add(sum[k], block[upper[k]]);
    }
  }
  for (std::size_t lane = 0; lane < slice_rows; lane += float_lanes) {
    const Sums& sum = sums[lane / float_lanes];
    const FloatV mass = hn::LoadU(d, rows.masses + slice_rows * slice + lane);
    float* place = diagonals + slice_symmetric * slice + lane;
    for (std::size_t k = 0; k < 3; ++k) hn::StoreU(hn::Sub(mass, sum[k]), d, place + slice_rows * k);
    for (std::size_t k = 3; k < 6; ++k) hn::StoreU(hn::Neg(sum[k]), d, place + slice_rows * k);
  }
}

void assemble_slices(const SlicedAssembly& rows, float* values, float* diagonals, std::size_t begin,
                     std::size_t end) {
  for (std::size_t slice = begin; slice < end; ++slice) {
    if (rows.mixed) {
      assemble_slice<true>(rows, values, diagonals, slice);
    } else {
      assemble_slice<false>(rows, values, diagonals, slice);
    }
  }
}

#else

using scalar::assemble_slices;

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(assemble_slices);

void assemble_slices(const SlicedAssembly& rows, float* values, float* diagonals, std::size_t begin,
                     std::size_t end) {
  HWY_DYNAMIC_DISPATCH(assemble_slices)(rows, values, diagonals, begin, end);
}

}  // namespace palpate::simd
#endif
