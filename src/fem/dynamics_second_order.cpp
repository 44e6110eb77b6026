#include <algorithm>

#include "fem/dynamics.hpp"
#include "fem/grains.hpp"

// Steps of second order: BDF2 as a step of implicit Euler from extrapolated positions and velocities.
namespace palpate::fem {
void Dynamics::keep_past(bool on) {
  keeps_past_ = on;
  if (!on) forget_past();
}

void Dynamics::forget_past() {
  past_positions_.clear();
  past_velocities_.clear();
}

/// Stores the positions and velocities at the start of the step. Call before they are replaced by those at
/// the end.
void Dynamics::store_past() {
  if (!keeps_past_) return;
  past_duration_ = duration_;
  const std::vector<Vec3>& positions = second_order_ ? start_positions_ : positions_;
  const std::vector<Vec3>& velocities = second_order_ ? start_velocities_ : velocities_;
  past_positions_.assign(positions.begin(), positions.end());
  past_velocities_.assign(velocities.begin(), velocities.end());
}

bool Dynamics::start_second_order(double time_step) {
  if (past_positions_.empty() || past_duration_ != time_step) return false;
  rotations_.begin(threads_, positions_, velocities_, time_step);
  if (rotations_.any()) return false;
  start_positions_.assign(positions_.begin(), positions_.end());
  start_velocities_.assign(velocities_.begin(), velocities_.end());
  constexpr double third = 1.0 / 3.0;
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    if (system_.free()[i] == 0) return;
    positions_[i] += third * (positions_[i] - past_positions_[i]);
    velocities_[i] += third * (velocities_[i] - past_velocities_[i]);
  });
  for (std::size_t k = 0; k < prescribed_points_.size(); ++k) {
    Vec3& x = at(positions_, prescribed_points_[k]);
    x += third * (prescribed_positions_[k] - x);
  }
  second_order_ = true;
  updated_ = false;
  return true;
}

void Dynamics::cancel_step() {
  if (!second_order_) return;
  second_order_ = false;
  std::swap(positions_, start_positions_);
  std::swap(velocities_, start_velocities_);
  updated_ = false;
}

}  // namespace palpate::fem
