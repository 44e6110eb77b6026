// Tangents of hyperelastic laws in lanes, in principal axes: the formulas of fem/hyperelastic.cpp. Included
// once for each target.
#if defined(PALPATE_SIMD_PRINCIPAL_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_SIMD_PRINCIPAL_LANES_INL
#undef PALPATE_SIMD_PRINCIPAL_LANES_INL
#else
#define PALPATE_SIMD_PRINCIPAL_LANES_INL
#endif

#include <array>
#include <cstddef>
#include <hwy/highway.h>

#include "simd/eigen_lanes-inl.hpp"
#include "simd/hyperelastic_lanes-inl.hpp"
#include "simd/rotation_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {

#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE

/// Columns of U and V, and the tangent in these principal axes.
struct TangentV {
  std::array<Vec3V, 3> left, right;
  std::array<V, 6> stretch;  ///< xx, yy, zz, xy, xz, yz
  std::array<V, 3> same, other;
};

/// Sweeps of Jacobi rotations. They converge quadratically, so four reach rounding error.
constexpr int tangent_sweeps = 4;

/// The matrix with each negative eigenvalue times `factor`. Lanes without negative eigenvalues keep their
/// bits.
HWY_INLINE std::array<V, 6> positive_part(const std::array<V, 6>& a, V factor) {
  const D d;
  const V zero = hn::Zero(d);
  const V minor = hn::MulSub(a[0], a[1], hn::Mul(a[3], a[3]));
  const V det = hn::MulAdd(a[0], hn::MulSub(a[1], a[2], hn::Mul(a[5], a[5])),
                           hn::MulSub(a[4], hn::MulSub(a[3], a[5], hn::Mul(a[1], a[4])),
                                      hn::Mul(a[3], hn::MulSub(a[3], a[2], hn::Mul(a[5], a[4])))));
  const M good = hn::And(hn::Gt(a[0], zero), hn::And(hn::Gt(minor, zero), hn::Gt(det, zero)));
  if (hn::AllTrue(d, good)) return a;
  const EigenV eigen = eigen_of<tangent_sweeps>(a);
  std::array<V, 6> sum{zero, zero, zero, zero, zero, zero};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3V& v = eigen.vectors[k];
    const Vec3V w = times(hn::Max(eigen.diagonal[k], hn::Mul(factor, eigen.diagonal[k])), v);
    sum = {hn::MulAdd(w.x, v.x, sum[0]), hn::MulAdd(w.y, v.y, sum[1]), hn::MulAdd(w.z, v.z, sum[2]),
           hn::MulAdd(w.x, v.y, sum[3]), hn::MulAdd(w.x, v.z, sum[4]), hn::MulAdd(w.y, v.z, sum[5])};
  }
  for (std::size_t k = 0; k < 6; ++k) sum[k] = hn::IfThenElse(good, a[k], sum[k]);
  return sum;
}

/// Eigenvalues of the tangent from the singular values s.
HWY_INLINE void set_principal(const FactorsV& factors, V second, const std::array<V, 3>& s, TangentV& t) {
  const V zero = hn::Zero(D());
  const V half = set(0.5);
  const std::array<V, 3> c{hn::Mul(s[1], s[2]), hn::Mul(s[2], s[0]), hn::Mul(s[0], s[1])};
  const std::array<V, 3> q{hn::Mul(s[0], s[0]), hn::Mul(s[1], s[1]), hn::Mul(s[2], s[2])};
  const V product = hn::MulAdd(set(2.0), second, factors.bend);
  const auto diagonal = [&](std::size_t i, std::size_t j, std::size_t k) {
    return hn::MulAdd(
        factors.bulk, hn::Mul(c[i], c[i]),
        hn::MulAdd(second, hn::Add(q[j], q[k]), hn::MulAdd(factors.bend, q[i], factors.linear)));
  };
  const auto mixed = [&](std::size_t i, std::size_t j, std::size_t k) {
    return hn::MulAdd(product, c[k],
                      hn::MulAdd(hn::Mul(factors.bulk, c[i]), c[j], hn::Mul(factors.pressure, s[k])));
  };
  const M stretched = hn::And(hn::Gt(factors.pressure, zero), hn::Gt(hn::Mul(c[2], s[2]), zero));
  const V kept = hn::IfThenElseZero(stretched, set(-kept_part));
  t.stretch = positive_part({diagonal(0, 1, 2), diagonal(1, 2, 0), diagonal(2, 0, 1), mixed(0, 1, 2),
                             mixed(0, 2, 1), mixed(1, 2, 0)},
                            kept);
  for (std::size_t k = 0; k < 3; ++k) {
    const V push = hn::Mul(factors.pressure, s[k]);
    const V twist = hn::Max(zero, hn::Add(hn::MulAdd(second, hn::Add(q[k], c[k]), factors.linear), push));
    const V flip = hn::Sub(hn::MulAdd(second, hn::Sub(q[k], c[k]), factors.linear), push);
    const V positive_flip = hn::Max(flip, hn::Mul(kept, flip));
    t.same[k] = hn::Mul(half, hn::Add(positive_flip, twist));
    t.other[k] = hn::Mul(half, hn::Sub(positive_flip, twist));
  }
}

/// The symmetric part of R^T F, to be diagonalised.
HWY_INLINE EigenV stretch_of(const Matrix3V& r, const Matrix3V& f) {
  const V half = set(0.5);
  const Vec3V r0{r.a.x, r.b.x, r.c.x};
  const Vec3V r1{r.a.y, r.b.y, r.c.y};
  const Vec3V r2{r.a.z, r.b.z, r.c.z};
  const Vec3V f0{f.a.x, f.b.x, f.c.x};
  const Vec3V f1{f.a.y, f.b.y, f.c.y};
  const Vec3V f2{f.a.z, f.b.z, f.c.z};
  const auto mean = [&](V a, V b) { return hn::Mul(half, hn::Add(a, b)); };
  return eigen_start({dot(r0, f0), dot(r1, f1), dot(r2, f2), mean(dot(r0, f1), dot(r1, f0)),
                      mean(dot(r0, f2), dot(r2, f0)), mean(dot(r1, f2), dot(r2, f1))});
}

/// \param eigen  of the stretch
HWY_INLINE TangentV tangent(const FactorsV& factors, V second, const Matrix3V& rotation,
                            const EigenV& eigen) {
  TangentV t{};
  t.right = eigen.vectors;
  for (std::size_t k = 0; k < 3; ++k) t.left[k] = product(rotation, eigen.vectors[k]);
  set_principal(factors, second, eigen.diagonal, t);
  return t;
}

/// Block U M U^T between two corners; a and b are V^T g of these.
HWY_INLINE std::array<V, 9> rotated_block(const TangentV& t, const Vec3V& a, const Vec3V& b) {
  const Vec3V p{hn::Mul(a.x, b.x), hn::Mul(a.y, b.y), hn::Mul(a.z, b.z)};
  const auto mixed = [](V s, V o, V ap, V bq, V aq, V bp) {
    return hn::MulAdd(hn::Mul(s, ap), bq, hn::Mul(hn::Mul(o, aq), bp));
  };
  const auto sum = [](V x, V px, V y, V py, V z, V pz) {
    return hn::MulAdd(x, px, hn::MulAdd(y, py, hn::Mul(z, pz)));
  };
  const std::array<V, 6>& s = t.stretch;
  const Matrix3V m{
      {sum(s[0], p.x, t.same[2], p.y, t.same[1], p.z), mixed(s[3], t.other[2], a.x, b.y, a.y, b.x),
       mixed(s[4], t.other[1], a.x, b.z, a.z, b.x)},
      {mixed(s[3], t.other[2], a.y, b.x, a.x, b.y), sum(t.same[2], p.x, s[1], p.y, t.same[0], p.z),
       mixed(s[5], t.other[0], a.y, b.z, a.z, b.y)},
      {mixed(s[4], t.other[1], a.z, b.x, a.x, b.z), mixed(s[5], t.other[0], a.z, b.y, a.y, b.z),
       sum(t.same[1], p.x, t.same[0], p.y, s[2], p.z)}};
  const auto row = [&](V x, V y, V z) { return times_plus(x, m.a, times_plus(y, m.b, times(z, m.c))); };
  const Vec3V ux{t.left[0].x, t.left[1].x, t.left[2].x};
  const Vec3V uy{t.left[0].y, t.left[1].y, t.left[2].y};
  const Vec3V uz{t.left[0].z, t.left[1].z, t.left[2].z};
  const Vec3V x = row(ux.x, ux.y, ux.z);
  const Vec3V y = row(uy.x, uy.y, uy.z);
  const Vec3V z = row(uz.x, uz.y, uz.z);
  return {dot(x, ux), dot(x, uy), dot(x, uz), dot(y, ux), dot(y, uy),
          dot(y, uz), dot(z, ux), dot(z, uy), dot(z, uz)};
}

#endif

}  // namespace
}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
