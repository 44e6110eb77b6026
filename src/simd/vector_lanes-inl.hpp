// Vectors of double, one per lane. Sums have the order of geometry/vector.hpp, so all bits equal those of
// scalar code. Included once for each target.
#if defined(PALPATE_SIMD_VECTOR_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_SIMD_VECTOR_LANES_INL
#undef PALPATE_SIMD_VECTOR_LANES_INL
#else
#define PALPATE_SIMD_VECTOR_LANES_INL
#endif

#include <cstddef>
#include <hwy/highway.h>

#include "simd/vector_rows.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 8>;
using Double = hn::Vec<Doubles>;
constexpr Doubles doubles;

template <class Number>
struct VectorOf {
  Number x;
  Number y;
  Number z;
};
using Vector = VectorOf<Double>;
HWY_INLINE Double load(const LaneRow& row, std::size_t lane) {
  return hn::Load(doubles, row.data() + lane);
}
HWY_INLINE Vector load(const VectorRows& rows, std::size_t lane) {
  return {load(rows.x, lane), load(rows.y, lane), load(rows.z, lane)};
}
HWY_INLINE void store(Double v, LaneRow& row, std::size_t lane) {
  hn::Store(v, doubles, row.data() + lane);
}
HWY_INLINE void store(const Vector& v, VectorRows& rows, std::size_t lane) {
  store(v.x, rows.x, lane);
  store(v.y, rows.y, lane);
  store(v.z, rows.z, lane);
}

template <class Number>
HWY_INLINE VectorOf<Number> difference(const VectorOf<Number>& a, const VectorOf<Number>& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
template <class Number>
HWY_INLINE VectorOf<Number> cross(const VectorOf<Number>& a, const VectorOf<Number>& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
template <class Number>
HWY_INLINE Number dot(const VectorOf<Number>& a, const VectorOf<Number>& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
template <class Number>
HWY_INLINE VectorOf<Number> scaled(Number s, const VectorOf<Number>& a) {
  return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)};
}
template <class Number>
HWY_INLINE VectorOf<Number> sum(const VectorOf<Number>& a, const VectorOf<Number>& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}

}  // namespace
}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
