// The iteration of ReducedStep: Newton's method; if that fails, the forces as unknowns or the convex problem.
#include <algorithm>
#include <cmath>

#include "fem/elimination.hpp"
#include "fem/reduced_step.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t newton_grain = 256;  // contacts
/// Stop if |F| has fallen to this fraction of its first value.
constexpr double reduction = 0.1;
constexpr int most_rounds = 2;
/// Up to how many contacts their forces may be the unknowns.
constexpr std::size_t few_contacts = 64;
/// A minimum counts as found if slopes, or |F|, have this ratio.
constexpr double flat = 0.1;

}  // namespace

/// False if the last direction depends linearly on the others, up to rounding.
bool ReducedStep::factor_gram() {
  constexpr double rounding = 1e-10;
  for (std::size_t i = 0; i < size_; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = gram_[stride_ * i + j];
      for (std::size_t k = 0; k < j; ++k) sum -= lower_[stride_ * i + k] * lower_[stride_ * j + k];
      if (i == j) {
        if (!(sum > rounding * gram_[stride_ * i + i])) return false;
        lower_[stride_ * i + i] = std::sqrt(sum);
      } else {
        lower_[stride_ * i + j] = sum / lower_[stride_ * j + j];
      }
    }
  }
  return true;
}

/// x = L^-1 x, with the Cholesky factor L of G.
void ReducedStep::solve_lower(double* x) const {
  for (std::size_t i = 0; i < size_; ++i) {
    double sum = x[i];
    for (std::size_t k = 0; k < i; ++k) sum -= lower_[stride_ * i + k] * x[k];
    x[i] = sum / lower_[stride_ * i + i];
  }
}

/// Norm of F by G^-1, which equals the norm by G of the step G^-1 F.
double ReducedStep::norm(std::span<const double> f) {
  std::copy_n(f.begin(), size_, solved_.begin());
  solve_lower(solved_.data());
  double square = 0.0;
  for (std::size_t i = 0; i < size_; ++i) square += solved_[i] * solved_[i];
  return std::sqrt(square);
}

/// Solves matrix_ step = f; false if matrix_ is singular.
bool ReducedStep::solve_linear(std::span<const double> f, std::vector<double>& step) {
  std::copy_n(f.begin(), size_, step.begin());
  return solve_by_elimination(matrix_.data(), stride_, size_, step.data());
}

/// One Newton step with the true derivatives. If |F| does not decrease, returns false and changes nothing.
bool ReducedStep::step_newton(const parallel::Threads& threads) {
  constexpr int halvings = 4;
  constexpr double enough = 0.3;
  assemble(threads, false);
  if (!solve_linear(f_, step_)) return false;
  find_step_velocities(threads);
  double step_length = 1.0;
  for (int i = 0; i < halvings; ++i, step_length *= 0.5) {
    try_step(threads, step_length, false);
    project(threads, trial_c_, trial_forces_, trial_f_);
    const double found = norm(trial_f_);
    if (!(found < (1.0 - enough * step_length) * size_of_f_)) continue;
    accept_trial();
    std::swap(f_, trial_f_);
    size_of_f_ = found;
    return true;
  }
  return false;
}

/// Approximate line search on the convex function with fixed friction bounds. Returns the fraction of step_
/// with the lowest value; 0 if the function increases from the start. O(contacts) a trial.
double ReducedStep::search_line(const parallel::Threads& threads) {
  constexpr int halvings = 8;
  constexpr double furthest = 64.0;
  double constant = 0.0;
  double curvature = 0.0;
  for (std::size_t i = 0; i < size_; ++i) {
    double along_c = 0.0;
    double along_step = 0.0;
    for (std::size_t j = 0; j < size_; ++j) {
      along_c += gram_[stride_ * i + j] * c_[j];
      along_step += gram_[stride_ * i + j] * step_[j];
    }
    constant += step_[i] * (g_[i] - along_c);
    curvature += step_[i] * along_step;
  }
  // step^T F: the negative slope of the function.
  const auto slope = [&](double step_length) {
    try_step(threads, step_length, true);
    const double work = parallel::sum(threads, laws_.size(), partial_, [&](std::size_t k) {
      return dot(step_velocities_[k], trial_forces_[k]);
    });
    return constant - step_length * curvature + friction_.time_step * work;
  };
  const double at_start = slope(0.0);
  if (!(at_start > 0.0)) return 0.0;
  double low = 0.0;
  double high = 1.0;
  double at_high = slope(high);
  while (high < furthest && at_high > flat * at_start) {
    low = high;
    high *= 2.0;
    at_high = slope(high);
  }
  for (int k = 0; k < halvings && std::abs(at_high) > flat * at_start; ++k) {
    const double middle = 0.5 * (low + high);
    const double at_middle = slope(middle);
    if (at_middle > flat * at_start) {
      low = middle;
    } else {
      high = middle;
      at_high = at_middle;
    }
  }
  return high;
}

/// One step of the outer iteration: fixes the friction bounds at the current c. The contact problem is then
/// the minimum of a convex function of c, which this finds. Returns false if c does not change.
bool ReducedStep::step_convex(const parallel::Threads& threads) {
  constexpr int most_steps = 8;
  parallel::for_each(threads, laws_.size(), newton_grain, [&](std::size_t k) {
    bounds_[k] = friction_.coefficient * contact_force(laws_[k], friction_, velocities_[k]).normal;
  });
  find_forces(threads, velocities_, true, forces_);
  project(threads, c_, forces_, f_);
  const double first = norm(f_);
  for (int i = 0; i < most_steps && norm(f_) > flat * first; ++i) {
    assemble(threads, true);
    if (!solve_linear(f_, step_)) break;
    find_step_velocities(threads);
    const double step_length = search_line(threads);
    if (step_length == 0.0) break;
    try_step(threads, step_length, true);
    accept_trial();
    project(threads, c_, forces_, f_);
  }
  find_forces(threads, velocities_, false, forces_);
  project(threads, c_, forces_, f_);
  const double found = norm(f_);
  const bool moved = found != size_of_f_;
  size_of_f_ = found;
  return moved;
}

bool ReducedStep::solve(const parallel::Threads& threads) {
  std::ranges::copy(c_, change_.begin());
  const bool independent = factor_gram();
  if (!independent) {
    --size_;
    c_[size_] = 0.0;
    clear_stiffness();
  }
  if (independent) {
    if (at_base_) std::copy_n(g_.begin(), size_, f_.begin());
    at_base_ = false;
    size_of_f_ = norm(f_);
    const double enough = reduction * size_of_f_;
    for (int round = 0; round < most_rounds && size_of_f_ > enough; ++round) {
      if (step_newton(threads)) continue;
      if (forces_help_ && laws_.size() <= few_contacts && step_forces(threads)) continue;
      const double before = size_of_f_;
      if (!step_convex(threads)) break;
      forces_help_ = forces_help_ || size_of_f_ > before;
    }
  }
  for (std::size_t i = 0; i < change_.size(); ++i) change_[i] = c_[i] - change_[i];
  return independent;
}

}  // namespace palpate::fem
