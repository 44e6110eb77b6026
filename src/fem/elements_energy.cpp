#include <algorithm>
#include <cstddef>

#include "fem/elements.hpp"
#include "fem/padded_vectors.hpp"
#include "fem/rotation.hpp"
#include "fem/stress.hpp"

// Energies and deformations of elements; their plastic strains.
namespace palpate::fem {
namespace {

constexpr std::size_t energy_element_grain = CornerSums::chunk;

}  // namespace

double Elements::energy_density(std::size_t element, const Matrix3& rotation, const Matrix3& stretch) const {
  const double trace = inner(rotation, stretch);
  const double lambda = bulk_fraction_[element] * lambda_[element];
  return mu_[element] * inner(stretch, stretch) + 0.5 * lambda * trace * trace;
}

double Elements::energy(Index element, std::span<const Vec3> positions) const {
  return at(volume_, element) * energy_density_of(deformation(element, positions));
}

double Elements::ambient_energy(Index element, std::span<const Vec3> positions) const {
  if (!has_ambient(element)) return 0.0;
  const double change = determinant(deformation_gradient(static_cast<std::size_t>(element), positions)) - 1.0;
  return at(ambient_, element - tangent_begin_) * at(volume_, element) * change;
}

ElementDeformation Elements::deformation(Index element, std::span<const Vec3> positions) const {
  const auto e = static_cast<std::size_t>(element);
  ElementDeformation d;
  d.gradient = deformation_gradient(e, positions);
  d.rotation = nearest_rotation(d.gradient);
  d.stretch = elastic_stretch(e, d.gradient, d.rotation);
  d.mu = mu_[e];
  d.lambda = bulk_fraction_[e] * lambda_[e];
  d.hyperelastic = is_hyperelastic(e);
  if (d.hyperelastic) {
    d.law = law_of(e);
    d.law.tension = tension_[e - static_cast<std::size_t>(tangent_begin_)];
    d.law.ambient = 0.0;  // a load, no stress of the tissue
  }
  if (viscosity_.has(e)) {
    d.viscous_stress = viscosity_.stress(e);
    d.viscous_energy = viscosity_.energy_density(e, mu_[e], lambda_[e]);
  }
  if (!yields(e)) return d;
  d.plastic_strain = plastic_strains_[e];
  d.twist = twist_of(d.gradient, d.rotation, d.plastic_strain);
  return d;
}

std::vector<simd::Padded3> Elements::displacements(const parallel::Threads& threads,
                                                   std::span<const Vec3> positions) const {
  std::vector<simd::Padded3> displacements(positions.size());
  parallel::for_each(threads, positions.size(), energy_element_grain,
                     [&](std::size_t i) { displacements[i] = padded(positions[i] - points_rest_[i]); });
  return displacements;
}

void Elements::find_group_stress(std::size_t first, std::span<const simd::Padded3> displacements,
                                 simd::GroupStress& found) const {
  if (group_models_[first / simd::element_group] != GroupModel::corotational) {
    found.left.fill(1);
    return;
  }
  simd::StressPass pass{.displacements = displacements.data(),
                        .corners = corners_.front().data(),
                        .inverse_rest = {},
                        .mu = mu_.data(),
                        .lambda = lambda_.data()};
  for (std::size_t k = 0; k < 9; ++k) pass.inverse_rest[k] = inverse_rest_[k].data();
  simd::stress_pass(pass, first, found);
  for (std::size_t e = first; e < std::min(first + simd::element_group, tets_.size()); ++e) {
    if (bulk_fraction_[e] != 1.0 || yields(e) || viscosity_.has(e)) found.left[e - first] = 1;
  }
}

void Elements::set_plastic_strains(std::span<const SymmetricMatrix3> strains) {
  for (std::size_t e = 0; e < plastic_strains_.size(); ++e) {
    plastic_strains_[e] = yields(e) ? strains[e] : SymmetricMatrix3{};
  }
}

void Elements::flow(const parallel::Threads& threads, std::span<const Vec3> positions, double time_step,
                    std::span<SymmetricMatrix3> next) const {
  parallel::for_each(threads, plastic_strains_.size(), energy_element_grain, [&](std::size_t e) {
    next[e] = plastic_strains_[e];
    if (!yields(e)) return;
    const Matrix3 f = deformation_gradient(e, positions);
    if (!(determinant(f) > 0.0)) return;
    const SymmetricMatrix3 total = corotated_strain(f, nearest_rotation(f));
    next[e] = plastic_flow(plastic_strains_[e], total, plasticity_[e], time_step, mu_[e], lambda_[e]);
  });
}

}  // namespace palpate::fem
