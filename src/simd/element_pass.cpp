#include "simd/element_pass.hpp"

#include <algorithm>
#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/element_pass.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

#include "simd/rotation_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE

/// Values of a vector of elements between the phases of the pass.
struct Lot {
  Matrix3V f;
  Root root;
  M good;
};

HWY_INLINE void load_deformations(const ElementPass& pass, std::size_t e, Lot& lot) {
  const Matrix3V h = load_displacement_gradient(pass.displacements, pass.corners, pass.inverse_rest, e);
  lot.f = plus_identity(h);
  lot.root = root_of(lot.f);
}

HWY_INLINE void store_elements(const ElementPass& pass, std::size_t e, const Lot& lot, double* forces) {
  const D d;
  const std::array<Vec3V, 3> g = load_gradients(pass.inverse_rest, e);
  const Matrix3V f = lot.f;
  const Matrix3V r = rotation_from(lot.root, f);
  const Matrix3V stretch{minus(f.a, r.a), minus(f.b, r.b), minus(f.c, r.c)};
  const V ratio = hn::LoadU(d, pass.ratios + e);
  const V stiffness = hn::LoadU(d, pass.stiffness + e);
  const V trace = inner(r, stretch);
  const V bulk = hn::Mul(ratio, trace);
  const V density = hn::MulAdd(hn::Mul(hn::Set(d, 0.5), bulk), trace, inner(stretch, stretch));
  hn::StoreU(hn::Mul(stiffness, density), d, pass.energies + e);
  const V pressure = hn::Neg(hn::Mul(stiffness, bulk));
  const V twice_mu = hn::Neg(hn::Add(stiffness, stiffness));
  const V scale = hn::Sqrt(hn::Mul(hn::LoadU(d, pass.factors + e), stiffness));
  Vec3V gradient_sum{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  Vec3V force_sum = gradient_sum;
  for (std::size_t k = 1; k < 4; ++k) {
    const Vec3V turned = product(r, g[k - 1]);
    const Vec3V force = times_plus(pressure, turned, times(twice_mu, product(stretch, g[k - 1])));
    const Vec3V gradient = times(scale, turned);
    gradient_sum = plus(gradient_sum, gradient);
    force_sum = plus(force_sum, force);
    hn::StoreU(gradient.x, d, pass.turned[3 * k - 3] + e);
    hn::StoreU(gradient.y, d, pass.turned[3 * k - 2] + e);
    hn::StoreU(gradient.z, d, pass.turned[3 * k - 1] + e);
    store_quads(gradient, ratio, pass.gradients + 4 * e + k);
    store_rows(force, forces + 4 * k);
  }
  store_quads(negative(gradient_sum), ratio, pass.gradients + 4 * e);
  store_rows(negative(force_sum), forces);
  store_flags(hn::Not(lot.good), pass.left + e);
  store_flags(hn::Not(lot.good), pass.inverted + e);  // good elements have a positive determinant
}

/// Runs each phase over several vectors of elements: find_root() has dependent divisions, and independent
/// vectors hide their latency.
void element_pass(const ElementPass& pass, std::size_t begin, std::size_t end) {
  constexpr std::size_t most = 8;
  static_assert(element_group % lanes == 0);
  std::array<Lot, most> lots;
  for (std::size_t first = begin; first < end; first += most * lanes) {
    const std::size_t count = std::min(most, (end - first) / lanes);
    for (std::size_t i = 0; i < count; ++i) load_deformations(pass, first + i * lanes, lots[i]);
    for (std::size_t i = 0; i < count; ++i) lots[i].good = find_root(lots[i].root);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t e = first + i * lanes;
      store_elements(pass, e, lots[i], pass.forces + 16 * (e - begin));
    }
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
