#include "simd/hyperelastic_pass.hpp"

#include <algorithm>
#include <array>
#include <numbers>
#include <span>
#include <utility>

#include "simd/element_pass.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/hyperelastic_pass.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

#include "simd/hyperelastic_lanes-inl.hpp"
#include "simd/principal_lanes-inl.hpp"
#include "simd/twist_lanes-inl.hpp"

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
  LawV law;
  FibreV fibre;
  FactorsV factors;
  TwistV twist;
  M quick;  ///< lanes whose tangent needs no eigenvectors
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
  const V zero = hn::Zero(D());
  if (!pass.fibres)
    return {column(law_first),
            column(law_second),
            column(law_bulk),
            column(law_ambient),
            {zero, zero, zero},
            zero,
            zero,
            zero};
  return {column(law_first),
          column(law_second),
          column(law_bulk),
          column(law_ambient),
          {column(law_fibre_x), column(law_fibre_y), column(law_fibre_z)},
          column(law_fibre_stiffness),
          column(law_fibre_exponent),
          column(law_tension)};
}

/// Computes forces and energy, and begins the tangent.
HWY_INLINE void store_response(const HyperelasticPass& pass, std::size_t e, HyperelasticLot& lot,
                               double* forces) {
  const D d;
  lot.law = load_law(pass, e);
  ResponseV r = respond(lot.law, lot.h, lot.f, pass.second);
  if (pass.fibres) {
    lot.fibre = fibre_state(lot.law, lot.h);
    add_fibres(lot.law, lot.fibre, r);
  }
  lot.factors = r.factors;
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
}

using BlocksV = std::array<std::array<V, 9>, 6>;

/// Blocks of corners 1 to 3: (1,1), (1,2), (1,3), (2,2), (2,3), (3,3).
HWY_INLINE BlocksV quick_blocks(const HyperelasticLot& lot, const std::array<Vec3V, 3>& g, V volume,
                                V scale) {
  const CornersV c = corners_of(lot.factors, lot.twist, lot.f, lot.rotation, g, volume, scale);
  return {block_between<0, 0>(c), block_between<0, 1>(c), block_between<0, 2>(c),
          block_between<1, 1>(c), block_between<1, 2>(c), block_between<2, 2>(c)};
}

HWY_INLINE BlocksV principal_blocks(const HyperelasticLot& lot, const std::array<Vec3V, 3>& g, V scale) {
  TangentV t = tangent(lot.factors, lot.law.second, lot.rotation, lot.stretch);
  for (V& value : t.stretch) value = hn::Mul(scale, value);
  for (V& value : t.same) value = hn::Mul(scale, value);
  for (V& value : t.other) value = hn::Mul(scale, value);
  std::array<Vec3V, 3> turned;
  for (std::size_t k = 0; k < 3; ++k)
    turned[k] = {dot(t.right[0], g[k]), dot(t.right[1], g[k]), dot(t.right[2], g[k])};
  BlocksV blocks;
  std::size_t place = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = i; j < 3; ++j) blocks[place++] = rotated_block(t, turned[i], turned[j]);
  }
  return blocks;
}

HWY_INLINE void add_fibre_blocks(const HyperelasticLot& lot, const std::array<Vec3V, 3>& g, V scale,
                                 BlocksV& blocks) {
  const FibreV& fibre = lot.fibre;
  const FibreV scaled{fibre.stretched, fibre.energy, hn::Mul(scale, fibre.stress),
                      hn::Mul(scale, fibre.along)};
  std::size_t place = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = i; j < 3; ++j) add_fibre_block(lot.law, scaled, g[i], g[j], blocks[place++]);
  }
}

/// Number k of the blocks above the diagonal. Those of corner 0 follow from the sums of columns.
template <std::size_t k>
HWY_INLINE V stored_value(const BlocksV& b) {
  constexpr std::size_t own = k % 9;
  constexpr std::size_t back = 3 * (own % 3) + own / 3;
  if constexpr (k < 9) return hn::NegMulSub(set(1.0), hn::Add(b[0][own], b[1][back]), b[2][back]);
  if constexpr (k >= 9 && k < 18) return hn::NegMulSub(set(1.0), hn::Add(b[1][own], b[3][own]), b[4][back]);
  if constexpr (k >= 18 && k < 27) return hn::NegMulSub(set(1.0), hn::Add(b[2][own], b[4][own]), b[5][own]);
  if constexpr (k >= 27 && k < 36) return b[1][own];
  if constexpr (k >= 36 && k < 45) return b[2][own];
  if constexpr (k >= 45 && k < 54) return b[4][own];
  return hn::Zero(D());
}

template <std::size_t... fours>
HWY_INLINE void store_blocks(const BlocksV& b, float* rows, std::index_sequence<fours...>) {
  (store_float_fours({stored_value<4 * fours>(b), stored_value<4 * fours + 1>(b),
                      stored_value<4 * fours + 2>(b), stored_value<4 * fours + 3>(b)},
                     rows + 4 * fours, block_stride),
   ...);
}

/// Blocks where some lanes need eigenvectors.
HWY_NOINLINE BlocksV mixed_blocks(const HyperelasticLot& lot, const std::array<Vec3V, 3>& g, V volume,
                                  V scale) {
  BlocksV blocks = principal_blocks(lot, g, scale);
  if (hn::AllFalse(D(), lot.quick)) return blocks;
  const BlocksV quick = quick_blocks(lot, g, volume, scale);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    for (std::size_t k = 0; k < 9; ++k) blocks[b][k] = hn::IfThenElse(lot.quick, quick[b][k], blocks[b][k]);
  }
  return blocks;
}

HWY_INLINE void store_stiffness(const HyperelasticPass& pass, std::size_t e, const HyperelasticLot& lot) {
  const D d;
  const V volume = hn::LoadU(d, pass.volumes + e);
  const V scale = hn::Mul(volume, hn::LoadU(d, pass.factors + e));
  const std::array<Vec3V, 3> g = load_gradients(pass.inverse_rest, e);
  BlocksV blocks =
      hn::AllTrue(d, lot.quick) ? quick_blocks(lot, g, volume, scale) : mixed_blocks(lot, g, volume, scale);
  if (pass.fibres) add_fibre_blocks(lot, g, scale, blocks);
  store_blocks(blocks, pass.blocks + block_stride * (e - pass.first_law),
               std::make_index_sequence<block_stride / 4>());
}

/// Finds the negative part of twists, and the lanes for which nothing else is negative.
HWY_INLINE void find_twists(std::span<HyperelasticLot> lots) {
  const D d;
  for (HyperelasticLot& lot : lots) {
    lot.twist = twist_of(lot.factors, lot.root, lot.f, lot.rotation);
    lot.quick = hn::And(only_twists_negative(lot.factors, lot.root), hn::Eq(lot.law.second, hn::Zero(d)));
    lot.twist.settled = hn::Or(lot.twist.settled, hn::Not(lot.quick));
  }
  constexpr int most_steps = 8;
  for (int step = 0; step < most_steps; ++step) {
    bool done = true;
    for (HyperelasticLot& lot : lots) {
      if (hn::AllTrue(d, lot.twist.settled)) continue;
      improve(lot.twist);
      done = false;
    }
    if (done) break;
  }
  for (HyperelasticLot& lot : lots) lot.quick = hn::And(lot.quick, lot.twist.settled);
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
    const auto own = std::span(lots).first(count);
    for (std::size_t i = 0; i < count; ++i) {
      lots[i].rotation = rotation_from(lots[i].root, lots[i].f);
      const std::size_t e = first + i * lanes;
      store_response(pass, e, lots[i], pass.forces + 16 * (e - begin));
    }
    find_twists(own);
    if (!std::ranges::all_of(own, [](const auto& lot) { return hn::AllTrue(D(), lot.quick); })) {
      for (HyperelasticLot& lot : own) lot.stretch = stretch_of(lot.rotation, lot.f);
      diagonalise(own);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t e = first + i * lanes;
      store_stiffness(pass, e, lots[i]);
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
