// Steps with contacts: the linear system at the guess where contacts hold as it says, else ContactSolver.
#include <algorithm>
#include <cmath>

#include "fem/dynamics.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t contact_grain = 256;
/// Root mean square of the errors of forces, by that of the normal forces (of friction: of its bounds), at
/// which a linear system will do.
constexpr double force_tolerance = 0.01;

}  // namespace

/// Couplings as contacts are at the velocities that there are.
void Dynamics::linearise_contacts(const ContactSet& contacts) {
  const auto own = contacts.couplings.subspan(contacts.first);
  parallel::for_each(threads_, own.size(), contact_grain, [&](std::size_t c) {
    fem::linearise(contacts.laws[c], contacts.friction, relative(own[c], mean_velocities_), own[c]);
  });
}

/// Whether the forces of the couplings are those that the laws ask for at the velocities that they led to.
bool Dynamics::contacts_agree(const ContactSet& contacts) {
  const auto own = contacts.couplings.subspan(contacts.first);
  const double friction = contacts.friction.coefficient;
  double normals = 0.0;
  double along = 0.0;
  double across = 0.0;
  for (std::size_t c = 0; c < own.size(); ++c) {
    const Vec3& r = contacts.laws[c].direction;
    const ContactForce force =
        contact_force(contacts.laws[c], contacts.friction, relative(own[c], mean_velocities_));
    const Vec3 off = force.whole(r) - end_force(own[c], time_step_, mean_velocities_);
    const double part = dot(off, r);
    normals += force.normal * force.normal;
    along += part * part;
    across += squared_length(off - part * r);
  }
  const double allowed = force_tolerance * force_tolerance * normals;
  return along <= allowed && across <= friction * friction * allowed;
}

/// The forces that acted, for those who sum them up: of the couplings, or those of the laws.
void Dynamics::put_forces(const ContactSet& contacts, bool of_laws) {
  const auto own = contacts.couplings.subspan(contacts.first);
  parallel::for_each(threads_, own.size(), contact_grain, [&](std::size_t c) {
    const ContactLaw& law = contacts.laws[c];
    own[c].force =
        of_laws
            ? contact_force(law, contacts.friction, relative(own[c], mean_velocities_)).whole(law.direction)
            : end_force(own[c], time_step_, mean_velocities_);
    own[c].stiffness = {};
    own[c].damping = {};
  });
}

Dynamics::Report Dynamics::solve(const ContactSet& contacts, SolveGoal goal, bool steady) {
  if (contacts.laws.empty()) return solve(contacts.couplings, goal);
  linearise_contacts(contacts);
  int iterations = 0;
  if (steady) {
    const Report report = solve(contacts.couplings, goal);
    if (report.converged && contacts_agree(contacts)) {
      put_forces(contacts, false);
      return report;
    }
    iterations = report.iterations;
    linearise_contacts(contacts);
  }
  goal.least_scale = load_scale_;
  goal.least_residual = load_impulse_;
  goal.jacobi_iterations = jacobi_iterations_;
  couplings_.set(contacts.couplings.first(contacts.first), time_step_, free_);
  system_.update_preconditioner(threads_);
  compute_right_side();
  check_right_side();
  stiff_couplings_.set(contacts.couplings, time_step_, free_);
  stiff_system_.update_preconditioner(threads_);
  multigrid_.begin_step();
  Report report = contact_solver_.solve(threads_,
                                        {.system = &system_,
                                         .stiffened = &stiff_system_,
                                         .laws = contacts.laws,
                                         .couplings = contacts.couplings,
                                         .friction = contacts.friction,
                                         .base = base_velocities_},
                                        right_side_, solution_, goal, multigrid_, positions_, goes_on_);
  goes_on_ = true;
  jacobi_iterations_ = report.jacobi_iterations;
  check_solution(report.relative_residual);
  find_end();
  put_forces(contacts, true);
  report.iterations += iterations;
  report.solves = steady ? 2 : 1;
  return report;
}

}  // namespace palpate::fem
