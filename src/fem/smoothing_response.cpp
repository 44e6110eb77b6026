// Response of smoothing domains to displacements: stress, energy and viscosity.
#include <algorithm>
#include <cstddef>

#include "fem/grains.hpp"
#include "fem/padded_vectors.hpp"
#include "fem/plasticity.hpp"
#include "fem/rotation.hpp"
#include "fem/smoothing_domains.hpp"
#include "fem/stress.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

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

void SmoothingDomains::update(const parallel::Threads& threads, std::span<const simd::Padded3> displacements,
                              std::span<const double> factors, std::span<const double> bulk_fractions) {
  const auto update_domain = [&](std::size_t d) {
    const Matrix3 h = displacement_gradient(d, displacements);
    const double fraction = bulk_fraction(d, bulk_fractions);
    ElementDeformation now = deformation(d, h, fraction, 1.0);
    now.law.ambient = ambient_[d];
    const HyperelasticResponse response = step_response(d, h, now);
    densities_[d] = response.energy_density;
    for (std::size_t k = 0; k < 9; ++k) stresses_[d].values[k] = volume_[d] * response.stress.values[k];
    scales_[d] = at(factors, element(d)) * volume_[d];
    set_tangent(d, h, now);
  };
  // Tangents of domains for shape need those for volume.
  parallel::for_each(threads, size() - volume_begin_, domain_grain,
                     [&](std::size_t k) { update_domain(volume_begin_ + k); });
  parallel::for_each(threads, volume_begin_, domain_grain, update_domain);
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
