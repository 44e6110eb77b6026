#include "fem/contact_law.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::fem {
namespace {

Vec3 spring_pull(const ContactLaw& law, double time_step, const Vec3& u) {
  return -law.stiffness * law.slip - law.resistance(time_step) * (u - dot(u, law.direction) * law.direction);
}

double normal_force(const ContactLaw& law, double time_step, const Vec3& u) {
  return std::max(law.stiffness * law.depth - law.resistance(time_step) * dot(u, law.direction), 0.0);
}

Vec3 bounded(const Vec3& a, double most) {
  const double size = length(a);
  return size > most ? (most / size) * a : a;
}

}  // namespace

ContactForce contact_force(const ContactLaw& law, const StepFriction& step, const Vec3& u) {
  const double normal = normal_force(law, step.time_step, u);
  const Vec3 pull = spring_pull(law, step.time_step, u);
  return {.normal = normal, .pull = pull, .friction = bounded(pull, step.coefficient * normal)};
}

double contact_potential(const ContactLaw& law, double time_step, double friction_bound, const Vec3& u) {
  const double normal = normal_force(law, time_step, u);
  const double pull = length(spring_pull(law, time_step, u));
  const double sliding = std::max(pull - friction_bound, 0.0);
  return (normal * normal + pull * pull - sliding * sliding) / (2.0 * law.resistance(time_step));
}

void put_in_rows(std::span<const ContactLaw> laws, double time_step, simd::AlignedVector<double>& rows) {
  constexpr std::size_t lanes = simd::law_lanes;
  const std::size_t numbers = simd::law_values * ((laws.size() + lanes - 1) / lanes);
  if (rows.capacity() < numbers) rows.reserve(numbers + numbers / 8);
  rows.assign(numbers, 0.0);
  for (std::size_t k = 0; k < laws.size(); ++k) {
    const ContactLaw& law = laws[k];
    const Vec3& n = law.direction;
    const Vec3 pull = law.stiffness * law.slip;
    double* row = &rows[simd::law_values * (k / lanes) + k % lanes];
    for (const double value :
         {law.stiffness * law.depth, law.resistance(time_step), n.x, n.y, n.z, pull.x, pull.y, pull.z}) {
      *row = value;
      row += lanes;
    }
  }
}

void linearise(const ContactLaw& law, const StepFriction& step, const Vec3& u, Coupling& coupling) {
  coupling.force = {};
  coupling.stiffness = {};
  coupling.damping = {};
  const ContactForce at_u = contact_force(law, step, u);
  if (at_u.normal == 0.0) return;
  const double resistance = law.resistance(step.time_step);
  const double bound = step.coefficient * at_u.normal;
  const double pull = length(at_u.pull);
  const double across = pull > bound ? resistance * bound / pull : resistance;
  const double more = resistance - across;
  const Vec3& n = law.direction;
  coupling.damping = {across + more * n.x * n.x, across + more * n.y * n.y, across + more * n.z * n.z,
                      more * n.x * n.y,          more * n.x * n.z,          more * n.y * n.z};
  coupling.force = at_u.whole(n) + coupling.damping * u;
}

}  // namespace palpate::fem
