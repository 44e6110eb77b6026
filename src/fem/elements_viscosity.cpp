// Viscosity of elements: the forces by ViscousElements, and the end of a step.
#include <cstddef>

#include "fem/elements.hpp"
#include "fem/padded_vectors.hpp"
#include "fem/rotation.hpp"
#include "fem/stress.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t viscous_element_grain = 128;

}  // namespace

void Elements::add_viscosity(const Materials& materials) {
  std::vector<Index> material(tets_.size());
  std::vector<std::uint8_t> smoothed(tets_.size());
  for (std::size_t e = 0; e < tets_.size(); ++e) {
    material[e] = materials.index_of(tets_[e], body_[e]);
    smoothed[e] = is_smoothed(e) ? 1 : 0;
  }
  viscosity_ = ViscousElements(materials.all, material, smoothed);
}

bool Elements::is_viscous() const {
  return !viscosity_.elements().empty() || smoothing_.is_viscous();
}

void Elements::find_history(const parallel::Threads& threads) {
  viscosity_.find_history(threads);
  smoothing_.find_history(threads);
}

std::vector<SymmetricMatrix3> Elements::viscous_stresses() const {
  const auto own = viscosity_.stresses();
  const auto of_domains = smoothing_.viscosity().stresses();
  std::vector<SymmetricMatrix3> all(own.begin(), own.end());
  all.insert(all.end(), of_domains.begin(), of_domains.end());
  return all;
}

void Elements::set_viscous_stresses(std::span<const SymmetricMatrix3> stresses) {
  const std::size_t own = viscosity_.stresses().size();
  viscosity_.set_stresses(stresses.first(own));
  smoothing_.set_viscous_stresses(stresses.subspan(own));
}

std::vector<Index> Elements::body_of_viscous_stress() const {
  std::vector<Index> bodies;
  const auto add = [&](const ViscousElements& viscosity, auto&& element_of) {
    for (std::size_t k = 0; k < viscosity.elements().size(); ++k)
      bodies.insert(bodies.end(), viscosity.stress_count(k), at(body_, element_of(viscosity.elements()[k])));
  };
  add(viscosity_, [](Index element) { return element; });
  add(smoothing_.viscosity(),
      [&](Index domain) { return smoothing_.element(static_cast<std::size_t>(domain)); });
  return bodies;
}

void Elements::set_time_step(double time_step) {
  viscosity_.set_time_step(time_step);
  smoothing_.set_time_step(time_step);
  tense_.set_time_step(time_step);
  set_inviscid();
}

/// Divides active tensions and ambient pressures by the stiffness factor of viscosity: the kernel multiplies
/// them by it, and they are not viscous.
void Elements::set_inviscid() {
  for (std::size_t k = 0; k < tension_.size(); ++k) {
    const double stiffness = viscosity_.stiffness(static_cast<std::size_t>(tangent_begin_) + k);
    laws_[simd::law_tension][k] = tension_[k] / stiffness;
    laws_[simd::law_ambient][k] = ambient_[k] / stiffness;
  }
  smoothing_.set_tensions(tension_, tangent_begin_);
  smoothing_.set_ambient(ambient_, tangent_begin_);
}

/// Adds the viscous part to the elastic forces on the corners and to the energy, which must be set.
void Elements::add_viscous_forces(std::size_t element, std::span<const Vec3> positions, double* forces) {
  const double stiffness = viscosity_.stiffness(element);
  const SymmetricMatrix3& history = viscosity_.history(element);
  const Matrix3 f = deformation_gradient(element, positions);
  const Matrix3 rotation = nearest_rotation(f);
  const Matrix3 stress = first_piola_stress(history, f, rotation);
  energy_[element] = stiffness * energy_[element] + volume_[element] * inner(stress, f - rotation);
  Vec3 sum;
  for (int corner = 1; corner < 4; ++corner) {
    double* const own = forces + std::ptrdiff_t{4} * corner;
    const Vec3 force = stiffness * Vec3{own[0], own[1], own[2]} -
                       volume_[element] * (stress * gradient_rest(element, corner));
    sum += force;
    store(force, own);
  }
  store(-sum, forces);
}

void Elements::relax(const parallel::Threads& threads, std::span<const Vec3> positions) {
  const std::span<const Index> viscous = viscosity_.elements();
  parallel::for_each(threads, viscous.size(), viscous_element_grain, [&](std::size_t k) {
    viscosity_.advance(static_cast<std::size_t>(viscous[k]), biot_stress(deformation(viscous[k], positions)));
  });
  if (!smoothing_.is_viscous()) return;
  set_displacements(threads, positions);
  smoothing_.relax(threads, displacements_, bulk_fraction_);
}

}  // namespace palpate::fem
