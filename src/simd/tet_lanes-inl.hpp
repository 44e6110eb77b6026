// Vectors and matrices of tets, one tet per lane, and the conversion from and to rows of four in memory.
// Included once for each target.
#if defined(PALPATE_SIMD_TET_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_SIMD_TET_LANES_INL
#undef PALPATE_SIMD_TET_LANES_INL
#else
#define PALPATE_SIMD_TET_LANES_INL
#endif

#include <cstddef>
#include <cstdint>
#include <hwy/highway.h>

#include "simd/padded.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE

using D = hn::CappedTag<double, 8>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
using Four = hn::FixedTag<double, 4>;
constexpr std::size_t lanes = hn::MaxLanes(D());

struct Vec3V {
  V x, y, z;
};
/// Row by row.
struct Matrix3V {
  Vec3V a, b, c;
};

HWY_INLINE V dot(const Vec3V& a, const Vec3V& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE Vec3V cross(const Vec3V& a, const Vec3V& b) {
  return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
          hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}
HWY_INLINE Vec3V minus(const Vec3V& a, const Vec3V& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Vec3V plus(const Vec3V& a, const Vec3V& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Vec3V times(V s, const Vec3V& a) {
  return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)};
}
/// s a + b
HWY_INLINE Vec3V times_plus(V s, const Vec3V& a, const Vec3V& b) {
  return {hn::MulAdd(s, a.x, b.x), hn::MulAdd(s, a.y, b.y), hn::MulAdd(s, a.z, b.z)};
}
HWY_INLINE Vec3V negative(const Vec3V& a) {
  return {hn::Neg(a.x), hn::Neg(a.y), hn::Neg(a.z)};
}
HWY_INLINE V inner(const Matrix3V& m, const Matrix3V& n) {
  return hn::Add(dot(m.a, n.a), hn::Add(dot(m.b, n.b), dot(m.c, n.c)));
}
HWY_INLINE Vec3V product(const Matrix3V& m, const Vec3V& v) {
  return {dot(m.a, v), dot(m.b, v), dot(m.c, v)};
}
HWY_INLINE Matrix3V cofactors(const Matrix3V& m) {
  return {cross(m.b, m.c), cross(m.c, m.a), cross(m.a, m.b)};
}

/// Four values of each element.
struct FourV {
  V x, y, z, w;
};

/// Row k of the result is lane k of the four vectors. With eight lanes each vector has rows k and k + 4, one
/// in each half.
HWY_INLINE FourV transposed(V v0, V v1, V v2, V v3) {
  const D d;
  const V xz01 = hn::InterleaveLower(d, v0, v1);
  const V yw01 = hn::InterleaveUpper(d, v0, v1);
  const V xz23 = hn::InterleaveLower(d, v2, v3);
  const V yw23 = hn::InterleaveUpper(d, v2, v3);
  return {hn::OddEvenBlocks(hn::SwapAdjacentBlocks(xz23), xz01),
          hn::OddEvenBlocks(hn::SwapAdjacentBlocks(yw23), yw01),
          hn::OddEvenBlocks(xz23, hn::SwapAdjacentBlocks(xz01)),
          hn::OddEvenBlocks(yw23, hn::SwapAdjacentBlocks(yw01))};
}

/// Four floats of each element, `stride` floats apart, in double.
HWY_INLINE FourV load_float_fours(const float* from, std::size_t stride) {
  const auto load = [&](std::size_t k) {
    const hn::FixedTag<float, 4> four;
    const auto first = hn::PromoteTo(Four(), hn::Load(four, from + stride * k));
#if HWY_MAX_BYTES >= 64
    return hn::Combine(D(), hn::PromoteTo(Four(), hn::Load(four, from + stride * (k + 4))), first);
#else
    return first;
#endif
  };
  return transposed(load(0), load(1), load(2), load(3));
}

/// Displacements of a corner; lane i of the result is element i.
HWY_INLINE Vec3V load_rows(const Padded3* rows, const std::int32_t* corners) {
  const D d;
  const auto load = [&](std::size_t k) {
    const double* first = &rows[static_cast<std::size_t>(corners[4 * k])].x;
#if HWY_MAX_BYTES >= 64
    const double* second = &rows[static_cast<std::size_t>(corners[4 * k + 16])].x;
    return hn::Combine(d, hn::Load(Four(), second), hn::Load(Four(), first));
#else
    return hn::Load(d, first);
#endif
  };
  const FourV rows_of = transposed(load(0), load(1), load(2), load(3));
  return {rows_of.x, rows_of.y, rows_of.z};
}

/// The inverse conversion: row k gets (x, y, z, w) of lane k. Rows are `stride` doubles apart.
HWY_INLINE void store_fours(const FourV& v, double* rows, std::size_t stride) {
  const D d;
  const V xy02 = hn::InterleaveLower(d, v.x, v.y);
  const V xy13 = hn::InterleaveUpper(d, v.x, v.y);
  const V zw02 = hn::InterleaveLower(d, v.z, v.w);
  const V zw13 = hn::InterleaveUpper(d, v.z, v.w);
  const auto store = [&](V row, std::size_t k) {
#if HWY_MAX_BYTES >= 64
    hn::Store(hn::LowerHalf(Four(), row), Four(), rows + stride * k);
    hn::Store(hn::UpperHalf(Four(), row), Four(), rows + stride * (k + 4));
#else
    hn::Store(row, d, rows + stride * k);
#endif
  };
  store(hn::OddEvenBlocks(hn::SwapAdjacentBlocks(zw02), xy02), 0);
  store(hn::OddEvenBlocks(hn::SwapAdjacentBlocks(zw13), xy13), 1);
  store(hn::OddEvenBlocks(zw02, hn::SwapAdjacentBlocks(xy02)), 2);
  store(hn::OddEvenBlocks(zw13, hn::SwapAdjacentBlocks(xy13)), 3);
}

/// Row k of 16 doubles for each element gets (x, y, z, 0) of lane k.
HWY_INLINE void store_rows(const Vec3V& v, double* rows) {
  store_fours({v.x, v.y, v.z, hn::Zero(D())}, rows, 16);
}

/// store_fours() in float.
HWY_INLINE void store_float_fours(const FourV& v, float* to, std::size_t stride) {
  const hn::Rebind<float, D> d;
  const hn::Repartition<double, decltype(d)> pairs;
  const auto x = hn::DemoteTo(d, v.x);
  const auto y = hn::DemoteTo(d, v.y);
  const auto z = hn::DemoteTo(d, v.z);
  const auto last = hn::DemoteTo(d, v.w);
  const auto xy01 = hn::BitCast(pairs, hn::InterleaveLower(d, x, y));
  const auto xy23 = hn::BitCast(pairs, hn::InterleaveUpper(d, x, y));
  const auto zw01 = hn::BitCast(pairs, hn::InterleaveLower(d, z, last));
  const auto zw23 = hn::BitCast(pairs, hn::InterleaveUpper(d, z, last));
  const auto store = [&](auto rows, std::size_t k) {
    const auto values = hn::BitCast(d, rows);
    const hn::FixedTag<float, 4> four;
#if HWY_MAX_BYTES >= 64
    hn::Store(hn::LowerHalf(four, values), four, to + stride * k);
    hn::Store(hn::UpperHalf(four, values), four, to + stride * (k + 4));
#else
    hn::Store(values, four, to + stride * k);
#endif
  };
  store(hn::InterleaveLower(pairs, xy01, zw01), 0);
  store(hn::InterleaveUpper(pairs, xy01, zw01), 1);
  store(hn::InterleaveLower(pairs, xy23, zw23), 2);
  store(hn::InterleaveUpper(pairs, xy23, zw23), 3);
}

/// Row k of 4 quads for each element gets (x, y, z, w) of lane k, in float.
HWY_INLINE void store_quads(const Vec3V& v, V w, Quad* quads) {
  store_float_fours({v.x, v.y, v.z, w}, &quads->x, 16);
}

#endif

}  // namespace
}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
