#include <algorithm>
#include <utility>

#include <palpate/error.hpp>

#include "fem/check_length.hpp"
#include "fem/dynamics.hpp"

// The part of Dynamics that gets and sets its state.
namespace palpate::fem {

void Dynamics::check_points(std::span<const Vec3> values, const char* name) {
  check_length(name, values.size(), masses_.size(), "point");
  if (!all_finite(values)) throw Error("dynamics", name, "a value that is not finite", "finite values");
}

void Dynamics::set_positions(std::span<const Vec3> positions) {
  check_points(positions, "positions");
  std::copy(positions.begin(), positions.end(), positions_.begin());
  updated_ = false;
  forget_past();
}

void Dynamics::set_moving(std::span<const Vec3> values, const char* name, std::vector<Vec3>& target) {
  check_points(values, name);
  for (std::size_t i = 0; i < values.size(); ++i) target[i] = system_.free()[i] != 0 ? values[i] : Vec3{};
  holds_.stop(target);
}

void Dynamics::set_velocities(std::span<const Vec3> velocities) {
  set_moving(velocities, "velocities", velocities_);
  forget_past();
}

void Dynamics::set_velocities(std::span<const Index> points, std::span<const Vec3> velocities) {
  for (std::size_t i = 0; i < points.size(); ++i) at(velocities_, points[i]) = velocities[i];
  forget_past();
}

void Dynamics::set_velocity_changes(std::span<const Vec3> changes) {
  set_moving(changes, "velocity_changes", velocity_changes_);
}

void Dynamics::check_tensors(const char* name, std::span<const SymmetricMatrix3> values, std::size_t expected,
                             const char* per) {
  check_length(name, values.size(), expected, per);
  for (const SymmetricMatrix3& value : values) {
    if (!std::isfinite(norm(value)))
      throw Error("dynamics", name, "a value that is not finite", "finite values");
  }
}

void Dynamics::set_plastic_strains(std::span<const SymmetricMatrix3> strains) {
  check_tensors("plastic_strains", strains, elements_.plastic_strains().size(), "element that can yield");
  updated_ = false;
  elements_.set_plastic_strains(strains);
}

DynamicsState Dynamics::state() const {
  const auto strains = elements_.plastic_strains();
  return {.positions = positions_,
          .velocities = velocities_,
          .velocity_changes = velocity_changes_,
          .plastic_strains = {strains.begin(), strains.end()},
          .viscous_stresses = elements_.viscous_stresses(),
          .inversion_clocks = inversion_clocks_,
          .jacobi_iterations = jacobi_iterations_,
          .jacobi_iterations_of_contacts = jacobi_iterations_of_contacts_,
          .error_per_bound = error_per_bound_,
          .multigrid_reference = multigrid_.reference(),
          .multigrid_stale_iterations = multigrid_.stale_iterations(),
          .past_positions = past_positions_,
          .past_velocities = past_velocities_,
          .past_duration = past_duration_,
          .contact_losses = energy_limit_.losses(),
          .second_order_multigrid_reference = second_order_multigrid_.reference(),
          .second_order_multigrid_stale_iterations = second_order_multigrid_.stale_iterations()};
}

void Dynamics::set_state(const DynamicsState& state) {
  check_points(state.positions, "positions");
  check_points(state.velocities, "velocities");
  check_points(state.velocity_changes, "velocity_changes");
  check_tensors("plastic_strains", state.plastic_strains, elements_.plastic_strains().size(),
                "element that can yield");
  check_tensors("viscous_stresses", state.viscous_stresses, elements_.viscous_stresses().size(),
                "element and term");
  const auto check_optional = [&](std::span<const Vec3> values, const char* name) {
    if (!values.empty()) check_points(values, name);
  };
  check_optional(state.multigrid_reference, "multigrid_reference");
  check_optional(state.second_order_multigrid_reference, "second_order_multigrid_reference");
  check_optional(state.past_positions, "past_positions");
  if (state.past_positions.size() != state.past_velocities.size())
    check_length("past_velocities", state.past_velocities.size(), state.past_positions.size(), "point");
  check_optional(state.past_velocities, "past_velocities");
  check_length("contact_losses", state.contact_losses.size(), bodies_.size(), "body");
  for (const double loss : state.contact_losses) {
    if (!(loss >= 0.0 && std::isfinite(loss)))
      throw Error("dynamics", "contact_losses", "a value that is negative or not finite", "energies >= 0");
  }
  set_inversion_clocks(state.inversion_clocks);  // nothing below throws
  std::ranges::copy(state.positions, positions_.begin());
  // Not set_velocities(): it would drop the velocities of prescribed points, which friction depends on.
  std::ranges::copy(state.velocities, velocities_.begin());
  std::ranges::copy(state.velocity_changes, velocity_changes_.begin());
  elements_.set_plastic_strains(state.plastic_strains);
  elements_.set_viscous_stresses(state.viscous_stresses);
  jacobi_iterations_ = state.jacobi_iterations;
  jacobi_iterations_of_contacts_ = state.jacobi_iterations_of_contacts;
  error_per_bound_ = state.error_per_bound;
  multigrid_.set_reference(state.multigrid_reference, state.multigrid_stale_iterations);
  second_order_multigrid_.set_reference(state.second_order_multigrid_reference,
                                        state.second_order_multigrid_stale_iterations);
  past_positions_ = state.past_positions;
  past_velocities_ = state.past_velocities;
  past_duration_ = state.past_duration;
  energy_limit_.set_losses(state.contact_losses);
  updated_ = false;
}

std::int64_t Dynamics::inverted_elements() {
  update_elements();
  return static_cast<std::int64_t>(
      parallel::sum(threads_, static_cast<std::size_t>(elements_.size()), partial_,
                    [&](std::size_t e) { return elements_.inverted(static_cast<Index>(e)) ? 1.0 : 0.0; }));
}

}  // namespace palpate::fem
