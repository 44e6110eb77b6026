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
  V first, second, bulk, ambient;
  Vec3V fibre;
  V fibre_stiffness, fibre_exponent, tension;
};
/// Energy w of the fibres, and coefficients of stress and tangent.
struct FibreV {
  Vec3V stretched;
  V energy, stress, along;
};
/// Factors of the tangent, see twist_lanes-inl.hpp.
struct FactorsV {
  V linear;    ///< m = first (1 - 1/(I1 + 1))
  V bend;      ///< 2 first / (I1 + 1)^2
  V pressure;  ///< p = bulk (J - 1) - (3/4 first + 2 second - ambient)
  V bulk;
};
struct ResponseV {
  V energy;
  Matrix3V stress;
  FactorsV factors;
};
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

/// Adds the terms of the second invariant: the energy, and (I1 - F F^T) F times its modulus.
HWY_INLINE void add_second(V second, V i1, const Matrix3V& h, const Matrix3V& f, ResponseV& r) {
  // cof F - I = tr(H) I - H^T + cof H, without cancellation near rest
  const V trace = hn::Add(h.a.x, hn::Add(h.b.y, h.c.z));
  const Matrix3V ch = cofactors(h);
  Matrix3V k{minus(ch.a, {h.a.x, h.b.x, h.c.x}), minus(ch.b, {h.a.y, h.b.y, h.c.y}),
             minus(ch.c, {h.a.z, h.b.z, h.c.z})};
  k.a.x = hn::Add(k.a.x, trace);
  k.b.y = hn::Add(k.b.y, trace);
  k.c.z = hn::Add(k.c.z, trace);
  const V trace_ch = hn::Add(ch.a.x, hn::Add(ch.b.y, ch.c.z));
  const V y = hn::MulAdd(set(2.0), hn::MulAdd(set(2.0), trace, trace_ch), inner(k, k));  // I2 - 3
  r.energy = hn::MulAdd(hn::Mul(set(0.5), second), y, r.energy);
  const auto entry = [&](const Vec3V& a, const Vec3V& b) { return hn::Neg(hn::Mul(second, dot(a, b))); };
  const V whole = hn::Mul(second, i1);
  const V xx = hn::Add(whole, entry(f.a, f.a));
  const V yy = hn::Add(whole, entry(f.b, f.b));
  const V zz = hn::Add(whole, entry(f.c, f.c));
  const V xy = entry(f.a, f.b);
  const V xz = entry(f.a, f.c);
  const V yz = entry(f.b, f.c);
  const auto row = [&](V p, V q, V s, const Vec3V& stress) {
    return times_plus(p, f.a, times_plus(q, f.b, times_plus(s, f.c, stress)));
  };
  r.stress = {row(xx, xy, xz, r.stress.a), row(xy, yy, yz, r.stress.b), row(xz, yz, zz, r.stress.c)};
}

/// \param second  whether a lane has a modulus of the second invariant
HWY_INLINE ResponseV respond(const LawV& law, const Matrix3V& h, const Matrix3V& f, bool second) {
  const V one = set(1.0);
  const V trace = hn::Add(h.a.x, hn::Add(h.b.y, h.c.z));
  const Vec3V first_row = cross(h.b, h.c);
  const V yy = hn::MulSub(h.c.z, h.a.x, hn::Mul(h.c.x, h.a.z));
  const V zz = hn::MulSub(h.a.x, h.b.y, hn::Mul(h.a.y, h.b.x));
  const V trace_ch = hn::Add(first_row.x, hn::Add(yy, zz));
  const V j = hn::Add(hn::Add(trace, trace_ch), dot(h.a, first_row));  // J - 1 without cancellation
  const V x = hn::MulAdd(set(2.0), trace, inner(h, h));
  const V rest = hn::MulAdd(set(0.75), law.first, hn::MulSub(set(2.0), law.second, law.ambient));
  const V half = set(0.5);
  const V log = log_of_one_plus(hn::Mul(set(0.25), x));
  const V i1 = hn::Add(x, set(3.0));
  const V weight = hn::Div(one, hn::Add(i1, one));
  const V linear = hn::Mul(law.first, hn::Sub(one, weight));
  const V bend = hn::Mul(hn::Mul(set(2.0), law.first), hn::Mul(weight, weight));
  const V pressure = hn::MulSub(law.bulk, j, rest);
  const auto row = [&](const Vec3V& own, const Vec3V& cofactor) {
    return times_plus(linear, own, times(pressure, cofactor));
  };
  ResponseV r;
  r.factors = {linear, bend, pressure, law.bulk};
  r.energy = hn::Mul(hn::Mul(half, law.first), hn::Sub(x, log));
  r.energy = hn::MulAdd(j, hn::MulSub(hn::Mul(half, law.bulk), j, rest), r.energy);
  const Matrix3V c = cofactors(f);
  r.stress = {row(f.a, c.a), row(f.b, c.b), row(f.c, c.c)};
  if (second) add_second(law.second, i1, h, f, r);
  return r;
}

HWY_INLINE void add_fibres(const LawV& law, const FibreV& fibre, ResponseV& r) {
  r.energy = hn::Add(r.energy, fibre.energy);
  const Vec3V w = times(fibre.stress, fibre.stretched);
  r.stress = {times_plus(w.x, law.fibre, r.stress.a), times_plus(w.y, law.fibre, r.stress.b),
              times_plus(w.z, law.fibre, r.stress.c)};
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
