// Elements with tangent blocks: hyperelastic tets and bodies with smoothed tets; and fibres.
#include <algorithm>
#include <cstddef>

#include "fem/elements.hpp"
#include "fem/padded_vectors.hpp"
#include "fem/pulled_tangent.hpp"
#include "fem/row_order.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

using simd::block_stride;

bool is_hyperelastic_tet(const Materials& materials, Index tet, Index body) {
  return materials.of(tet, body).model != MaterialModel::corotational;
}

/// The unit vector along the fibres of a tet; zero where its material has none.
Vec3 fibre_of(const Materials& materials, Index tet, const Material& material) {
  if (!material.fibres.any()) return {};
  Vec3 direction = material.fibres.direction;
  if (!materials.fibre_of_tet.empty() && at(materials.fibre_of_tet, tet) != Vec3{})
    direction = at(materials.fibre_of_tet, tet);
  return (1.0 / length(direction)) * direction;
}

bool is_smoothed_tet(const Materials& materials, Index tet, Index body) {
  return materials.of(tet, body).elements == ElementKind::smoothed;
}

/// The stiffness of an element times the vectors at its corners. Blocks of a row add up to zero.
/// \param block  function: the block of two different corners
template <class Block>
std::array<Vec3, 4> product_of(const std::array<Vec3, 4>& vectors, const Block& block) {
  std::array<Vec3, 4> products;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      if (i != j) at(products, i) += block(i, j) * (at(vectors, j) - at(vectors, i));
    }
  }
  return products;
}

/// Kinds of bodies, by how the stiffness of their tets is stored.
enum class BodyModel : std::uint8_t { low_rank, tangent_blocks, nonlinear };

BodyModel model_of(const Bodies& bodies, const Materials& materials, Index body) {
  const Range tets = at(bodies.bodies(), body).tets;
  BodyModel model = BodyModel::low_rank;
  for (Index tet = tets.begin; tet < tets.end; ++tet) {
    if (is_hyperelastic_tet(materials, tet, body)) return BodyModel::nonlinear;
    if (is_smoothed_tet(materials, tet, body)) model = BodyModel::tangent_blocks;
  }
  return model;
}

}  // namespace

/// Adds all bodies: those with tangent blocks last. Within each, corotational tets are first and smoothed
/// ones last.
void Elements::add_bodies(const Bodies& bodies, const Materials& materials,
                          std::span<const std::uint8_t> obstacles) {
  const std::vector<Index> order = tets_along_curve(bodies);
  const auto add = [&](Index body, auto&& belongs) {
    const Range tets = at(bodies.bodies(), body).tets;
    for (Index place = tets.begin; place < tets.end; ++place) {
      const Index tet = at(order, place);
      if (belongs(tet)) add_element(bodies, tet, body, materials);
    }
  };
  const auto add_all = [&](BodyModel model) {
    for (Index body = 0; body < bodies.body_count(); ++body) {
      if (at(obstacles, body) != 0 || model_of(bodies, materials, body) != model) continue;
      const auto is_smoothed = [&](Index tet) { return is_smoothed_tet(materials, tet, body); };
      for (const bool hyperelastic : {false, true}) {
        add(body, [&](Index tet) {
          return !is_smoothed(tet) && is_hyperelastic_tet(materials, tet, body) == hyperelastic;
        });
      }
      add(body, is_smoothed);
    }
  };
  add_all(BodyModel::low_rank);
  tangent_begin_ = size();
  add_all(BodyModel::tangent_blocks);
  nonlinear_begin_ = size();
  add_all(BodyModel::nonlinear);
  for (std::size_t e = static_cast<std::size_t>(tangent_begin_); e < tets_.size(); ++e)
    add_law(materials, tets_[e], body_[e]);
  add_smoothing(bodies, materials);
  if (material_.empty()) return;
  // Kernels read and write whole groups, but never the last element here.
  const std::size_t whole = material_.size() + simd::element_group;
  for (auto& column : laws_) column.resize(whole);
  blocks_.resize(block_stride * whole);
}

void Elements::add_law(const Materials& materials, Index tet, Index body) {
  const Material& material = materials.of(tet, body);
  const auto [first, second] = invariant_moduli(material);
  const std::size_t element = static_cast<std::size_t>(tangent_begin_) + material_.size();
  const Vec3 fibre = fibre_of(materials, tet, material);
  const Fibres& fibres = material.fibres;
  const std::array<double, simd::law_columns> law{first,   second,           bulk_of(lambda_[element], first),
                                                  0.0,     fibre.x,          fibre.y,
                                                  fibre.z, fibres.stiffness, fibres.exponent,
                                                  0.0};
  for (std::size_t k = 0; k < law.size(); ++k) laws_[k].push_back(law[k]);
  second_invariant_ = second_invariant_ || second != 0.0;
  fibres_ = fibres_ || fibres.any();
  hyperelastic_.push_back(is_hyperelastic_tet(materials, tet, body) ? 1 : 0);
  smoothed_.push_back(is_smoothed_tet(materials, tet, body) ? 1 : 0);
  has_jumps_ = has_jumps_ || fibres.stiffness > 0.0;
  pulls_.push_back(hyperelastic_.back() != 0 && fibres.any() && smoothed_.back() == 0 ? 1 : 0);
  material_.push_back(materials.index_of(tet, body));
  active_stress_.push_back(fibres.active_stress);
  tension_.push_back(0.0);
  ambient_.push_back(0.0);
}

void Elements::add_smoothing(const Bodies& bodies, const Materials& materials) {
  std::vector<SmoothedTet> tets;
  for (std::size_t e = static_cast<std::size_t>(tangent_begin_); e < tets_.size(); ++e) {
    if (!is_smoothed(e)) continue;
    SmoothedTet tet{.element = static_cast<Index>(e),
                    .material = materials.index_of(tets_[e], body_[e]),
                    .corners = corners_[e],
                    .volume = volume_[e],
                    .mu = mu_[e],
                    .lambda = lambda_[e],
                    .hyperelastic = is_hyperelastic(e),
                    .law = whole_law_of(e)};
    for (int k = 0; k < 4; ++k) tet.gradients[static_cast<std::size_t>(k)] = gradient_rest(e, k);
    tets.push_back(tet);
  }
  if (!tets.empty())
    smoothing_ = SmoothingDomains(std::move(tets), bodies.points_rest().size(), materials.all);
}

std::vector<HyperelasticResponse> Elements::smoothed_responses(
    const parallel::Threads& threads, std::span<const simd::Padded3> displacements) const {
  return smoothing_.responses(threads, displacements, bulk_fraction_);
}

bool Elements::set_activations(std::span<const double> activations) {
  bool changed = false;
  for (std::size_t k = 0; k < material_.size(); ++k) {
    const double tension = active_stress_[k] == 0.0 ? 0.0 : at(activations, material_[k]) * active_stress_[k];
    changed = changed || tension_[k] != tension;
    tension_[k] = tension;
  }
  if (!changed) return false;
  set_inviscid();
  return true;
}

std::vector<std::uint8_t> Elements::ambient_bodies(std::size_t body_count) const {
  std::vector<std::uint8_t> takes(body_count, 0);
  for (std::size_t e = 0; e < tets_.size(); ++e) at(takes, body_[e]) = 1;
  for (std::size_t e = 0; e < tets_.size(); ++e)
    if (is_corotational(e)) at(takes, body_[e]) = 0;
  return takes;
}

bool Elements::set_ambient(std::span<const double> pressures) {
  bool changed = false;
  for (std::size_t k = 0; k < ambient_.size(); ++k) {
    const Index body = body_[static_cast<std::size_t>(tangent_begin_) + k];
    const double ambient = pressures.empty() ? 0.0 : at(pressures, body);
    changed = changed || ambient_[k] != ambient;
    ambient_[k] = ambient;
  }
  if (changed) set_inviscid();
  return changed;
}

/// The law that the kernel uses, with the full bulk modulus. Viscosity makes it stiffer in a step, except for
/// the active tension and the ambient pressure.
HyperelasticLaw Elements::whole_law_of(std::size_t element) const {
  const auto value = [&](simd::LawColumn column) {
    return laws_[column][element - static_cast<std::size_t>(tangent_begin_)];
  };
  return {value(simd::law_first),
          value(simd::law_second),
          value(simd::law_bulk),
          {value(simd::law_fibre_x), value(simd::law_fibre_y), value(simd::law_fibre_z)},
          value(simd::law_fibre_stiffness),
          value(simd::law_fibre_exponent),
          value(simd::law_tension),
          value(simd::law_ambient)};
}

HyperelasticLaw Elements::law_of(std::size_t element) const {
  HyperelasticLaw law = whole_law_of(element);
  if (bulk_fraction_[element] != 1.0)
    law.bulk = bulk_of(bulk_fraction_[element] * lambda_[element], law.first);
  return law;
}

simd::HyperelasticPass Elements::hyperelastic_pass(const simd::ElementPass& pass) {
  simd::HyperelasticPass own{};
  own.displacements = pass.displacements;
  own.corners = pass.corners;
  own.inverse_rest = pass.inverse_rest;
  own.volumes = volume_.data();
  own.factors = pass.factors;
  for (std::size_t k = 0; k < laws_.size(); ++k) own.laws[k] = laws_[k].data();
  own.first_law = static_cast<std::size_t>(tangent_begin_);
  own.second = second_invariant_;
  own.fibres = fibres_;
  own.energies = pass.energies;
  own.inverted = pass.inverted;
  own.left = pass.left;
  own.blocks = blocks_.data();
  return own;
}

/// H = F - I.
Matrix3 Elements::displacement_gradient(std::size_t element, std::span<const Vec3> positions) const {
  const Tet& corners = corners_[element];
  const auto displacement = [&](std::size_t corner) {
    return at(positions, corners[corner]) - at(points_rest_, corners[corner]);
  };
  Matrix3 h;
  for (int corner = 1; corner < 4; ++corner) {
    const Vec3 difference = displacement(static_cast<std::size_t>(corner)) - displacement(0);
    add_outer(h, 1.0, difference, gradient_rest(element, corner));
  }
  return h;
}

void Elements::update_hyperelastic(std::size_t element, std::span<const Vec3> positions, double* forces) {
  const Matrix3 h = displacement_gradient(element, positions);
  inverted_[element] = determinant(plus_identity(h)) > 0.0 ? 0 : 1;
  const HyperelasticLaw law = law_of(element);
  const HyperelasticResponse response = respond(law, h);
  energy_[element] = volume_[element] * response.energy_density;
  const std::array gradients{gradient_rest(element, 1), gradient_rest(element, 2), gradient_rest(element, 3)};
  Vec3 sum;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 force = -volume_[element] * (response.stress * gradients[k]);
    sum += force;
    store(force, forces + 4 * (k + 1));
  }
  store(-sum, forces);
  const std::size_t place = block_stride * (element - static_cast<std::size_t>(tangent_begin_));
  std::array<double, tangent_values> blocks{};
  put_blocks(tangent(law, h, simd::kept_part), law.fibre, gradients, factor_[element] * volume_[element],
             blocks);
  std::ranges::transform(blocks, &blocks_[place], [](double value) { return static_cast<float>(value); });
}

/// Replaces the tangent blocks of an element whose fibres pull (put_pulled_blocks()).
void Elements::put_pulled(std::size_t element, std::span<const Vec3> positions) {
  const std::array gradients{gradient_rest(element, 1), gradient_rest(element, 2), gradient_rest(element, 3)};
  std::array<double, tangent_values> blocks{};
  if (!put_pulled_blocks(law_of(element), displacement_gradient(element, positions), gradients,
                         factor_[element] * volume_[element], blocks))
    return;
  float* const own = &blocks_[block_stride * (element - static_cast<std::size_t>(tangent_begin_))];
  std::ranges::transform(blocks, own, [](double value) { return static_cast<float>(value); });
}

void Elements::put_corotational_blocks(std::size_t element) {
  float* blocks = &blocks_[block_stride * (element - static_cast<std::size_t>(tangent_begin_))];
  for (int i = 0; i < 3; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      const Matrix3 block = low_rank_block(static_cast<Index>(element), i, j);
      for (std::size_t k = 0; k < 9; ++k) blocks[block_place(i, j) + k] = static_cast<float>(block.values[k]);
    }
  }
}

const float* Elements::element_tangent(Index element) const {
  return &blocks_[block_stride * static_cast<std::size_t>(element - tangent_begin_)];
}

void Elements::release_damping() {
  held_.clear();
  smoothing_.release_damping();
}

void Elements::hold_damping() {
  held_.resize(blocks_.size());
  for (std::size_t k = 0; k < pulls_.size(); ++k) {
    const std::size_t element = static_cast<std::size_t>(tangent_begin_) + k;
    if (!jumps(element)) continue;
    const double damping = 1.0 - elastic_fractions_[element];
    for (std::size_t v = block_stride * k; v < block_stride * (k + 1); ++v)
      held_[v] = static_cast<float>(damping * static_cast<double>(blocks_[v]));
  }
  smoothing_.hold_damping();
}

bool Elements::is_held(Index element) const {
  return !held_.empty() && jumps(static_cast<std::size_t>(element));
}

/// Where fibres of an element may pull, replaces its tangent blocks by the whole tangent. Where its damping
/// is held, replaces the damping in them.
void Elements::finish_tangent(std::size_t element, std::span<const Vec3> positions) {
  const std::size_t own = element - static_cast<std::size_t>(tangent_begin_);
  if (pulls_[own] != 0) put_pulled(element, positions);
  if (!is_held(static_cast<Index>(element))) return;
  const std::size_t first = block_stride * own;
  for (std::size_t v = first; v < first + block_stride; ++v)
    blocks_[v] = static_cast<float>(elastic_fractions_[element] * static_cast<double>(blocks_[v])) + held_[v];
}

std::array<Vec3, 4> Elements::multiply_held(Index element, const std::array<Vec3, 4>& vectors) const {
  return product_of(vectors, [&](int i, int j) { return tangent_block(held_, element, i, j); });
}

/// Makes a part of the products of an element whose damping is held.
/// \param products  by corner: of the whole on entry, of the part on return
void Elements::put_part_of_held(std::size_t element, std::span<const simd::Padded3> vectors,
                                StiffnessPart part, double* products) const {
  std::array<Vec3, 4> own;
  for (std::size_t k = 0; k < 4; ++k) own[k] = unpadded(at(vectors, corners_[element][k]));
  const std::array<Vec3, 4> damping = multiply_held(static_cast<Index>(element), own);
  for (std::size_t k = 0; k < 4; ++k) {
    double* const at_corner = products + 4 * k;
    const Vec3 whole{at_corner[0], at_corner[1], at_corner[2]};
    store(part == StiffnessPart::damping ? damping[k] : whole - damping[k], at_corner);
  }
}

/// Block (i, j), i != j, of an element among its tangent blocks.
Matrix3 Elements::tangent_block(std::span<const float> blocks, Index element, int i, int j) const {
  const float* values = &blocks[tangent_place(element, std::min(i, j), std::max(i, j))];
  Matrix3 block;
  for (std::size_t k = 0; k < 9; ++k) block.values[k] = static_cast<double>(values[k]);
  return i < j ? block : transposed(block);
}

Matrix3 Elements::low_rank_block(Index element, int i, int j) const {
  const Vec3 a = gradient(element, i);
  const Vec3 b = gradient(element, j);
  Matrix3 block;
  add_outer(block, at(ratio_, element), a, b);
  add_outer(block, 1.0, b, a);
  for (int k = 0; k < 3; ++k) block(k, k) += dot(a, b);
  return block;
}

void Elements::add_stiffness(Index element, int i, int j, Matrix3& block) const {
  const auto add = [&](const Matrix3& a, double sign) {
    for (std::size_t k = 0; k < 9; ++k) block.values[k] += sign * a.values[k];
  };
  if (element < tangent_begin_) {
    add(low_rank_block(element, i, j), 1.0);
  } else if (i != j) {
    add(tangent_block(blocks_, element, i, j), 1.0);
  } else {
    for (int other = 0; other < 4; ++other) {
      if (other != i) add(tangent_block(blocks_, element, i, other), -1.0);
    }
  }
}

std::array<Vec3, 4> Elements::multiply(Index element, const std::array<Vec3, 4>& vectors) const {
  std::array<Vec3, 4> products = product_of(vectors, [&](int i, int j) {
    return element < tangent_begin_ ? low_rank_block(element, i, j) : tangent_block(blocks_, element, i, j);
  });
  if (const TenseElements::Tense* tense = tense_.find(element)) multiply_tense(*tense, vectors, products);
  return products;
}

/// Products of the elements with tangent blocks among [begin, end), by corner. Blocks of smoothed tets are
/// zero.
void Elements::multiply_full(std::size_t begin, std::size_t end, std::span<const simd::Padded3> vectors,
                             double* products) const {
  const std::size_t first = std::max(begin, static_cast<std::size_t>(tangent_begin_));
  if (first >= end) return;
  const simd::TangentPass pass{.vectors = vectors.data(),
                               .corners = corners_.front().data(),
                               .blocks = element_tangent(static_cast<Index>(first)),
                               .products = products + 16 * (first - begin)};
  simd::tangent_pass(pass, first, end);
}

}  // namespace palpate::fem
