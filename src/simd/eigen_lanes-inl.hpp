// Eigenvalues and eigenvectors of symmetric matrices in lanes. Included once for each target.
#if defined(PALPATE_SIMD_EIGEN_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_SIMD_EIGEN_LANES_INL
#undef PALPATE_SIMD_EIGEN_LANES_INL
#else
#define PALPATE_SIMD_EIGEN_LANES_INL
#endif

#include <array>
#include <cstddef>
#include <hwy/highway.h>

#include "simd/tet_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {

#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE

HWY_INLINE V set(double x) {
  return hn::Set(D(), x);
}

/// A symmetric matrix during diagonalisation, and its eigenvectors so far, as columns.
struct EigenV {
  std::array<V, 3> diagonal;
  std::array<V, 3> off;  ///< opposite to axis 0, 1, 2: yz, xz, xy
  std::array<Vec3V, 3> vectors;
};

/// Makes the entry of axes p and q zero; r is the third.
/// \param where  lanes to rotate
template <std::size_t p, std::size_t q>
HWY_INLINE void rotate(EigenV& m, M where) {
  constexpr std::size_t r = 3 - p - q;
  const V one = set(1.0);
  const V difference = hn::Sub(m.diagonal[q], m.diagonal[p]);
  const V twice = hn::Add(m.off[r], m.off[r]);
  // tan = twice / (|difference| + size); cosine and sine by one division more
  const V square = hn::Mul(twice, twice);
  const V size = hn::Sqrt(hn::MulAdd(difference, difference, square));
  const V under = hn::Add(hn::Add(hn::Abs(difference), size), set(1e-150));
  const V scale = hn::Div(one, hn::Sqrt(hn::MulAdd(under, under, square)));
  const V c = hn::IfThenElse(where, hn::Mul(under, scale), one);
  const V s = hn::IfThenElseZero(where, hn::Mul(hn::CopySign(scale, difference), twice));
  const V shift = hn::IfThenElseZero(
      where, hn::CopySign(hn::Mul(set(0.5), hn::Sub(size, hn::Abs(difference))), difference));
  m.diagonal[p] = hn::Sub(m.diagonal[p], shift);
  m.diagonal[q] = hn::Add(m.diagonal[q], shift);
  m.off[r] = hn::IfThenZeroElse(where, m.off[r]);
  const V rp = m.off[q];
  const V rq = m.off[p];
  m.off[q] = hn::NegMulAdd(s, rq, hn::Mul(c, rp));
  m.off[p] = hn::MulAdd(s, rp, hn::Mul(c, rq));
  const Vec3V vp = m.vectors[p];
  const Vec3V vq = m.vectors[q];
  m.vectors[p] = minus(times(c, vp), times(s, vq));
  m.vectors[q] = times_plus(s, vp, times(c, vq));
}

HWY_INLINE EigenV eigen_start(const std::array<V, 6>& a) {
  const V zero = hn::Zero(D());
  const V one = set(1.0);
  return {{a[0], a[1], a[2]},
          {a[5], a[4], a[3]},
          {Vec3V{one, zero, zero}, Vec3V{zero, one, zero}, Vec3V{zero, zero, one}}};
}

/// Diagonalises by cyclic Jacobi rotations.
/// \tparam sweeps  number of sweeps
template <int sweeps>
HWY_INLINE EigenV eigen_of(const std::array<V, 6>& a) {
  EigenV m = eigen_start(a);
  const M all = hn::FirstN(D(), lanes);
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    rotate<0, 1>(m, all);
    rotate<0, 2>(m, all);
    rotate<1, 2>(m, all);
  }
  return m;
}

#endif

}  // namespace
}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
