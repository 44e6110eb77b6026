// Response of smoothing domains to displacements: stress, energy, viscosity and stiffness.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "fem/padded_vectors.hpp"
#include "fem/plasticity.hpp"
#include "fem/rotation.hpp"
#include "fem/smoothing_domains.hpp"
#include "fem/stress.hpp"
#include "fem/symmetric_eigen.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t domain_grain = 128;
constexpr std::size_t smoothed_point_grain = 64;

}  // namespace

void SmoothingDomains::set_tensions(std::span<const double> tensions, Index first) {
  for (std::size_t d = 0; d < size(); ++d)
    laws_[d].tension = at(tensions, element(d) - first) / viscosity_.stiffness(d);
}

void SmoothingDomains::set_ambient(std::span<const double> pressures, Index first) {
  for (std::size_t d = 0; d < size(); ++d) {
    const SmoothedTet& tet = first_tet(d);
    const double part = (is_volume(d) ? 3.0 : 2.0) * modulus(d) / (2.0 * tet.mu + 3.0 * tet.lambda);
    ambient_[d] = part * at(pressures, element(d) - first) / viscosity_.stiffness(d);
  }
}

void SmoothingDomains::set_elastic_fractions(std::span<const double> fractions) {
  for (std::size_t d = 0; d < size(); ++d) elastic_fractions_[d] = at(fractions, element(d));
}

double SmoothingDomains::modulus(std::size_t domain) const {
  const SmoothedTet& tet = first_tet(domain);
  if (!is_volume(domain)) return tet.mu;
  return domain < patch_begin_ ? tet.point_lambda() : tet.patch_lambda();
}

/// Smallest bulk fraction of its tets: one inverted tet reduces the bulk modulus of the whole domain.
double SmoothingDomains::bulk_fraction(std::size_t domain, std::span<const double> fractions) const {
  double least = 1.0;
  if (!is_volume(domain)) return least;
  for (std::uint32_t k = tet_begin_[domain]; k < tet_begin_[domain + 1]; ++k)
    least = std::min(least, at(fractions, tets_[domain_tets_[k]].element));
  return least;
}

/// H = F - I.
Matrix3 SmoothingDomains::displacement_gradient(std::size_t domain,
                                                std::span<const simd::Padded3> displacements) const {
  Matrix3 h;
  for (std::uint32_t k = begin_[domain]; k < begin_[domain + 1]; ++k)
    add_outer(h, 1.0, unpadded(at(displacements, points_[k])), rest_gradients_[k]);
  return h;
}

/// The domain's part of the law: shape or volume.
/// \param tension  factor of the tension of active fibres
HyperelasticLaw SmoothingDomains::law(std::size_t domain, double fraction, double tension) const {
  if (is_volume(domain)) return {.bulk = fraction * modulus(domain)};
  HyperelasticLaw law = laws_[domain];
  law.bulk = bulk_of(0.0, law.first);
  law.tension *= tension;
  return law;
}

ElementDeformation SmoothingDomains::deformation(std::size_t domain, const Matrix3& h, double fraction,
                                                 double tension) const {
  const SmoothedTet& tet = first_tet(domain);
  ElementDeformation d;
  d.gradient = plus_identity(h);
  // A hyperelastic law needs the rotation only with viscosity.
  d.rotation = tet.hyperelastic && !viscosity_.has(domain) ? identity() : nearest_rotation(d.gradient);
  d.stretch = d.gradient - d.rotation;
  d.mu = is_volume(domain) ? 0.0 : tet.mu;
  d.lambda = is_volume(domain) ? fraction * modulus(domain) : 0.0;
  d.hyperelastic = tet.hyperelastic;
  if (d.hyperelastic) d.law = law(domain, fraction, tension);
  return d;
}

/// The derivative of a corotational stress by R: P = 2 mu R (S - I), or lambda tr(S - I) R, rotates with R.
/// Along the twist about principal axis k, [u_k]x R / sqrt 2, the second derivative of the energy is 2 mu (1
/// - 2 / (s_i + s_j)) for shape and 2 lambda tr(S - I) / (s_i + s_j) for volume (Smith, de Goes & Kim 2019,
/// section 4.1 for the first). Along all other directions it is that at fixed R. Negative ones are set to
/// zero. If stretches s of opposite signs cancel, the second is unbounded, so the sum is at least a half. An
/// ambient pressure p adds p s_k.
SmoothingDomains::Twists SmoothingDomains::twists_of(const ElementDeformation& d, double ambient) {
  constexpr double least_sum = 0.5;
  const auto [strains, axes] = symmetric_eigen(corotated_strain(d.gradient, d.rotation));
  const double volume = d.lambda * (strains.x + strains.y + strains.z);
  const Vec3 pairs{strains.y + strains.z, strains.x + strains.z, strains.x + strains.y};
  const auto root_of_half = [&](double pair, double strain) {
    const double elastic = (d.mu * pair + volume) / std::max(2.0 + pair, least_sum);
    return std::sqrt(std::max(0.0, elastic + 0.5 * ambient * (1.0 + strain)));
  };
  return {root_of_half(pairs.x, strains.x) * (d.rotation * axes[0]),
          root_of_half(pairs.y, strains.y) * (d.rotation * axes[1]),
          root_of_half(pairs.z, strains.z) * (d.rotation * axes[2])};
}

void SmoothingDomains::set_tangent(std::size_t domain, const Matrix3& h, const ElementDeformation& d) {
  if (d.hyperelastic) {
    tangents_[domain] = tangent(d.law, h);
    return;
  }
  rotations_[domain] = d.rotation;
  const Twists twists = twists_of(d, ambient_[domain]);
  twist_stiffness_[domain] =
      scales_[domain] * outer_square(transposed(from_rows(twists[0], twists[1], twists[2])));
  const auto quad = [](const Vec3& a) {
    return simd::Quad{static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z), 0.0F};
  };
  const double scale = std::sqrt(scales_[domain] * modulus(domain));
  const double root = std::sqrt(scales_[domain]);
  for (std::uint32_t k = begin_[domain]; k < begin_[domain + 1]; ++k) {
    const Vec3 a = d.rotation * rest_gradients_[k];
    rotated_[k].strain = quad(scale * a);
    for (std::size_t n = 0; n < 3; ++n) rotated_[k].twist[n] = quad(root * cross(twists[n], a));
  }
}

void SmoothingDomains::update(const parallel::Threads& threads, std::span<const simd::Padded3> displacements,
                              std::span<const double> factors, std::span<const double> bulk_fractions) {
  parallel::for_each(threads, size(), domain_grain, [&](std::size_t d) {
    const Matrix3 h = displacement_gradient(d, displacements);
    const double fraction = bulk_fraction(d, bulk_fractions);
    ElementDeformation now = deformation(d, h, fraction, 1.0);
    now.law.ambient = ambient_[d];
    const HyperelasticResponse response = step_response(d, h, now);
    densities_[d] = response.energy_density;
    for (std::size_t k = 0; k < 9; ++k) stresses_[d].values[k] = volume_[d] * response.stress.values[k];
    scales_[d] = at(factors, element(d)) * volume_[d];
    set_tangent(d, h, now);
  });
}

/// The response over a step, as in Elements::add_viscous_forces: stiffness times P, and the stress of the
/// history.
HyperelasticResponse SmoothingDomains::step_response(std::size_t domain, const Matrix3& h,
                                                     const ElementDeformation& d) const {
  // Near rest F - I loses digits by cancellation, H does not.
  HyperelasticResponse response = d.hyperelastic ? respond(d.law, h) : elastic_response(d);
  if (!d.hyperelastic && ambient_[domain] != 0.0) {
    const Matrix3 cofactor = cofactors(d.gradient);
    response.energy_density += ambient_[domain] * volume_change(h, cofactors(h));
    for (std::size_t k = 0; k < 9; ++k) response.stress.values[k] += ambient_[domain] * cofactor.values[k];
  }
  if (!viscosity_.has(domain)) return response;
  const double stiffness = viscosity_.stiffness(domain);
  const Matrix3 stress = first_piola_stress(viscosity_.history(domain), d.gradient, d.rotation);
  response.energy_density = stiffness * response.energy_density + inner(stress, d.stretch);
  for (std::size_t k = 0; k < 9; ++k)
    response.stress.values[k] = stiffness * response.stress.values[k] + stress.values[k];
  return response;
}

HyperelasticResponse SmoothingDomains::response_now(std::size_t domain, const Matrix3& h,
                                                    double fraction) const {
  ElementDeformation d = deformation(domain, h, fraction, viscosity_.stiffness(domain));
  if (viscosity_.has(domain)) {
    d.viscous_stress = viscosity_.stress(domain);
    const double whole = modulus(domain);
    d.viscous_energy =
        viscosity_.energy_density(domain, is_volume(domain) ? 0.0 : whole, is_volume(domain) ? whole : 0.0);
  }
  return whole_response(d);
}

void SmoothingDomains::relax(const parallel::Threads& threads, std::span<const simd::Padded3> displacements,
                             std::span<const double> bulk_fractions) {
  parallel::for_each(threads, viscosity_.elements().size(), domain_grain, [&](std::size_t k) {
    const auto d = static_cast<std::size_t>(viscosity_.elements()[k]);
    const Matrix3 h = displacement_gradient(d, displacements);
    viscosity_.advance(d, biot_stress(deformation(d, h, bulk_fraction(d, bulk_fractions), 0.0)));
  });
}

double SmoothingDomains::energy(const parallel::Threads& threads,
                                std::span<const simd::Padded3> displacements,
                                std::span<const double> bulk_fractions, std::vector<double>& partial) const {
  return parallel::sum(threads, size(), partial, [&](std::size_t d) {
    const Matrix3 h = displacement_gradient(d, displacements);
    return volume_[d] * response_now(d, h, bulk_fraction(d, bulk_fractions)).energy_density;
  });
}

void SmoothingDomains::add_forces(const parallel::Threads& threads, std::span<simd::Padded3> forces) const {
  parallel::for_each(threads, smoothed_points_.size(), smoothed_point_grain, [&](std::size_t i) {
    Vec3 sum;
    for (const Entry& entry : entries(smoothed_points_[i]))
      sum += stresses_[entry.domain] * rest_gradients_[begin_[entry.domain] + entry.place];
    simd::Padded3& force = at(forces, smoothed_points_[i]);
    force = padded(unpadded(force) - sum);
  });
}

void SmoothingDomains::add_energies(const parallel::Threads& threads, std::span<double> energies) const {
  parallel::for_each(threads, tets_.size(), domain_grain, [&](std::size_t t) {
    const std::uint32_t* domains = &domain_of_tet_[domains_of_tet * t];
    double sum = 0.0;
    for (std::size_t k = 0; k < domains_of_tet; ++k) {
      if (domains[k] < size()) sum += volume_fraction(k) * densities_[domains[k]];
    }
    at(energies, tets_[t].element) += tets_[t].volume * sum;
  });
}

/// The factor times V dP for a given dF.
Matrix3 SmoothingDomains::stress_change(std::size_t domain, const Matrix3& gradient) const {
  const double scale = scales_[domain];
  Matrix3 change;
  if (first_tet(domain).hyperelastic) {
    change = stress_change_of(tangents_[domain], laws_[domain].fibre, gradient);
    for (double& value : change.values) value *= scale;
    return change;
  }
  const Matrix3& r = rotations_[domain];
  const Matrix3 b = times_transposed(gradient, r);  // dF R^T
  const double modul = scale * modulus(domain);
  if (is_volume(domain)) {
    for (int k = 0; k < 3; ++k) change(k, k) = modul * trace(b);
  } else {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) change(i, j) = modul * (b(i, j) + b(j, i));
    }
  }
  const Vec3 w = twist_stiffness_[domain] * Vec3{b(2, 1) - b(1, 2), b(0, 2) - b(2, 0), b(1, 0) - b(0, 1)};
  const Matrix3 turn = from_rows({0.0, -w.z, w.y}, {w.z, 0.0, -w.x}, {-w.y, w.x, 0.0});
  for (std::size_t k = 0; k < 9; ++k) change.values[k] += turn.values[k];
  return times_transposed(change, transposed(r));
}

/// The same for a part of the stiffness.
Matrix3 SmoothingDomains::stress_change(std::size_t domain, const Matrix3& gradient,
                                        StiffnessPart part) const {
  const double elastic = part == StiffnessPart::damping ? 0.0 : elastic_fractions_[domain];
  const double damping = part == StiffnessPart::elastic ? 0.0 : 1.0 - elastic_fractions_[domain];
  Matrix3 change = stress_change(domain, gradient);
  if (!is_held(domain)) {
    if (part == StiffnessPart::whole) return change;
    for (double& value : change.values) value *= elastic + damping;
    return change;
  }
  const Matrix3 held = stress_change_of(held_tangents_[domain], laws_[domain].fibre, gradient);
  for (std::size_t k = 0; k < 9; ++k)
    change.values[k] = elastic * change.values[k] + damping * scales_[domain] * held.values[k];
  return change;
}

void SmoothingDomains::multiply(const parallel::Threads& threads, std::span<const simd::Padded3> vectors,
                                StiffnessPart part, std::span<simd::Padded3> products) const {
  parallel::for_each(threads, size(), domain_grain, [&](std::size_t d) {
    changes_[d] = stress_change(d, displacement_gradient(d, vectors), part);
  });
  parallel::for_each(threads, smoothed_points_.size(), smoothed_point_grain, [&](std::size_t i) {
    Vec3 sum;
    for (const Entry& entry : entries(smoothed_points_[i]))
      sum += changes_[entry.domain] * rest_gradients_[begin_[entry.domain] + entry.place];
    simd::Padded3& product = at(products, smoothed_points_[i]);
    product = padded(unpadded(product) + sum);
  });
}

/// Stiffness block of the two points whose gradients are rest_gradients_[a] and rest_gradients_[b].
SmoothingDomains::Block SmoothingDomains::hyperelastic_block(std::size_t domain, std::size_t a,
                                                             std::size_t b) const {
  const auto [first, second] = std::minmax(a, b);
  const auto block_by = [&](const HyperelasticTangent& tangent) {
    return block_of(tangent, laws_[domain].fibre, rest_gradients_[first], rest_gradients_[second]);
  };
  Matrix3 own = block_by(tangents_[domain]);
  if (is_held(domain)) {
    const double elastic = elastic_fractions_[domain];
    const Matrix3 held = block_by(held_tangents_[domain]);
    for (std::size_t k = 0; k < 9; ++k)
      own.values[k] = elastic * own.values[k] + (1.0 - elastic) * held.values[k];
  }
  Block block;
  for (std::size_t k = 0; k < 9; ++k)
    block[k] = static_cast<float>(scales_[domain] * own.values[a <= b ? k : 3 * (k % 3) + k / 3]);
  return block;
}

Matrix3 SmoothingDomains::block_rest(std::size_t domain, const Matrix3& rotation, std::size_t i,
                                     std::size_t j) const {
  const Vec3 a = rotation * rest_gradients_[begin_[domain] + i];
  const Vec3 b = rotation * rest_gradients_[begin_[domain] + j];
  const double scale = scales_[domain] * modulus(domain);
  Matrix3 block;
  if (is_volume(domain)) {
    add_outer(block, scale, a, b);
    return block;
  }
  add_outer(block, scale, b, a);
  for (int k = 0; k < 3; ++k) block(k, k) += scale * dot(a, b);
  return block;
}

Matrix3 SmoothingDomains::rotation(std::size_t domain, std::span<const Vec3> rest,
                                   std::span<const Vec3> positions) const {
  Matrix3 f = identity();
  for (std::uint32_t k = begin_[domain]; k < begin_[domain + 1]; ++k)
    add_outer(f, 1.0, at(positions, points_[k]) - at(rest, points_[k]), rest_gradients_[k]);
  return nearest_rotation(f);
}

std::vector<HyperelasticResponse> SmoothingDomains::responses(const parallel::Threads& threads,
                                                              std::span<const simd::Padded3> displacements,
                                                              std::span<const double> bulk_fractions) const {
  std::vector<HyperelasticResponse> of_domains(size());
  parallel::for_each(threads, size(), domain_grain, [&](std::size_t d) {
    const Matrix3 h = displacement_gradient(d, displacements);
    of_domains[d] = response_now(d, h, bulk_fraction(d, bulk_fractions));
  });
  std::vector<HyperelasticResponse> of_tets(tets_.size());
  parallel::for_each(threads, tets_.size(), domain_grain, [&](std::size_t t) {
    for (std::size_t k = 0; k < domains_of_tet; ++k) {
      const std::uint32_t d = domain_of_tet_[domains_of_tet * t + k];
      if (d >= size()) continue;
      const double weight = volume_fraction(k);
      of_tets[t].energy_density += weight * of_domains[d].energy_density;
      for (std::size_t n = 0; n < 9; ++n)
        of_tets[t].stress.values[n] += weight * of_domains[d].stress.values[n];
    }
  });
  return of_tets;
}

}  // namespace palpate::fem
