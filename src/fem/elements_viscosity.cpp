// Viscosity of elements: what ViscousElements adds to their forces, and the end of a step.
#include <cstddef>

#include "fem/elements.hpp"
#include "fem/padded_vectors.hpp"
#include "fem/rotation.hpp"
#include "fem/stress.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t element_grain = 128;

}  // namespace

void Elements::add_viscosity(const Materials& materials) {
  std::vector<Index> material(tets_.size());
  for (std::size_t e = 0; e < tets_.size(); ++e) material[e] = materials.index_of(tets_[e], body_[e]);
  viscosity_ = ViscousElements(materials.all, material);
}

void Elements::set_time_step(double time_step) {
  viscosity_.set_time_step(time_step);
  set_tensions();
}

/// Their stiffness in a step is not that of viscosity: the pass multiplies it by that.
void Elements::set_tensions() {
  for (std::size_t k = 0; k < tension_.size(); ++k) {
    const double stiffness = viscosity_.stiffness(static_cast<std::size_t>(full_begin_) + k);
    laws_[simd::law_tension][k] = tension_[k] / stiffness;
  }
}

/// To the elastic forces on its corners and its energy, which are there.
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
  parallel::for_each(threads, viscous.size(), element_grain, [&](std::size_t k) {
    viscosity_.advance(static_cast<std::size_t>(viscous[k]), biot_stress(deformation(viscous[k], positions)));
  });
}

}  // namespace palpate::fem
