#include "simd/hyperelastic_pass.hpp"

#include <algorithm>
#include <array>
#include <numbers>
#include <span>

#include "simd/element_pass.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/hyperelastic_pass.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

#include "simd/hyperelastic_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE

/// Values of a vector of elements between the phases of the pass.
struct HyperelasticLot {
  Matrix3V h;  ///< F - I
  Matrix3V f;
  Root root;
  M good;
  Matrix3V rotation;
  EigenV stretch;
  M unfinished;  ///< whose stretch is not diagonal
};

HWY_INLINE void load_deformations(const HyperelasticPass& pass, std::size_t e, HyperelasticLot& lot) {
  lot.h = load_displacement_gradient(pass.displacements, pass.corners, pass.inverse_rest, e);
  lot.f = plus_identity(lot.h);
  lot.root = root_of(lot.f);
}

HWY_INLINE LawV load_law(const HyperelasticPass& pass, std::size_t e) {
  const auto column = [&](LawColumn c) { return hn::LoadU(D(), pass.laws[c] + (e - pass.first_law)); };
  return {column(law_first),
          column(law_second),
          column(law_bulk),
          {column(law_fibre_x), column(law_fibre_y), column(law_fibre_z)},
          column(law_fibre_stiffness),
          column(law_fibre_exponent),
          column(law_tension)};
}

/// Computes forces and energy; returns J - 1.
HWY_INLINE V store_response(const HyperelasticPass& pass, std::size_t e, const HyperelasticLot& lot,
                            const LawV& law, const FibreV& fibre, double* forces) {
  const D d;
  const ResponseV r = respond(law, lot.h, lot.f, fibre, pass.fibres);
  const V volume = hn::LoadU(d, pass.volumes + e);
  hn::StoreU(hn::Mul(volume, r.energy), d, pass.energies + e);
  const std::array<Vec3V, 3> g = load_gradients(pass.inverse_rest, e);
  Vec3V sum{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3V force = times(hn::Neg(volume), product(r.stress, g[k]));
    sum = plus(sum, force);
    store_rows(force, forces + 4 * (k + 1));
  }
  store_rows(negative(sum), forces);
  return r.volume_change;
}

HWY_INLINE void store_stiffness(const HyperelasticPass& pass, std::size_t e, const HyperelasticLot& lot,
                                const LawV& law, const FibreV& fibre, V volume_change) {
  const D d;
  const V scale = hn::Mul(hn::LoadU(d, pass.volumes + e), hn::LoadU(d, pass.factors + e));
  TangentV t = tangent(law, lot.rotation, lot.stretch, volume_change);
  for (V& value : t.stretch) value = hn::Mul(scale, value);
  for (V& value : t.same) value = hn::Mul(scale, value);
  for (V& value : t.other) value = hn::Mul(scale, value);
  const FibreV scaled{fibre.stretched, fibre.energy, hn::Mul(scale, fibre.stress),
                      hn::Mul(scale, fibre.along)};
  const std::array<Vec3V, 3> g = load_gradients(pass.inverse_rest, e);
  std::array<Vec3V, 3> turned;
  for (std::size_t k = 0; k < 3; ++k)
    turned[k] = {dot(t.right[0], g[k]), dot(t.right[1], g[k]), dot(t.right[2], g[k])};
  std::array<V, block_stride> values;
  values.fill(hn::Zero(d));  // the first 27 values are used for sums, so they start at zero
  const auto add_to_first = [&](std::size_t corner, const std::array<V, 9>& block, bool back) {
    for (std::size_t k = 0; k < 9; ++k) {
      V& sum = values[9 * corner + k];
      sum = hn::Sub(sum, block[back ? 3 * (k % 3) + k / 3 : k]);
    }
  };
  std::size_t place = 27;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = i; j < 3; ++j) {
      std::array<V, 9> block = rotated_block(t, turned[i], turned[j]);
      if (pass.fibres) add_fibre_block(law, scaled, g[i], g[j], block);
      add_to_first(j, block, false);
      if (i == j) continue;
      add_to_first(i, block, true);
      for (std::size_t k = 0; k < 9; ++k) values[place + k] = block[k];
      place += 9;
    }
  }
  double* rows = pass.blocks + block_stride * (e - pass.first_law);
  for (std::size_t k = 0; k < block_stride; k += 4)
    store_fours({values[k], values[k + 1], values[k + 2], values[k + 3]}, rows + k, block_stride);
}

/// Lanes with an entry off the diagonal that matters for the tangent.
HWY_INLINE M unfinished(const EigenV& m) {
  const V off = hn::Max(hn::Abs(m.off[0]), hn::Max(hn::Abs(m.off[1]), hn::Abs(m.off[2])));
  const V size = hn::Max(hn::Abs(m.diagonal[0]), hn::Max(hn::Abs(m.diagonal[1]), hn::Abs(m.diagonal[2])));
  return hn::Gt(off, hn::Mul(set(1e-13), size));
}

/// Diagonalises the stretches. A lane that is diagonal keeps its bits, whatever its neighbours need.
HWY_INLINE void diagonalise(std::span<HyperelasticLot> lots) {
  const D d;
  for (int sweep = 0; sweep < tangent_sweeps; ++sweep) {
    bool done = true;
    for (HyperelasticLot& lot : lots) {
      lot.unfinished = unfinished(lot.stretch);
      done = done && hn::AllFalse(d, lot.unfinished);
    }
    if (done) return;
    for (HyperelasticLot& lot : lots) rotate<0, 1>(lot.stretch, lot.unfinished);
    for (HyperelasticLot& lot : lots) rotate<0, 2>(lot.stretch, lot.unfinished);
    for (HyperelasticLot& lot : lots) rotate<1, 2>(lot.stretch, lot.unfinished);
  }
}

/// Runs each phase over several vectors of elements: roots and rotations have dependent divisions, and
/// independent vectors hide their latency.
void hyperelastic_pass(const HyperelasticPass& pass, std::size_t begin, std::size_t end) {
  constexpr std::size_t most = 4;
  static_assert(element_group % lanes == 0);
  std::array<HyperelasticLot, most> lots;
  for (std::size_t first = begin; first < end; first += most * lanes) {
    const std::size_t count = std::min(most, (end - first) / lanes);
    for (std::size_t i = 0; i < count; ++i) load_deformations(pass, first + i * lanes, lots[i]);
    for (std::size_t i = 0; i < count; ++i) lots[i].good = find_root(lots[i].root);
    for (std::size_t i = 0; i < count; ++i) {
      lots[i].rotation = rotation_from(lots[i].root, lots[i].f);
      lots[i].stretch = stretch_of(lots[i].rotation, lots[i].f);
    }
    diagonalise(std::span(lots).first(count));
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t e = first + i * lanes;
      const LawV law = load_law(pass, e);
      FibreV fibre{};
      if (pass.fibres) fibre = fibre_state(law, lots[i].h);
      const V change = store_response(pass, e, lots[i], law, fibre, pass.forces + 16 * (e - begin));
      store_stiffness(pass, e, lots[i], law, fibre, change);
      store_flags(hn::Not(lots[i].good), pass.left + e);
      store_flags(hn::Not(lots[i].good), pass.inverted + e);  // good elements have a positive determinant
    }
  }
}

#else

void hyperelastic_pass(const HyperelasticPass& pass, std::size_t begin, std::size_t end) {
  std::fill(pass.left + begin, pass.left + end, std::uint8_t{1});
}

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(hyperelastic_pass);

void hyperelastic_pass(const HyperelasticPass& pass, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(hyperelastic_pass)(pass, begin, end);
}

}  // namespace palpate::simd
#endif
