#include "simd/element_pass.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/element_pass.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own header after foreach_target.h.
#include <hwy/highway.h>

#include "simd/tet_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE

/// One step X <- (g X + X^-T / g) / 2, with g = sqrt(|X^-1| / |X|) or 1 (fem/rotation.hpp); returns the
/// square of the change.
template <bool scaled>
HWY_INLINE V polar_step(Matrix3V& x) {
  const D d;
  const V half = hn::Set(d, 0.5);
  const Matrix3V c = cofactors(x);
  const V det = dot(x.a, c.a);
  V a = half;
  V b = hn::Div(half, det);
  if (scaled) {
    const V ratio = hn::Sqrt(hn::Div(inner(c, c), inner(x, x)));
    const V g = hn::Sqrt(hn::Div(ratio, det));
    a = hn::Mul(half, g);
    b = hn::Div(b, g);
  }
  const Matrix3V next{times_plus(b, c.a, times(a, x.a)), times_plus(b, c.b, times(a, x.b)),
                      times_plus(b, c.c, times(a, x.c))};
  const Matrix3V change{minus(next.a, x.a), minus(next.b, x.b), minus(next.c, x.c)};
  x = next;
  return inner(change, change);
}

/// Rotations of two vectors of matrices: their steps wait for divisions and roots, and so wait together.
/// Tells where they have converged.
HWY_INLINE void polar(Matrix3V& x, Matrix3V& y, M& x_done, M& y_done) {
  const D d;
  constexpr int cap = 10;
  const V small =
      hn::Set(d, 1e-14);  // convergence is quadratic: a change of 1e-7 leaves an error of its square
  const V near = hn::Set(d, 1e-2);  // from here scaling changes nothing
  bool scaled = true;
  for (int i = 0; i < cap; ++i) {
    const V x_change = scaled ? polar_step<true>(x) : polar_step<false>(x);
    const V y_change = scaled ? polar_step<true>(y) : polar_step<false>(y);
    x_done = hn::Lt(x_change, small);
    y_done = hn::Lt(y_change, small);
    const V most = hn::Max(x_change, y_change);
    if (hn::AllTrue(d, hn::Lt(most, small))) break;
    scaled = scaled && !hn::AllTrue(d, hn::Lt(most, near));
  }
}

HWY_INLINE V largest_entry(const Vec3V& a) {
  return hn::Max(hn::Abs(a.x), hn::Max(hn::Abs(a.y), hn::Abs(a.z)));
}

HWY_INLINE void store_flags(M mask, std::uint8_t* flags) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(D(), mask, bits);
  for (std::size_t k = 0; k < lanes; ++k) flags[k] = static_cast<std::uint8_t>((bits[0] >> k) & 1U);
}

/// A vector of elements between the steps of the pass.
struct Lot {
  Vec3V g1, g2, g3;  // gradients at rest
  Matrix3V f, r;
  M good;
};

HWY_INLINE Lot load_lot(const ElementPass& pass, std::size_t e) {
  const D d;
  Lot lot;
  const auto column = [&](std::size_t k) { return hn::LoadU(d, pass.inverse_rest[k] + e); };
  const auto displacement = [&](std::size_t corner) {
    return load_rows(pass.displacements, pass.corners + 4 * e + corner);
  };
  lot.g1 = {column(0), column(1), column(2)};
  lot.g2 = {column(3), column(4), column(5)};
  lot.g3 = {column(6), column(7), column(8)};
  const Vec3V origin = displacement(0);
  const Vec3V u1 = minus(displacement(1), origin);
  const Vec3V u2 = minus(displacement(2), origin);
  const Vec3V u3 = minus(displacement(3), origin);
  const V one = hn::Set(d, 1.0);
  const auto row = [&](V p, V q, V r) {
    return times_plus(p, lot.g1, times_plus(q, lot.g2, times(r, lot.g3)));
  };
  Matrix3V f{row(u1.x, u2.x, u3.x), row(u1.y, u2.y, u3.y), row(u1.z, u2.z, u3.z)};
  f.a.x = hn::Add(f.a.x, one);
  f.b.y = hn::Add(f.b.y, one);
  f.c.z = hn::Add(f.c.z, one);

  // As in fem/rotation.cpp: with the largest entry 1, Newton converges in a few steps above this determinant.
  constexpr double healthy = 0.01;
  const V det = dot(f.a, cross(f.b, f.c));
  const V size = hn::Max(largest_entry(f.a), hn::Max(largest_entry(f.b), largest_entry(f.c)));
  const V least = hn::Mul(hn::Set(d, healthy), hn::Mul(size, hn::Mul(size, size)));
  lot.good = hn::And(hn::Gt(det, least), hn::Lt(size, hn::Set(d, 1e50)));
  // What is left becomes the identity, so that it holds nobody up.
  const auto keep = [&](V value, double other) { return hn::IfThenElse(lot.good, value, hn::Set(d, other)); };
  lot.f = {{keep(f.a.x, 1.0), keep(f.a.y, 0.0), keep(f.a.z, 0.0)},
           {keep(f.b.x, 0.0), keep(f.b.y, 1.0), keep(f.b.z, 0.0)},
           {keep(f.c.x, 0.0), keep(f.c.y, 0.0), keep(f.c.z, 1.0)}};
  lot.r = lot.f;
  return lot;
}

HWY_INLINE void store_lot(const ElementPass& pass, std::size_t e, const Lot& lot, M done) {
  const D d;
  const Matrix3V& f = lot.f;
  const Matrix3V& r = lot.r;
  const Matrix3V stretch{minus(f.a, r.a), minus(f.b, r.b), minus(f.c, r.c)};
  const V minus_volume = hn::Neg(hn::LoadU(d, pass.volume + e));
  const V mu = hn::LoadU(d, pass.mu + e);
  const V trace = inner(r, stretch);
  const V bulk = hn::Mul(hn::LoadU(d, pass.lambda + e), trace);
  const V pressure = hn::Mul(minus_volume, bulk);
  const V density = hn::MulAdd(mu, inner(stretch, stretch), hn::Mul(hn::Set(d, 0.5), hn::Mul(bulk, trace)));
  hn::StoreU(hn::NegMulAdd(minus_volume, density, hn::Zero(d)), d, pass.energies + e);
  const V twice_mu = hn::Mul(minus_volume, hn::Add(mu, mu));
  const V scale = hn::Sqrt(hn::Neg(hn::Mul(hn::Mul(hn::LoadU(d, pass.factors + e), mu), minus_volume)));
  const V ratio = hn::LoadU(d, pass.ratios + e);
  Vec3V gradient_sum{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  Vec3V force_sum = gradient_sum;
  const auto corner = [&](std::size_t k, const Vec3V& g) {
    const Vec3V turned = product(r, g);
    const Vec3V force = times_plus(pressure, turned, times(twice_mu, product(stretch, g)));
    const Vec3V gradient = times(scale, turned);
    gradient_sum = plus(gradient_sum, gradient);
    force_sum = plus(force_sum, force);
    hn::StoreU(gradient.x, d, pass.turned[3 * k - 3] + e);
    hn::StoreU(gradient.y, d, pass.turned[3 * k - 2] + e);
    hn::StoreU(gradient.z, d, pass.turned[3 * k - 1] + e);
    store_quads(gradient, ratio, pass.gradients + 4 * e + k);
    store_rows(force, pass.forces + 16 * e + 4 * k);
  };
  corner(1, lot.g1);
  corner(2, lot.g2);
  corner(3, lot.g3);
  store_quads(negative(gradient_sum), ratio, pass.gradients + 4 * e);
  store_rows(negative(force_sum), pass.forces + 16 * e);
  done = hn::And(done, lot.good);
  store_flags(hn::Not(done), pass.left + e);
  store_flags(hn::Not(done), pass.inverted + e);  // what is done has a positive determinant
}

void element_pass(const ElementPass& pass, std::size_t begin, std::size_t end) {
  const D d;
  static_assert(element_group % (2 * lanes) == 0);
  for (std::size_t e = begin; e < end; e += 2 * lanes) {
    Lot first = load_lot(pass, e);
    Lot second = load_lot(pass, e + lanes);
    M first_done = hn::FirstN(d, 0);
    M second_done = first_done;
    polar(first.r, second.r, first_done, second_done);
    store_lot(pass, e, first, first_done);
    store_lot(pass, e + lanes, second, second_done);
  }
}

#else

void element_pass(const ElementPass& pass, std::size_t begin, std::size_t end) {
  std::fill(pass.left + begin, pass.left + end, std::uint8_t{1});
}

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(element_pass);

void element_pass(const ElementPass& pass, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(element_pass)(pass, begin, end);
}

}  // namespace palpate::simd
#endif
