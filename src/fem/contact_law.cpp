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

/// m += a b^T
void add_product(const Vec3& a, const Vec3& b, Matrix3& m) {
  const std::array rows{a.x, a.y, a.z};
  const std::array columns{b.x, b.y, b.z};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) m.values[3 * i + j] += rows[i] * columns[j];
  }
}

/// R n n^T where it pushes, and what holds across it at this bound.
Matrix3 derivative_at(const ContactLaw& law, double resistance, bool pushes, const Vec3& pull, double bound) {
  const double size = length(pull);
  const bool slides = size > bound;
  const double across = slides ? resistance * bound / size : resistance;
  Matrix3 h{};
  for (std::size_t i = 0; i < 3; ++i) h.values[4 * i] = across;
  add_product(((pushes ? resistance : 0.0) - across) * law.direction, law.direction, h);
  if (slides) add_product((-across / (size * size)) * pull, pull, h);
  return h;
}

}  // namespace

ContactForce contact_force(const ContactLaw& law, const StepFriction& step, const Vec3& u) {
  const double normal = normal_force(law, step.time_step, u);
  const Vec3 pull = spring_pull(law, step.time_step, u);
  return {.normal = normal, .pull = pull, .friction = bounded(pull, step.coefficient * normal)};
}

Vec3 force_with_bound(const ContactLaw& law, const StepFriction& step, const Vec3& u, double bound) {
  return normal_force(law, step.time_step, u) * law.direction +
         bounded(spring_pull(law, step.time_step, u), bound);
}

Matrix3 derivative(const ContactLaw& law, const StepFriction& step, const Vec3& u) {
  const ContactForce at_u = contact_force(law, step, u);
  if (at_u.normal == 0.0) return {};
  const double resistance = law.resistance(step.time_step);
  const double bound = step.coefficient * at_u.normal;
  Matrix3 h = derivative_at(law, resistance, true, at_u.pull, bound);
  const double pull = length(at_u.pull);
  if (pull > bound) add_product((step.coefficient * resistance / pull) * at_u.pull, law.direction, h);
  return h;
}

Matrix3 derivative_with_bound(const ContactLaw& law, const StepFriction& step, const Vec3& u, double bound) {
  const bool pushes = normal_force(law, step.time_step, u) > 0.0;
  return derivative_at(law, law.resistance(step.time_step), pushes, spring_pull(law, step.time_step, u),
                       bound);
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
