// Sweeps of ReducedStep: the problem is solved for one contact after the other.
#include <algorithm>
#include <cmath>

#include "fem/reduced_step.hpp"
#include "fem/single_contact.hpp"
#include "room.hpp"

namespace palpate::fem {
namespace {

constexpr int most_sweeps = 20;
/// Sweeps end if the last one changed the step by at most this fraction of the first one.
constexpr double small_change = 0.01;
/// Sweeps also end if the second or a later one reduced the squared change to no less than this fraction.
constexpr double slow = 0.5;
/// The result is taken if it reduces |F| to this fraction.
constexpr double enough_reduction = 0.7;

}  // namespace

/// Computes the rows J_k L^-T and the responses h J_k G^-1 J_k^T of the contacts, and y = L^T c for the c to
/// which the current forces lead.
void ReducedStep::begin_sweeps() {
  const std::size_t n = size_;
  const double h = friction_.time_step;
  resize_with_room(sweep_rows_, 3 * n * laws_.size());
  resize_with_room(responses_, laws_.size());
  std::copy_n(g_.begin(), n, solved_.begin());
  solve_lower(solved_.data());
  for (std::size_t k = 0; k < laws_.size(); ++k) {
    double* rows = &sweep_rows_[3 * n * k];
    for (std::size_t e = 0; e < 3; ++e) {
      const float* rates = &rates_[stride_ * (3 * k + e)];
      for (std::size_t i = 0; i < n; ++i) rows[n * e + i] = static_cast<double>(rates[i]);
      solve_lower(rows + n * e);
    }
    responses_[k] = {};
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 column{rows[i], rows[n + i], rows[2 * n + i]};
      add_outer(responses_[k], h, column, column);
      solved_[i] += h * dot(column, forces_[k]);
    }
  }
}

/// Solves each contact with the forces of the others fixed. Returns the squared change of c in the norm of G.
double ReducedStep::sweep() {
  const std::size_t n = size_;
  const double h = friction_.time_step;
  double changed = 0.0;
  for (std::size_t k = 0; k < laws_.size(); ++k) {
    const double* rows = &sweep_rows_[3 * n * k];
    Vec3 u = base_velocities_[k];
    for (std::size_t i = 0; i < n; ++i) u += solved_[i] * Vec3{rows[i], rows[n + i], rows[2 * n + i]};
    const Vec3 last = base_forces_[k] + forces_[k];
    const Vec3 change =
        single_contact_force(laws_[k], friction_, responses_[k], u - responses_[k] * last, last) - last;
    forces_[k] += change;
    for (std::size_t i = 0; i < n; ++i) {
      const double d = h * dot(change, Vec3{rows[i], rows[n + i], rows[2 * n + i]});
      solved_[i] += d;
      changed += d * d;
    }
  }
  return changed;
}

/// Nonlinear Gauss-Seidel: sweeps over the contacts, each solved exactly. If |F| does not decrease clearly,
/// returns false, and c is unchanged.
bool ReducedStep::step_sweeps(const parallel::Threads& threads) {
  trial_forces_ = forces_;
  begin_sweeps();
  const double first = sweep();
  double last = first;
  for (int i = 1; i < most_sweeps && last > small_change * small_change * first; ++i) {
    const double now = sweep();
    if (i > 1 && now > slow * last) break;
    last = now;
  }
  std::swap(forces_, trial_forces_);
  for (std::size_t i = size_; i-- > 0;) {
    double sum = solved_[i];
    for (std::size_t k = i + 1; k < size_; ++k) sum -= lower_[stride_ * k + i] * trial_c_[k];
    trial_c_[i] = sum / lower_[stride_ * i + i];
    step_[i] = trial_c_[i] - c_[i];
  }
  find_step_velocities(threads);
  try_step(threads, 1.0, false);
  project(threads, trial_c_, trial_forces_, trial_f_);
  const double found = norm(trial_f_);
  sweeps_help_ = found < enough_reduction * size_of_f_;
  if (!sweeps_help_) return false;
  accept_trial();
  std::swap(f_, trial_f_);
  size_of_f_ = found;
  return true;
}

}  // namespace palpate::fem
