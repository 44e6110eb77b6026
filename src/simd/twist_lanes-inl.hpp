// Tangents of the stable neo-Hookean law in lanes, without eigenvectors. Included once for each target.
//
// With C = cof F, f_i = F g_i and c_i = C g_i the exact block between two corners is, per volume,
//   m (g_i . g_j) I + bend f_i f_j^T + bulk c_i c_j^T - p [F (g_i x g_j)]x
// (FactorsV). Its eigenvectors in the space of dF are of two kinds, which do not mix: three twists R [w]x
// with eigenvalues m + p s_k, and symmetric ones R S. With r_i = R g_i, twists alone have the blocks
//   1/2 [r_i]x^T T [r_j]x,  T = m I + p F R^T,
// in which F R^T is the left stretch. So cutting the negative twists needs the negative part of T, whose
// eigenvalues are m + p s_k. All signs follow from the invariants of F and the trace l of its stretch.
#if defined(PALPATE_SIMD_TWIST_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_SIMD_TWIST_LANES_INL
#undef PALPATE_SIMD_TWIST_LANES_INL
#else
#define PALPATE_SIMD_TWIST_LANES_INL
#endif

#include <array>
#include <cstddef>
#include <hwy/highway.h>

#include "simd/hyperelastic_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {

#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE

/// T, and the search for the eigenvalue whose sign differs from that of the two others. It is the largest
/// root x, times +1 or -1, of x^3 - a x^2 + b x - c.
struct TwistV {
  std::array<V, 6> matrix;  ///< T: xx, yy, zz, xy, xz, yz
  V a, b, c;
  V sign;     ///< of the eigenvalue
  V root;     ///< x
  M odd;      ///< lanes with eigenvalues of both signs
  M whole;    ///< lanes with at most one positive eigenvalue: T is part of the negative part
  M settled;  ///< lanes that need no further step
};

/// Lanes in which all eigenvalues but those of twists are positive: flips m - p s_k, and the 3x3 matrix of
/// scalings m I + bend s s^T + bulk c c^T + p N, with N_ij = s_k. Both by the signs of their elementary
/// symmetric functions; those of scalings follow from N s = 2 c, |N c|^2 = I II + 3 J^2 and
/// w^T N w = -2 J (I^2 - 3 II) for w = s x c.
HWY_INLINE M only_twists_negative(const FactorsV& t, const Root& r) {
  const V zero = hn::Zero(D());
  const V three = set(3.0);
  const V m = t.linear;
  const V p = t.pressure;
  const V pp = hn::Mul(p, p);
  const V mm = hn::Mul(m, m);
  const V pj = hn::Mul(p, r.det);
  const V second = hn::Mul(set(0.5), hn::MulSub(r.root, r.root, r.first));
  const V pl = hn::Mul(p, r.root);
  const V flip1 = hn::MulSub(three, m, pl);
  const V flip2 = hn::MulAdd(m, hn::Sub(flip1, pl), hn::Mul(pp, second));
  const V flip3 = hn::MulAdd(mm, hn::Sub(m, pl), hn::Mul(pp, hn::MulSub(m, second, pj)));
  M good = hn::And(hn::Gt(flip1, zero), hn::And(hn::Gt(flip2, zero), hn::Gt(flip3, zero)));
  // Of scalings: the trace is positive.
  const V mpj = hn::Mul(m, pj);
  const V jj = hn::Mul(r.det, r.det);
  const V both = hn::MulSub(r.first, r.second, hn::Mul(set(9.0), jj));
  const V couple = hn::Mul(t.bend, t.bulk);
  const V m_first = hn::Mul(m, r.first);
  const V m_second = hn::Mul(m, r.second);
  V sum2 = hn::MulSub(three, mm, hn::Mul(pp, r.first));
  sum2 = hn::MulAdd(hn::Add(t.bend, t.bend), hn::NegMulAdd(three, pj, m_first), sum2);
  sum2 = hn::MulAdd(hn::Add(t.bulk, t.bulk), hn::NegMulAdd(pj, r.first, m_second), sum2);
  sum2 = hn::MulAdd(couple, both, sum2);
  const V rest = hn::NegMulAdd(pp, r.first, mm);
  V sum3 = hn::MulAdd(m, rest, hn::Mul(hn::Add(pp, pp), pj));
  const V along_s =
      hn::MulAdd(rest, r.first, hn::MulSub(hn::Mul(set(4.0), pp), r.second, hn::Mul(set(6.0), mpj)));
  sum3 = hn::MulAdd(t.bend, along_s, sum3);
  const V along_c =
      hn::MulAdd(m, m_second, hn::MulSub(hn::Mul(three, pp), jj, hn::Mul(hn::Add(mpj, mpj), r.first)));
  sum3 = hn::MulAdd(t.bulk, along_c, sum3);
  const V spread = hn::NegMulAdd(three, r.second, hn::Mul(r.first, r.first));
  sum3 = hn::MulAdd(couple, hn::MulSub(m, both, hn::Mul(hn::Add(pj, pj), spread)), sum3);
  good = hn::And(good, hn::And(hn::Gt(sum2, zero), hn::Gt(sum3, zero)));
  return good;
}

HWY_INLINE TwistV twist_of(const FactorsV& t, const Root& r, const Matrix3V& f, const Matrix3V& rotation) {
  const V zero = hn::Zero(D());
  const V m = t.linear;
  const V p = t.pressure;
  TwistV twist;
  twist.matrix = {hn::MulAdd(p, dot(f.a, rotation.a), m), hn::MulAdd(p, dot(f.b, rotation.b), m),
                  hn::MulAdd(p, dot(f.c, rotation.c), m), hn::Mul(p, dot(f.a, rotation.b)),
                  hn::Mul(p, dot(f.a, rotation.c)),       hn::Mul(p, dot(f.b, rotation.c))};
  const V pp = hn::Mul(p, p);
  const V second = hn::Mul(set(0.5), hn::MulSub(r.root, r.root, r.first));
  const V pl = hn::Mul(p, r.root);
  const V sum1 = hn::MulAdd(set(3.0), m, pl);
  const V sum2 = hn::MulAdd(m, hn::Add(sum1, pl), hn::Mul(pp, second));
  const V sum3 =
      hn::MulAdd(hn::Mul(m, m), hn::Add(m, pl), hn::Mul(pp, hn::MulAdd(m, second, hn::Mul(p, r.det))));
  const M positive = hn::And(hn::Ge(sum1, zero), hn::And(hn::Ge(sum2, zero), hn::Ge(sum3, zero)));
  const M negative = hn::And(hn::Le(sum1, zero), hn::And(hn::Ge(sum2, zero), hn::Le(sum3, zero)));
  twist.odd = hn::Not(hn::Or(positive, negative));
  twist.whole = hn::AndNot(positive, hn::Or(negative, hn::Gt(sum3, zero)));
  twist.sign = hn::CopySign(set(1.0), sum3);
  twist.a = hn::Mul(twist.sign, sum1);
  twist.b = sum2;
  twist.c = hn::Abs(sum3);
  // An upper bound; exact if the other two are equal.
  const V size = hn::Sqrt(hn::Max(zero, hn::MulSub(twist.a, twist.a, hn::Mul(set(3.0), twist.b))));
  twist.root = hn::Mul(set(1.0 / 3.0), hn::Add(twist.a, hn::Add(size, size)));
  twist.settled = hn::Not(twist.odd);
  return twist;
}

HWY_INLINE V derivative(const TwistV& t) {
  return hn::MulAdd(hn::MulSub(set(3.0), t.root, hn::Add(t.a, t.a)), t.root, t.b);
}

/// A step of Halley's iteration, of third order, in lanes that are not settled.
HWY_INLINE void improve(TwistV& t) {
  const V x = t.root;
  const V value = hn::MulSub(hn::MulAdd(hn::Sub(x, t.a), x, t.b), x, t.c);
  const V slope = derivative(t);
  const V curvature = hn::MulSub(set(3.0), x, t.a);
  const V step = hn::Div(hn::Mul(value, slope), hn::MulSub(slope, slope, hn::Mul(value, curvature)));
  t.root = hn::IfThenElse(t.settled, x, hn::Sub(x, step));
  // The next error is below step^3 / (distance of the other roots)^2, and the slope is at least that square.
  const V error = hn::Mul(hn::Mul(step, step), hn::Abs(step));
  const V small = hn::Mul(set(1e-15), hn::Mul(slope, hn::Add(hn::Abs(t.a), x)));
  t.settled = hn::Or(t.settled, hn::Le(error, small));
}

/// -1/2 scale times the negative part of T. For eigenvalues of both signs it is (T or 0) - x n n^T, with the
/// eigenvector n: n n^T is the adjugate of sign T - x over the slope.
HWY_INLINE std::array<V, 6> negative_part(const TwistV& t, V scale) {
  const std::array<V, 6>& m = t.matrix;
  const auto shifted = [&](V value) { return hn::MulSub(t.sign, value, t.root); };
  const V xx = shifted(m[0]);
  const V yy = shifted(m[1]);
  const V zz = shifted(m[2]);
  // Off the diagonal the sign matters in products with the diagonal only.
  const auto sum = [](V a, V b, V c, V d) { return hn::MulSub(a, b, hn::Mul(c, d)); };
  const V xy = hn::Mul(t.sign, m[3]);
  const V xz = hn::Mul(t.sign, m[4]);
  const V yz = hn::Mul(t.sign, m[5]);
  const std::array<V, 6> adjugate{sum(yy, zz, yz, yz), sum(xx, zz, xz, xz), sum(xx, yy, xy, xy),
                                  sum(xz, yz, xy, zz), sum(xy, yz, xz, yy), sum(xy, xz, yz, xx)};
  const V half = hn::Mul(set(-0.5), scale);
  const V one = hn::IfThenElseZero(t.odd, hn::Div(hn::Mul(half, t.root), derivative(t)));
  const V all = hn::IfThenElseZero(t.whole, half);
  std::array<V, 6> part;
  for (std::size_t k = 0; k < 6; ++k) part[k] = hn::NegMulAdd(one, adjugate[k], hn::Mul(all, m[k]));
  return part;
}

using Vec3Array = std::array<V, 3>;
HWY_INLINE Vec3Array as_array(const Vec3V& a) {
  return {a.x, a.y, a.z};
}

/// What the blocks of an element are made of, scaled.
struct CornersV {
  std::array<Vec3V, 3> g, f, r;
  std::array<Vec3V, 3> s;          ///< F (g_j x g_k), the edge to corner i over 6 V
  std::array<Vec3V, 3> c;          ///< c_i over 6 V
  std::array<Matrix3V, 3> turned;  ///< columns of (negative part) [r]x
  V linear, bend, bulk, pressure;
};

HWY_INLINE CornersV corners_of(const FactorsV& t, const TwistV& twist, const Matrix3V& f,
                               const Matrix3V& rotation, const std::array<Vec3V, 3>& g, V volume, V scale) {
  CornersV corners;
  const std::array<V, 6> q = negative_part(twist, scale);
  const Vec3V qx{q[0], q[3], q[4]};
  const Vec3V qy{q[3], q[1], q[5]};
  const Vec3V qz{q[4], q[5], q[2]};
  for (std::size_t k = 0; k < 3; ++k) {
    corners.g[k] = g[k];
    corners.f[k] = product(f, g[k]);
    corners.s[k] = product(f, cross(g[(k + 1) % 3], g[(k + 2) % 3]));
    corners.r[k] = product(rotation, g[k]);
    const Vec3V x = cross(qx, corners.r[k]);
    const Vec3V y = cross(qy, corners.r[k]);
    const Vec3V z = cross(qz, corners.r[k]);
    corners.turned[k] = {{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}};
  }
  // C (a x b) = F a x F b, and 1 / (6 V) is the determinant of the gradients
  for (std::size_t k = 0; k < 3; ++k) corners.c[k] = cross(corners.s[(k + 1) % 3], corners.s[(k + 2) % 3]);
  const V six = hn::Mul(set(6.0), volume);
  corners.linear = hn::Mul(scale, t.linear);
  corners.bend = hn::Mul(scale, t.bend);
  corners.bulk = hn::Mul(hn::Mul(scale, t.bulk), hn::Mul(six, six));
  corners.pressure = hn::Mul(scale, t.pressure);
  return corners;
}

/// The block of corners i <= j of 1 to 3, row by row; on the diagonal it is symmetric.
template <std::size_t i, std::size_t j>
HWY_INLINE std::array<V, 9> block_between(const CornersV& t) {
  const Vec3Array left = as_array(times(t.bend, t.f[i]));
  const Vec3Array right = as_array(t.f[j]);
  const Vec3Array left_cofactor = as_array(times(t.bulk, t.c[i]));
  const Vec3Array right_cofactor = as_array(t.c[j]);
  const V whole = hn::Mul(t.linear, dot(t.g[i], t.g[j]));
  const Matrix3V& turned = t.turned[j];
  const std::array<Vec3Array, 3> twist{as_array(cross(turned.a, t.r[i])), as_array(cross(turned.b, t.r[i])),
                                       as_array(cross(turned.c, t.r[i]))};
  std::array<V, 9> block;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = i == j ? a : 0; b < 3; ++b) {
      const V sum = hn::MulAdd(left[a], right[b], twist[b][a]);
      block[3 * a + b] = hn::MulAdd(left_cofactor[a], right_cofactor[b], sum);
    }
    block[4 * a] = hn::Add(block[4 * a], whole);
  }
  if constexpr (i == j) {
    block[3] = block[1];
    block[6] = block[2];
    block[7] = block[5];
  } else {
    const Vec3V s = times(j - i == 1 ? t.pressure : hn::Neg(t.pressure), t.s[3 - i - j]);
    block[1] = hn::Add(block[1], s.z);
    block[2] = hn::Sub(block[2], s.y);
    block[3] = hn::Sub(block[3], s.z);
    block[5] = hn::Add(block[5], s.x);
    block[6] = hn::Add(block[6], s.y);
    block[7] = hn::Sub(block[7], s.x);
  }
  return block;
}

#endif

}  // namespace
}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
