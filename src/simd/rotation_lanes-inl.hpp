// Rotations of tets in lanes. Included once for each target.
#if defined(PALPATE_SIMD_ROTATION_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_SIMD_ROTATION_LANES_INL
#undef PALPATE_SIMD_ROTATION_LANES_INL
#else
#define PALPATE_SIMD_ROTATION_LANES_INL
#endif

#include <array>
#include <cstddef>
#include <cstdint>
#include <hwy/highway.h>

#include "simd/tet_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {

#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE

/// Invariants of F and the current root; they determine the rotation.
struct Root {
  V first, second, det;  // I, II, J
  V root;
};

/// l^3 - I l - 2 J, a quarter of the derivative.
HWY_INLINE V slope(const Root& r) {
  const V inside = hn::MulSub(r.root, r.root, r.first);
  return hn::MulSub(inside, r.root, hn::Add(r.det, r.det));
}

/// One step of Halley's iteration (third order) in the lanes that have not converged. Returns the size of the
/// step.
HWY_INLINE V improve(Root& r, M converged) {
  const D d;
  const V square = hn::Mul(r.root, r.root);
  const V twice_det = hn::Add(r.det, r.det);
  const V inside = hn::Sub(square, r.first);
  const V derivative = hn::MulSub(inside, r.root, twice_det);  // a quarter of the derivative
  // A quarter of the value, (l^2 - I)^2 / 4 - 2 J l - II, and of half the second derivative.
  const V value =
      hn::MulSub(hn::Mul(hn::Set(d, 0.25), inside), inside, hn::MulAdd(twice_det, r.root, r.second));
  const V curvature = hn::MulSub(hn::Set(d, 1.5), square, hn::Mul(hn::Set(d, 0.5), r.first));
  const V step =
      hn::Div(hn::Mul(value, derivative), hn::MulSub(derivative, derivative, hn::Mul(value, curvature)));
  r.root = hn::IfThenElse(converged, r.root, hn::Sub(r.root, step));
  return hn::Abs(step);
}

/// Iterates from sqrt(3 I), an upper bound whose error is of second order in the strain. Returns the lanes
/// with a usable root: those whose determinant is positive and so large that rotation_from() does not lose
/// digits by cancellation. Converged lanes no longer change, so that their bits do not depend on other lanes.
HWY_INLINE M find_root(Root& root) {
  const D d;
  constexpr int cap = 8;
  const V cube = hn::Mul(root.first, hn::Mul(root.first, root.first));
  const V least = hn::Mul(hn::Set(d, 1e-5), cube);
  // Within these limits no power overflows or underflows.
  const M healthy = hn::And(hn::Gt(hn::Mul(root.det, root.det), least), hn::Gt(root.det, hn::Set(d, 1e-60)));
  const M usable = hn::And(healthy, hn::Lt(root.first, hn::Set(d, 1e60)));
  // Relative size of the last step. Convergence is cubic: the remaining error is below rounding.
  const V small = hn::Set(d, 2e-6);
  root.root = hn::Sqrt(hn::Mul(hn::Set(d, 3.0), root.first));
  M converged = hn::Not(usable);
  for (int i = 0; i < cap; ++i) {
    const V step = improve(root, converged);
    converged = hn::Or(converged, hn::Le(step, hn::Mul(small, root.root)));
    if (hn::AllTrue(d, converged)) break;
  }
  return hn::And(usable, converged);
}

/// R from F, its invariants and the root.
HWY_INLINE Matrix3V rotation_from(const Root& root, const Matrix3V& f) {
  const D d;
  const Matrix3V c = cofactors(f);
  const V scale = hn::Div(hn::Set(d, 1.0), slope(root));
  const V whole = hn::Mul(scale, hn::MulAdd(root.root, root.root, root.first));
  const V twice = hn::Add(scale, scale);
  const V turned = hn::Mul(twice, root.root);
  // Entries of the matrix (whole I - twice F F^T) that multiplies F.
  const auto entry = [&](const Vec3V& a, const Vec3V& b) { return hn::Neg(hn::Mul(twice, dot(a, b))); };
  const V xx = hn::Add(whole, entry(f.a, f.a));
  const V yy = hn::Add(whole, entry(f.b, f.b));
  const V zz = hn::Add(whole, entry(f.c, f.c));
  const V xy = entry(f.a, f.b);
  const V xz = entry(f.a, f.c);
  const V yz = entry(f.b, f.c);
  const auto row = [&](V p, V q, V s, const Vec3V& cofactor) {
    return times_plus(p, f.a, times_plus(q, f.b, times_plus(s, f.c, times(turned, cofactor))));
  };
  return {row(xx, xy, xz, c.a), row(xy, yy, yz, c.b), row(xz, yz, zz, c.c)};
}

HWY_INLINE void store_flags(M mask, std::uint8_t* flags) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(D(), mask, bits);
  for (std::size_t k = 0; k < lanes; ++k) flags[k] = static_cast<std::uint8_t>((bits[0] >> k) & 1U);
}

/// Gradients of the shape functions of corners 1 to 3.
HWY_INLINE std::array<Vec3V, 3> load_gradients(const std::array<const double*, 9>& inverse_rest,
                                               std::size_t e) {
  const auto column = [&](std::size_t k) { return hn::LoadU(D(), inverse_rest[k] + e); };
  return {Vec3V{column(0), column(1), column(2)}, Vec3V{column(3), column(4), column(5)},
          Vec3V{column(6), column(7), column(8)}};
}

/// H = F - I of elements from their displacements, so that F is exactly I at rest.
HWY_INLINE Matrix3V load_displacement_gradient(const Padded3* displacements, const std::int32_t* corners,
                                               const std::array<const double*, 9>& inverse_rest,
                                               std::size_t e) {
  const std::array<Vec3V, 3> g = load_gradients(inverse_rest, e);
  const auto displacement = [&](std::size_t corner) {
    return load_rows(displacements, corners + 4 * e + corner);
  };
  const Vec3V origin = displacement(0);
  const Vec3V u1 = minus(displacement(1), origin);
  const Vec3V u2 = minus(displacement(2), origin);
  const Vec3V u3 = minus(displacement(3), origin);
  const auto row = [&](V p, V q, V r) { return times_plus(p, g[0], times_plus(q, g[1], times(r, g[2]))); };
  return {row(u1.x, u2.x, u3.x), row(u1.y, u2.y, u3.y), row(u1.z, u2.z, u3.z)};
}

HWY_INLINE Matrix3V plus_identity(Matrix3V m) {
  const V one = hn::Set(D(), 1.0);
  m.a.x = hn::Add(m.a.x, one);
  m.b.y = hn::Add(m.b.y, one);
  m.c.z = hn::Add(m.c.z, one);
  return m;
}

/// Invariants of F, without the root.
HWY_INLINE Root root_of(const Matrix3V& f) {
  const Matrix3V c = cofactors(f);
  return {inner(f, f), inner(c, c), dot(f.a, c.a), hn::Zero(D())};
}

#endif

}  // namespace
}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
