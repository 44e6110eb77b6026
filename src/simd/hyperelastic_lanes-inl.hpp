// Hyperelastic laws in lanes: the formulas of fem/hyperelastic.cpp. Included once for each target.
#if defined(PALPATE_SIMD_HYPERELASTIC_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_SIMD_HYPERELASTIC_LANES_INL
#undef PALPATE_SIMD_HYPERELASTIC_LANES_INL
#else
#define PALPATE_SIMD_HYPERELASTIC_LANES_INL
#endif

#include <array>
#include <cstddef>
#include <hwy/highway.h>
#include <numbers>

#include "simd/eigen_lanes-inl.hpp"
#include "simd/rotation_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {

#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE

struct LawV {
  V first, second, bulk;
  Vec3V fibre;
  V fibre_stiffness, fibre_exponent, tension;
};
/// Energy w of the fibres, and coefficients of stress and tangent.
struct FibreV {
  Vec3V stretched;
  V energy, stress, along;
};
struct ResponseV {
  V energy;
  Matrix3V stress;
  V volume_change;
};
/// Columns of U and V, and the tangent in these principal axes.
struct TangentV {
  std::array<Vec3V, 3> left, right;
  std::array<V, 6> stretch;  ///< xx, yy, zz, xy, xz, yz
  std::array<V, 3> same, other;
};

/// Sweeps of Jacobi rotations. They converge quadratically, so four reach rounding error.
constexpr int tangent_sweeps = 4;

/// ln(1 + x), x > -1, as geometry/exponential.cpp does it.
HWY_INLINE V log_of_one_plus(V x) {
  const D d;
  const hn::RebindToSigned<D> di;
  const V y = hn::Add(x, set(1.0));
  const auto bits = hn::BitCast(di, y);
  const V mantissa = hn::BitCast(
      d, hn::Or(hn::And(bits, hn::Set(di, 0x000fffffffffffffLL)), hn::Set(di, 0x3ff0000000000000LL)));
  const V exponent = hn::ConvertTo(d, hn::Sub(hn::ShiftRight<52>(bits), hn::Set(di, 1023)));
  const V root = set(std::numbers::sqrt2);
  const M large = hn::Gt(mantissa, root);
  const V m = hn::IfThenElse(large, hn::Mul(mantissa, set(0.5)), mantissa);
  const M near = hn::And(hn::Ge(y, hn::Mul(root, set(0.5))), hn::Le(y, root));
  const V n = hn::IfThenElse(near, hn::Zero(d), hn::IfThenElse(large, hn::Add(exponent, set(1.0)), exponent));
  const V over = hn::IfThenElse(near, x, hn::Sub(m, set(1.0)));
  const V under = hn::IfThenElse(near, hn::Add(x, set(2.0)), hn::Add(m, set(1.0)));
  const V z = hn::Div(over, under);
  const V square = hn::Mul(z, z);
  V sum = hn::Zero(d);
  for (int k = 21; k > 1; k -= 2) sum = hn::Mul(square, hn::Add(sum, set(1.0 / k)));
  const V rest = hn::Mul(set(2.0), hn::MulAdd(z, sum, z));
  return hn::MulAdd(n, set(std::numbers::ln2), rest);
}

/// e^x for 0 <= x <= 16.
HWY_INLINE V exponential(V x) {
  const D d;
  const hn::RebindToSigned<D> di;
  const auto n = hn::ConvertTo(di, hn::MulAdd(x, set(1.0 / std::numbers::ln2), set(0.5)));
  const V whole = hn::ConvertTo(d, n);
  const V r = hn::NegMulAdd(whole, set(0x1.a39ef35793c76p-33), hn::NegMulAdd(whole, set(0x1.62e42feep-1), x));
  V sum = set(1.0 / 6227020800.0);
  double factorial = 6227020800.0;
  for (int k = 13; k > 0; --k) {
    factorial /= k;
    sum = hn::MulAdd(sum, r, set(1.0 / factorial));
  }
  const V scale = hn::BitCast(d, hn::ShiftLeft<52>(hn::Add(n, hn::Set(di, 1023))));
  return hn::Mul(sum, scale);
}

HWY_INLINE FibreV fibre_state(const LawV& law, const Matrix3V& h) {
  const D d;
  const V zero = hn::Zero(d);
  const V one = set(1.0);
  const Vec3V change = product(h, law.fibre);
  const V e = hn::MulAdd(set(2.0), dot(law.fibre, change), dot(change, change));
  // Passive part. Where exponent E^2 > 16 it is a polynomial.
  const V stretched = hn::Max(e, zero);
  const V border = hn::Sqrt(hn::Div(set(16.0), hn::Max(law.fibre_exponent, set(1e-300))));
  const V at = hn::Min(stretched, border);
  const V x = hn::Mul(law.fibre_exponent, hn::Mul(at, at));
  const V growth = exponential(x);
  const V series = hn::MulAdd(x, hn::MulAdd(x, set(1.0 / 6.0), set(0.5)), one);
  const V mean =
      hn::IfThenElse(hn::Lt(x, set(1e-4)), series, hn::Div(hn::Sub(growth, one), hn::Max(x, set(1e-300))));
  const V slope_at = hn::Mul(law.fibre_stiffness, hn::Mul(at, growth));
  const V bend = hn::Mul(law.fibre_stiffness, hn::Mul(growth, hn::MulAdd(set(2.0), x, one)));
  const V more = hn::Sub(stretched, at);
  const V value_at = hn::Mul(hn::Mul(set(0.5), law.fibre_stiffness), hn::Mul(hn::Mul(at, at), mean));
  const V value = hn::MulAdd(more, hn::MulAdd(hn::Mul(set(0.5), bend), more, slope_at), value_at);
  const V slope = hn::MulAdd(bend, more, slope_at);
  const V curvature = hn::IfThenElse(hn::Gt(e, zero), bend, zero);
  // Active part.
  const V rest_length = hn::Sqrt(set(1.0 + 1e-6));
  const V length = hn::Sqrt(hn::Add(set(1.0 + 1e-6), e));
  const V pull = hn::Div(law.tension, length);
  const V active = hn::Mul(law.tension, hn::Div(e, hn::Add(length, rest_length)));
  return {plus(law.fibre, change), hn::Add(value, active), hn::MulAdd(set(2.0), slope, pull),
          hn::MulSub(set(4.0), curvature, hn::Div(pull, hn::Mul(length, length)))};
}

HWY_INLINE ResponseV respond(const LawV& law, const Matrix3V& h, const Matrix3V& f, const FibreV& fibre,
                             bool fibres) {
  const V one = set(1.0);
  const Matrix3V ch = cofactors(h);
  const V trace = hn::Add(h.a.x, hn::Add(h.b.y, h.c.z));
  const V trace_ch = hn::Add(ch.a.x, hn::Add(ch.b.y, ch.c.z));
  const V j = hn::Add(hn::Add(trace, trace_ch), dot(h.a, ch.a));
  const V x = hn::MulAdd(set(2.0), trace, inner(h, h));
  // cof F - I = tr(H) I - H^T + cof H
  Matrix3V k{minus(ch.a, {h.a.x, h.b.x, h.c.x}), minus(ch.b, {h.a.y, h.b.y, h.c.y}),
             minus(ch.c, {h.a.z, h.b.z, h.c.z})};
  k.a.x = hn::Add(k.a.x, trace);
  k.b.y = hn::Add(k.b.y, trace);
  k.c.z = hn::Add(k.c.z, trace);
  const V y = hn::MulAdd(set(2.0), hn::MulAdd(set(2.0), trace, trace_ch), inner(k, k));
  const V rest = hn::MulAdd(set(0.75), law.first, hn::Mul(set(2.0), law.second));
  const V half = set(0.5);
  const V log = log_of_one_plus(hn::Mul(set(0.25), x));
  V energy = hn::Mul(hn::Mul(half, law.first), hn::Sub(x, log));
  energy = hn::MulAdd(hn::Mul(half, law.second), y, energy);
  energy = hn::MulAdd(j, hn::MulSub(hn::Mul(half, law.bulk), j, rest), energy);
  const V i1 = hn::Add(x, set(3.0));
  const V first = hn::Mul(law.first, hn::Sub(one, hn::Div(one, hn::Add(i1, one))));
  const V linear = hn::MulAdd(law.second, i1, first);
  const V pressure = hn::MulSub(law.bulk, j, rest);
  k.a.x = hn::Add(k.a.x, one);
  k.b.y = hn::Add(k.b.y, one);
  k.c.z = hn::Add(k.c.z, one);
  // (linear I - second F F^T) F + pressure cof F
  const auto entry = [&](const Vec3V& a, const Vec3V& b) { return hn::Neg(hn::Mul(law.second, dot(a, b))); };
  const V xx = hn::Add(linear, entry(f.a, f.a));
  const V yy = hn::Add(linear, entry(f.b, f.b));
  const V zz = hn::Add(linear, entry(f.c, f.c));
  const V xy = entry(f.a, f.b);
  const V xz = entry(f.a, f.c);
  const V yz = entry(f.b, f.c);
  const auto row = [&](V p, V q, V s, const Vec3V& cofactor) {
    return times_plus(p, f.a, times_plus(q, f.b, times_plus(s, f.c, times(pressure, cofactor))));
  };
  Matrix3V stress{row(xx, xy, xz, k.a), row(xy, yy, yz, k.b), row(xz, yz, zz, k.c)};
  if (fibres) {
    energy = hn::Add(energy, fibre.energy);
    const Vec3V w = times(fibre.stress, fibre.stretched);
    stress = {times_plus(w.x, law.fibre, stress.a), times_plus(w.y, law.fibre, stress.b),
              times_plus(w.z, law.fibre, stress.c)};
  }
  return {energy, stress, j};
}

/// Sets the negative eigenvalues of the matrix to zero. Lanes without negative eigenvalues keep their bits.
HWY_INLINE std::array<V, 6> positive_part(const std::array<V, 6>& a) {
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
    const Vec3V w = times(hn::Max(eigen.diagonal[k], zero), v);
    sum = {hn::MulAdd(w.x, v.x, sum[0]), hn::MulAdd(w.y, v.y, sum[1]), hn::MulAdd(w.z, v.z, sum[2]),
           hn::MulAdd(w.x, v.y, sum[3]), hn::MulAdd(w.x, v.z, sum[4]), hn::MulAdd(w.y, v.z, sum[5])};
  }
  for (std::size_t k = 0; k < 6; ++k) sum[k] = hn::IfThenElse(good, a[k], sum[k]);
  return sum;
}

/// Eigenvalues of the tangent from the singular values s.
HWY_INLINE void set_principal(const LawV& law, const std::array<V, 3>& s, V volume_change, TangentV& t) {
  const V zero = hn::Zero(D());
  const V one = set(1.0);
  const V two = set(2.0);
  const V half = set(0.5);
  const std::array<V, 3> c{hn::Mul(s[1], s[2]), hn::Mul(s[2], s[0]), hn::Mul(s[0], s[1])};
  const std::array<V, 3> q{hn::Mul(s[0], s[0]), hn::Mul(s[1], s[1]), hn::Mul(s[2], s[2])};
  const V weight = hn::Div(one, hn::Add(one, hn::Add(q[0], hn::Add(q[1], q[2]))));
  const V first = hn::Mul(law.first, hn::Sub(one, weight));
  const V bend = hn::Mul(hn::Mul(two, law.first), hn::Mul(weight, weight));
  const V rest = hn::MulAdd(set(0.75), law.first, hn::Mul(two, law.second));
  const V pressure = hn::MulSub(law.bulk, volume_change, rest);
  const V product = hn::MulAdd(two, law.second, bend);
  const auto diagonal = [&](std::size_t i, std::size_t j, std::size_t k) {
    return hn::MulAdd(law.bulk, hn::Mul(c[i], c[i]),
                      hn::MulAdd(law.second, hn::Add(q[j], q[k]), hn::MulAdd(bend, q[i], first)));
  };
  const auto mixed = [&](std::size_t i, std::size_t j, std::size_t k) {
    return hn::MulAdd(product, c[k], hn::MulAdd(hn::Mul(law.bulk, c[i]), c[j], hn::Mul(pressure, s[k])));
  };
  t.stretch = positive_part({diagonal(0, 1, 2), diagonal(1, 2, 0), diagonal(2, 0, 1), mixed(0, 1, 2),
                             mixed(0, 2, 1), mixed(1, 2, 0)});
  for (std::size_t k = 0; k < 3; ++k) {
    const V push = hn::Mul(pressure, s[k]);
    const V twist = hn::Max(zero, hn::Add(hn::MulAdd(law.second, hn::Add(q[k], c[k]), first), push));
    const V flip = hn::Max(zero, hn::Sub(hn::MulAdd(law.second, hn::Sub(q[k], c[k]), first), push));
    t.same[k] = hn::Mul(half, hn::Add(flip, twist));
    t.other[k] = hn::Mul(half, hn::Sub(flip, twist));
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
HWY_INLINE TangentV tangent(const LawV& law, const Matrix3V& rotation, const EigenV& eigen, V volume_change) {
  TangentV t{};
  t.right = eigen.vectors;
  for (std::size_t k = 0; k < 3; ++k) t.left[k] = product(rotation, eigen.vectors[k]);
  set_principal(law, eigen.diagonal, volume_change, t);
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

HWY_INLINE void add_fibre_block(const LawV& law, const FibreV& fibre, const Vec3V& g, const Vec3V& other,
                                std::array<V, 9>& block) {
  const V weight = hn::Mul(dot(law.fibre, g), dot(law.fibre, other));
  const Vec3V& w = fibre.stretched;
  const Vec3V scaled = times(hn::Mul(weight, fibre.along), w);
  const std::array<V, 3> rows{scaled.x, scaled.y, scaled.z};
  const std::array<V, 3> columns{w.x, w.y, w.z};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) block[3 * i + j] = hn::MulAdd(rows[i], columns[j], block[3 * i + j]);
    block[4 * i] = hn::MulAdd(weight, fibre.stress, block[4 * i]);
  }
}

#endif

}  // namespace
}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
