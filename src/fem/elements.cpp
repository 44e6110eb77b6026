#include "fem/elements.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include <palpate/error.hpp>

#include "fem/body_title.hpp"
#include "fem/grains.hpp"
#include "fem/padded_vectors.hpp"
#include "fem/rotation.hpp"
#include "fem/row_order.hpp"
#include "number_text.hpp"
#include "simd/element_pass.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t element_grain = CornerSums::chunk;

/// Edges from corner 0 as columns: D_m of Mueller & Gross 2004.
Matrix3 edge_matrix(std::span<const Vec3> points, const Tet& tet) {
  const Vec3 a = at(points, tet[1]) - at(points, tet[0]);
  const Vec3 b = at(points, tet[2]) - at(points, tet[0]);
  const Vec3 c = at(points, tet[3]) - at(points, tet[0]);
  return {{a.x, b.x, c.x, a.y, b.y, c.y, a.z, b.z, c.z}};
}

std::size_t whole_groups(std::size_t elements) {
  return (elements + simd::element_group - 1) / simd::element_group * simd::element_group;
}

}  // namespace

Elements::Elements(const Bodies& bodies, const Materials& materials, std::span<const std::uint8_t> obstacles)
    : points_rest_(bodies.points_rest().begin(), bodies.points_rest().end()) {
  add_bodies(bodies, materials, obstacles);
  add_viscosity(materials);
  const std::vector<double> thickness = tissue_thickness(bodies);
  for (std::size_t e = 0; e < tets_.size(); ++e)
    tense_.add(at(thickness, tets_[e]), materials.of(tets_[e], body_[e]), volume_[e]);
  plastic_strains_.resize(plasticity_.size());
  factor_.assign(corners_.size(), 1.0);
  elastic_fractions_.assign(tets_.size(), 1.0);
  bulk_fraction_.assign(corners_.size(), 1.0);
  for (auto* vector : {&displacements_, &point_forces_, &products_}) vector->resize(points_rest_.size());
  force_sums_ = CornerSums(corners_, points_rest_.size());
  product_sums_ = force_sums_;
  fill_group();
}

void Elements::fill_group() {
  const std::size_t whole = (corners_.size() / simd::element_group + 1) * simd::element_group;
  corners_.resize(whole, Tet{});
  for (auto& column : inverse_rest_) column.resize(whole);
  for (auto& column : turned_) column.resize(whole);
  for (auto* column : {&stiffness_, &volume_, &mu_, &lambda_, &ratio_, &factor_, &energy_})
    column->resize(whole);
  gradients_.resize(4 * whole);
  left_.resize(whole);
  inverted_.resize(whole);
  group_models_.assign(whole / simd::element_group, GroupModel::corotational);
  for (std::size_t e = 0; e < tets_.size(); ++e) {
    GroupModel& model = group_models_[e / simd::element_group];
    GroupModel own = is_hyperelastic(e) ? GroupModel::hyperelastic : GroupModel::corotational;
    if (is_smoothed(e)) own = GroupModel::mixed;
    if (e % simd::element_group == 0) {
      model = own;
    } else if (model != own) {
      model = GroupModel::mixed;
    }
  }
}

void Elements::add_element(const Bodies& bodies, Index tet, Index body, const Materials& materials) {
  const Material& material = materials.of(tet, body);
  const Tet& corners = at(bodies.tets(), tet);
  const Matrix3 edges = edge_matrix(points_rest_, corners);
  const Matrix3 inverse_rest = inverse(edges);
  const double volume = determinant(edges) / 6.0;
  bool good = volume > 0.0;
  for (const double value : inverse_rest.values) good = good && std::isfinite(value);
  if (!good) {
    const Body& owner = at(bodies.bodies(), body);
    throw Error(body_title(owner), "tet " + std::to_string(tet - owner.tets.begin),
                "a volume at rest of " + number_text(volume),
                "a volume that is positive and has a finite inverse shape in double precision");
  }
  corners_.push_back(corners);
  tets_.push_back(tet);
  body_.push_back(body);
  for (std::size_t k = 0; k < 9; ++k) inverse_rest_[k].push_back(inverse_rest.values[k]);
  volume_.push_back(volume);
  const double nu = material.poisson_ratio;
  mu_.push_back(material.young_modulus / (2.0 * (1.0 + nu)));
  lambda_.push_back(material.young_modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)));
  ratio_.push_back(2.0 * nu / (1.0 - 2.0 * nu));
  stiffness_.push_back(mu_.back() * volume);
  add_plasticity(material);
}

/// Fills the list from the first element that can yield on. Without such an element it stays empty.
void Elements::add_plasticity(const Material& material) {
  if (plasticity_.empty() && !material.plastic_yield) return;
  plasticity_.resize(corners_.size());
  plasticity_.back() = {material.plastic_yield, material.plastic_creep, material.plastic_maximum};
}

Vec3 Elements::gradient_rest(std::size_t element, int corner) const {
  const auto row_of = [&](std::size_t k) {
    return Vec3{inverse_rest_[k][element], inverse_rest_[k + 1][element], inverse_rest_[k + 2][element]};
  };
  // The shape functions sum to one.
  if (corner == 0) return -(row_of(0) + row_of(3) + row_of(6));
  return row_of(static_cast<std::size_t>(3 * (corner - 1)));
}

Matrix3 Elements::deformation_gradient(std::size_t element, std::span<const Vec3> positions) const {
  const Tet& corners = corners_[element];
  const auto displacement = [&](std::size_t corner) {
    return at(positions, corners[corner]) - at(points_rest_, corners[corner]);
  };
  const Vec3 origin = displacement(0);
  Matrix3 f = identity();
  for (int corner = 1; corner < 4; ++corner) {
    const Vec3 difference = displacement(static_cast<std::size_t>(corner)) - origin;
    add_outer(f, 1.0, difference, gradient_rest(element, corner));
  }
  return f;
}

/// R e, with e the elastic strain: F - R without the plastic part.
Matrix3 Elements::elastic_stretch(std::size_t element, const Matrix3& f, const Matrix3& rotation) const {
  Matrix3 stretch = f - rotation;
  if (!yields(element)) return stretch;
  const SymmetricMatrix3& p = plastic_strains_[element];
  for (int i = 0; i < 3; ++i) {
    const Vec3 plastic_row = p * row(rotation, i);
    stretch(i, 0) -= plastic_row.x;
    stretch(i, 1) -= plastic_row.y;
    stretch(i, 2) -= plastic_row.z;
  }
  return stretch;
}

/// Runs the kernels over the groups of a chunk that have one model. Marks the tets of other groups, which are
/// done one by one.
void Elements::run_passes(const simd::ElementPass& pass, std::size_t begin, std::size_t end) {
  std::size_t first = begin;
  while (first < end) {
    const GroupModel model = group_models_[first / simd::element_group];
    std::size_t last = first;
    while (last < end && group_models_[last / simd::element_group] == model) last += simd::element_group;
    double* forces = pass.forces + 16 * (first - begin);
    if (model == GroupModel::corotational) {
      simd::ElementPass own = pass;
      own.forces = forces;
      simd::element_pass(own, first, last);
    } else if (model == GroupModel::hyperelastic) {
      simd::HyperelasticPass own = hyperelastic_pass(pass);
      own.forces = forces;
      simd::hyperelastic_pass(own, first, last);
    } else {
      std::fill(left_.begin() + static_cast<std::ptrdiff_t>(first),
                left_.begin() + static_cast<std::ptrdiff_t>(last), std::uint8_t{1});
    }
    first = last;
  }
}

/// \param forces  output, on the four corners
void Elements::update_element(std::size_t element, std::span<const Vec3> positions, double* forces) {
  if (is_smoothed(element)) {
    inverted_[element] = determinant(deformation_gradient(element, positions)) > 0.0 ? 0 : 1;
    std::fill(forces, forces + 16, 0.0);
    energy_[element] = 0.0;
    return;
  }
  if (is_hyperelastic(element)) {
    update_hyperelastic(element, positions, forces);
    return;
  }
  const Matrix3 f = deformation_gradient(element, positions);
  inverted_[element] = determinant(f) > 0.0 ? 0 : 1;
  const Matrix3 rotation = nearest_rotation(f);
  const Matrix3 stretch = elastic_stretch(element, f, rotation);
  const Vec3 twist = yields(element) ? twist_of(f, rotation, plastic_strains_[element]) : Vec3{};
  // tr(R^T F - I) = tr(R^T (F - R)), which does not cancel near rest.
  const double pressure = bulk_fraction_[element] * lambda_[element] * inner(rotation, stretch);
  const double twice_mu = 2.0 * mu_[element];
  const double scale = std::sqrt(factor_[element] * mu_[element] * volume_[element]);
  energy_[element] = volume_[element] * energy_density(element, rotation, stretch);
  Vec3 gradient_sum;
  Vec3 force_sum;
  for (int corner = 1; corner < 4; ++corner) {
    const Vec3 rest = gradient_rest(element, corner);
    const Vec3 gradient = rotation * rest;
    Vec3 strained = stretch * rest;
    if (twist != Vec3{}) strained -= rotation * cross(twist, rest);
    const Vec3 force = -volume_[element] * (twice_mu * strained + pressure * gradient);
    gradient_sum += scale * gradient;
    force_sum += force;
    set_gradient(element, corner, scale * gradient);
    store(force, forces + std::ptrdiff_t{4} * corner);
  }
  set_gradient(element, 0, -gradient_sum);
  store(-force_sum, forces);
  if (has_tangent_blocks(element)) put_corotational_blocks(element);
}

void Elements::set_gradient(std::size_t element, int corner, const Vec3& a) {
  gradients_[4 * element + static_cast<std::size_t>(corner)] = {
      static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z),
      static_cast<float>(ratio_[element])};
  if (corner == 0) return;
  const auto first = static_cast<std::size_t>(3 * (corner - 1));
  turned_[first][element] = a.x;
  turned_[first + 1][element] = a.y;
  turned_[first + 2][element] = a.z;
}

Vec3 Elements::gradient(Index element, int corner) const {
  const auto e = static_cast<std::size_t>(element);
  const auto row_of = [&](std::size_t k) {
    return Vec3{turned_[k][e], turned_[k + 1][e], turned_[k + 2][e]};
  };
  if (corner == 0) return -(row_of(0) + row_of(3) + row_of(6));
  return row_of(static_cast<std::size_t>(3 * (corner - 1)));
}

std::span<const simd::Padded3> Elements::multiply(const parallel::Threads& threads,
                                                  std::span<const simd::Padded3> vectors,
                                                  StiffnessPart part) const {
  if (tets_.empty()) return products_;
  simd::StiffnessPass pass{};
  pass.vectors = vectors.data();
  pass.corners = corners_.front().data();
  for (std::size_t k = 0; k < 9; ++k) pass.turned[k] = turned_[k].data();
  pass.ratios = ratio_.data();
  parallel::for_chunks(threads, tets_.size(), element_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         alignas(64) CornerSums::Values products;
                         simd::StiffnessPass own = pass;
                         own.products = products.data();
                         if (!has_tangent_blocks(begin)) simd::stiffness_pass(own, begin, whole_groups(end));
                         multiply_full(begin, end, vectors, products.data());
                         add_tense_products(begin, end, vectors, products);
                         for (std::size_t e = begin; part != StiffnessPart::whole && e < end; ++e) {
                           double* const of_element = &products[16 * (e - begin)];
                           if (is_held(static_cast<Index>(e))) {
                             put_part_of_held(e, vectors, part, of_element);
                           } else {
                             const double elastic = elastic_fractions_[e];
                             const double weight = part == StiffnessPart::elastic ? elastic : 1.0 - elastic;
                             for (std::size_t k = 0; k < 16; ++k) of_element[k] *= weight;
                           }
                         }
                         product_sums_.take(chunk, products);
                       });
  product_sums_.collect(threads, products_);
  if (!smoothing_.empty()) smoothing_.multiply(threads, vectors, part, products_);
  return products_;
}

void Elements::set_factors(std::span<const double> factors, std::span<const double> elastic_fractions) {
  std::copy(factors.begin(), factors.end(), factor_.begin());
  std::copy(elastic_fractions.begin(), elastic_fractions.end(), elastic_fractions_.begin());
  smoothing_.set_elastic_fractions(elastic_fractions_);
}

void Elements::collect_forces(std::size_t chunk, const CornerSums::Values& forces,
                              std::span<simd::Padded3> corner_forces) {
  force_sums_.take(chunk, forces);
  if (corner_forces.empty()) return;
  const auto own = corner_forces.subspan(4 * CornerSums::chunk * chunk);
  for (std::size_t c = 0; c < std::min(own.size(), forces.size() / 4); ++c)
    own[c] = {forces[4 * c], forces[4 * c + 1], forces[4 * c + 2], 0.0};
}

void Elements::update(const parallel::Threads& threads, std::span<const Vec3> positions,
                      std::span<simd::Padded3> corner_forces) {
  if (tets_.empty()) return;
  set_displacements(threads, positions);
  simd::ElementPass pass{};
  pass.displacements = displacements_.data();
  pass.corners = corners_.front().data();
  for (std::size_t k = 0; k < 9; ++k) pass.inverse_rest[k] = inverse_rest_[k].data();
  pass.stiffness = stiffness_.data();
  pass.factors = factor_.data();
  pass.ratios = ratio_.data();
  for (std::size_t k = 0; k < 9; ++k) pass.turned[k] = turned_[k].data();
  pass.gradients = gradients_.data();
  pass.energies = energy_.data();
  pass.inverted = inverted_.data();
  pass.left = left_.data();
  tense_lists_.fill(threads, tets_.size(), element_grain,
                    [&](std::size_t begin, std::size_t end, std::vector<TenseElements::Tense>& tense) {
                      alignas(64) CornerSums::Values forces;
                      simd::ElementPass own = pass;
                      own.forces = forces.data();
                      run_passes(own, begin, end);
                      for (std::size_t e = begin; e < end; ++e) {
                        double* const of_element = &forces[16 * (e - begin)];
                        if (left_[e] != 0 || bulk_fraction_[e] != 1.0 || has_yielded(e)) {
                          update_element(e, positions, of_element);
                        } else if (has_tangent_blocks(e) && !is_hyperelastic(e)) {
                          put_corotational_blocks(e);
                        }
                        if (viscosity_.has(e)) add_viscous_forces(e, positions, of_element);
                        if (has_tangent_blocks(e)) finish_tangent(e, positions);
                        add_tension(e, of_element, tense);
                      }
                      collect_forces(begin / element_grain, forces, corner_forces);
                    });
  tense_.take(threads, tense_lists_);
  force_sums_.collect(threads, point_forces_);
  update_smoothing(threads);
}

void Elements::set_displacements(const parallel::Threads& threads, std::span<const Vec3> positions) {
  parallel::for_each(threads, positions.size(), point_grain,
                     [&](std::size_t i) { displacements_[i] = padded(positions[i] - points_rest_[i]); });
}

/// Uses displacements_, which must be set.
void Elements::update_smoothing(const parallel::Threads& threads) {
  if (smoothing_.empty()) return;
  smoothing_.update(threads, displacements_, factor_, bulk_fraction_);
  smoothing_.add_forces(threads, point_forces_);
  smoothing_.add_energies(threads, energy_);
}

void Elements::update_one_by_one(std::span<const Vec3> positions, std::span<simd::Padded3> corner_forces) {
  const parallel::Threads one(1);
  tense_lists_.fill(one, tets_.size(), element_grain,
                    [&](std::size_t begin, std::size_t end, std::vector<TenseElements::Tense>& tense) {
                      CornerSums::Values forces;
                      for (std::size_t e = begin; e < end; ++e) {
                        double* const of_element = &forces[16 * (e - begin)];
                        update_element(e, positions, of_element);
                        if (viscosity_.has(e)) add_viscous_forces(e, positions, of_element);
                        if (has_tangent_blocks(e)) finish_tangent(e, positions);
                        add_tension(e, of_element, tense);
                      }
                      collect_forces(begin / element_grain, forces, corner_forces);
                    });
  tense_.take(one, tense_lists_);
  force_sums_.collect(one, point_forces_);
  set_displacements(one, positions);
  update_smoothing(one);
}

Matrix3 Elements::stiffness_rest(Index element, int i, int j) const {
  const auto e = static_cast<std::size_t>(element);
  const double scale = factor_[e] * mu_[e] * volume_[e];
  const Vec3 a = gradient_rest(e, i);
  const Vec3 b = gradient_rest(e, j);
  Matrix3 block;
  add_outer(block, scale * ratio_[e], a, b);
  add_outer(block, scale, b, a);
  for (int k = 0; k < 3; ++k) block(k, k) += scale * dot(a, b);
  return block;
}

}  // namespace palpate::fem
