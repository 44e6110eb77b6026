// The step of ReducedStep with the forces of a few contacts as unknowns.
#include <algorithm>

#include "fem/reduced_step.hpp"
#include "room.hpp"

namespace palpate::fem {
namespace {

/// The result is taken if it reduces |F| to this fraction.
constexpr double enough_reduction = 0.7;

}  // namespace

/// With y = L^T c, computes the rows J_k L^-T of the contacts, and the y (solved_) and the velocities without
/// contact forces.
void ReducedStep::condense() {
  const std::size_t n = size_;
  const std::size_t count = laws_.size();
  resize_with_room(condensed_rows_, 3 * n * count);
  resize_with_room(free_velocities_, count);
  for (std::size_t row = 0; row < 3 * count; ++row) {
    double* to = &condensed_rows_[n * row];
    for (std::size_t i = 0; i < n; ++i) to[i] = static_cast<double>(rates_[stride_ * row + i]);
    solve_lower(to);
  }
  std::copy_n(g_.begin(), n, solved_.begin());
  solve_lower(solved_.data());
  condensed().find_y({base_forces_.data(), count}, {step_.data(), n});
  for (std::size_t i = 0; i < n; ++i) solved_[i] -= step_[i];
  for (std::size_t k = 0; k < count; ++k)
    free_velocities_[k] = condensed().add_velocity(k, solved_, base_velocities_[k]);
}

CondensedContacts ReducedStep::condensed() const {
  return {
      .laws = laws_, .friction = friction_, .free = free_velocities_, .rows = condensed_rows_, .size = size_};
}

/// Solves for the forces of the contacts, as far as ForceNewton can. If |F| does not decrease clearly,
/// returns false, and c is unchanged.
bool ReducedStep::step_forces(const parallel::Threads& threads) {
  const std::size_t n = size_;
  const std::size_t count = laws_.size();
  condense();
  for (std::size_t k = 0; k < count; ++k) trial_forces_[k] = base_forces_[k] + forces_[k];
  const std::span<Vec3> forces(trial_forces_.data(), count);
  force_newton_.solve(condensed(), forces);
  condensed().find_y(forces, {step_.data(), n});
  for (std::size_t i = n; i-- > 0;) {
    double sum = solved_[i] + step_[i];
    for (std::size_t k = i + 1; k < n; ++k) sum -= lower_[stride_ * k + i] * trial_c_[k];
    trial_c_[i] = sum / lower_[stride_ * i + i];
  }
  for (std::size_t i = 0; i < n; ++i) step_[i] = trial_c_[i] - c_[i];
  find_step_velocities(threads);
  try_step(threads, 1.0, false);
  project(threads, trial_c_, trial_forces_, trial_f_);
  const double found = norm(trial_f_);
  forces_help_ = found < enough_reduction * size_of_f_;
  if (!forces_help_) return false;
  accept_trial();
  std::swap(f_, trial_f_);
  size_of_f_ = found;
  return true;
}

}  // namespace palpate::fem
