// Steps with contacts: linear systems while contacts keep their status, otherwise ContactSolver.
#include <algorithm>
#include <cmath>

#include "fem/dynamics.hpp"
#include "fem/grains.hpp"

namespace palpate::fem {
namespace {

/// A linear system is accepted if the error of its forces is at most this; see contact_error().
constexpr double force_tolerance = 0.01;
/// Maximum number of linear systems. Contacts are linearised at the solution before.
constexpr int most_linear = 3;
/// Above this error no further linear system is tried.
constexpr double hopeless_error = 1.0;

}  // namespace

/// Linearises the contacts' couplings at the current velocities.
void Dynamics::linearise_contacts(const ContactSet& contacts) {
  const auto own = contacts.couplings.subspan(contacts.first);
  parallel::for_each(threads_, own.size(), contact_grain, [&](std::size_t c) {
    fem::linearise(contacts.laws[c], contacts.friction, relative(own[c], mean_velocities_), own[c]);
  });
}

/// Largest difference between the couplings' forces and those of the laws at the solution, relative to the
/// root mean square of the normal forces (for friction: of its bounds).
double Dynamics::contact_error(const ContactSet& contacts) {
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
    along = std::max(along, std::abs(part));
    across = std::max(across, length(off - part * r));
  }
  if (along == 0.0 && across == 0.0) return 0.0;
  const double unit = std::sqrt(normals / static_cast<double>(own.size()));
  return std::max(along / unit, friction > 0.0 ? across / (friction * unit) : 0.0);
}

/// Stores the forces that acted in the couplings: those of the linearised contacts, or of the laws.
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

/// Solves linear systems, each with contacts linearised at the solution before. Returns whether contact
/// forces agree with the laws.
bool Dynamics::solve_linearised(const ContactSet& contacts, const SolveGoal& goal, Report& report) {
  double error = 0.0;
  do {
    const Report last = report;
    report = solve(contacts.couplings, goal);
    report.iterations += last.iterations;
    report.solves += last.solves;
    error = report.converged ? contact_error(contacts) : hopeless_error;
    if (error <= force_tolerance) return true;
    linearise_contacts(contacts);
  } while (report.solves < most_linear && error < hopeless_error);
  return false;
}

Dynamics::Report Dynamics::solve(const ContactSet& contacts, SolveGoal goal, bool steady) {
  if (contacts.laws.empty()) return solve(contacts.couplings, goal);
  linearise_contacts(contacts);
  Report linear{.solves = 0};
  if (steady && solve_linearised(contacts, goal, linear)) {
    put_forces(contacts, false);
    return linear;
  }
  goal.least_scale = least_scale(goal.tolerance);
  goal.load_scale = load_scale_;
  goal.least_residual = load_impulse_;
  goal.jacobi_iterations = jacobi_iterations_of_contacts_;
  goal.error_per_bound = error_per_bound_;
  couplings_.set(threads_, contacts.couplings.first(contacts.first), time_step_, free_);
  system_.update_preconditioner(threads_);
  compute_right_side();
  check_right_side();
  stiff_couplings_.set(threads_, contacts.couplings, time_step_, free_);
  stiff_system_.update_preconditioner(threads_);
  multigrid().begin_step();
  Report report = contact_solver_.solve(threads_,
                                        {.system = &system_,
                                         .stiffened = &stiff_system_,
                                         .laws = contacts.laws,
                                         .couplings = contacts.couplings,
                                         .friction = contacts.friction,
                                         .base = base_velocities_},
                                        right_side_, solution_, goal, multigrid(), linear_positions(),
                                        reuses_directions_);
  reuses_directions_ = report.converged;  // a failed solve may have been misled by its directions
  has_linear_couplings_ = contacts.first > 0;
  jacobi_iterations_of_contacts_ = report.jacobi_iterations;
  error_per_bound_ = report.error_per_bound;
  check_solution(report.relative_residual);
  find_end();
  put_forces(contacts, true);
  report.iterations += linear.iterations;
  report.solves += linear.solves;
  return report;
}

}  // namespace palpate::fem
