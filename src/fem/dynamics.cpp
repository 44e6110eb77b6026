#include "fem/dynamics.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "fem/body_title.hpp"
#include "fem/lumping.hpp"
#include "fem/material_check.hpp"
#include "fem/padded_vectors.hpp"
#include "number_text.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t point_grain = 256;
constexpr const char* source_name = "dynamics";

void check_length(const char* name, std::size_t found, std::size_t expected, const char* per) {
  if (found == expected) return;
  throw Error(source_name, name, std::to_string(found) + " values",
              std::to_string(expected) + " values, one per " + per);
}

void check_materials(const Bodies& bodies, const Materials& materials) {
  const std::size_t body_count = bodies.bodies().size();
  const bool per_body = materials.of_tet.empty();
  if (per_body || materials.all.size() < body_count)
    check_length("materials", materials.all.size(), body_count, "body");
  for (std::size_t i = 0; i < materials.all.size(); ++i) {
    check_material(materials.all[i],
                   i < body_count ? body_title(bodies.bodies()[i]) : "material " + std::to_string(i));
  }
  if (!materials.fibre_of_tet.empty()) {
    check_length("fibres of tets", materials.fibre_of_tet.size(), bodies.tets().size(), "tet");
    if (!std::ranges::all_of(materials.fibre_of_tet, [](const Vec3& a) { return std::isfinite(length(a)); }))
      throw Error(source_name, "fibres of tets", "a direction that is not finite", "finite directions");
  }
  if (per_body) return;
  check_length("material of tets", materials.of_tet.size(), bodies.tets().size(), "tet");
  for (const Index material : materials.of_tet) {
    if (material >= 0 && static_cast<std::size_t>(material) < materials.all.size()) continue;
    throw Error(source_name, "material of tets", std::to_string(material),
                "an index of " + std::to_string(materials.all.size()) + " materials");
  }
}

/// Checks all arguments of the constructor, then returns the masses.
std::vector<double> checked_masses(const Bodies& bodies, const Materials& materials,
                                   std::span<const std::uint8_t> fixed,
                                   std::span<const std::uint8_t> obstacles) {
  const auto body_count = static_cast<std::size_t>(bodies.body_count());
  check_materials(bodies, materials);
  check_length("obstacle_bodies", obstacles.size(), body_count, "body");
  check_length("fixed_points", fixed.size(), bodies.points_rest().size(), "point");
  return lumped_masses(bodies, materials);
}

std::vector<std::uint8_t> moving_points(const Bodies& bodies, std::span<const double> masses,
                                        std::span<const std::uint8_t> fixed,
                                        std::span<const std::uint8_t> obstacles) {
  std::vector<std::uint8_t> moving(masses.size());
  for (std::size_t i = 0; i < moving.size(); ++i) {
    moving[i] = fixed[i] == 0 && masses[i] > 0.0 && at(obstacles, bodies.body_of_point()[i]) == 0;
  }
  return moving;
}

void require(bool good, const char* name, double found, const char* expected) {
  if (!good) throw Error(source_name, name, number_text(found), expected);
}

void check_step(double time_step, const Vec3& gravity) {
  require(time_step > 0.0 && std::isfinite(time_step), "time_step", time_step, "a number > 0 (s)");
  for (const double component : {gravity.x, gravity.y, gravity.z}) {
    require(std::isfinite(component), "gravity", component, "three finite numbers (m/s^2)");
  }
}

double largest_component(const Vec3& a) {
  return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)});
}

void check_solve(const SolveGoal& goal) {
  require(goal.tolerance >= 0.0, "tolerance", goal.tolerance, "a number >= 0");
  require(goal.max_iterations >= 0, "max_iterations", goal.max_iterations, "a number >= 0");
  require(goal.fixed_iterations >= 0, "fixed_iterations", goal.fixed_iterations, "a number >= 0");
}

}  // namespace

Dynamics::Dynamics(const Bodies& bodies, const Materials& materials, std::vector<std::uint8_t> fixed_points,
                   std::vector<std::uint8_t> obstacle_bodies, parallel::Threads threads)
    : threads_(std::move(threads)),
      bodies_(bodies.bodies().begin(), bodies.bodies().end()),
      body_of_point_(bodies.body_of_point().begin(), bodies.body_of_point().end()),
      masses_(checked_masses(bodies, materials, fixed_points, obstacle_bodies)),
      elements_(bodies, materials, obstacle_bodies),
      free_(moving_points(bodies, masses_, fixed_points, obstacle_bodies)),
      rigid_(obstacle_bodies),
      matrix_(elements_, free_),
      system_(matrix_, couplings_, free_),
      stiff_system_(matrix_, stiff_couplings_, free_),
      multigrid_(matrix_),
      second_order_multigrid_(matrix_),
      positions_(bodies.points_rest().begin(), bodies.points_rest().end()),
      rotations_(bodies, materials, masses_, obstacle_bodies) {
  const std::size_t points = masses_.size();
  const auto elements = static_cast<std::size_t>(elements_.size());
  point_mass_damping_ = mass_dampings(bodies, materials, masses_);
  element_stiffness_damping_.resize(elements);
  for (std::size_t e = 0; e < elements; ++e) {
    element_stiffness_damping_[e] =
        materials.of(elements_.tet_of_element()[e], elements_.body_of_element()[e]).stiffness_damping;
  }
  inversion_clocks_.resize(elements, 0.0);
  plastic_strains_next_.assign(elements_.plastic_strains().begin(), elements_.plastic_strains().end());
  end_positions_ = positions_;
  partial_.reserve(parallel::chunk_count(std::max(points, elements), parallel::sum_grain));
  diagonal_.resize(points);
  factors_.resize(elements);
  elastic_fractions_.resize(elements);
  damping_fractions_.resize(elements);
  full_points_.resize(points);
  for (Index e = elements_.nonlinear_begin(); e < elements_.size(); ++e) {
    for (const Index corner : at(elements_.corners(), e)) at(full_points_, corner) = 1;
  }
  for (auto* vector : {&velocities_, &velocity_changes_, &point_forces_, &mean_velocities_,
                       &linear_positions_, &loads_, &linear_forces_}) {
    vector->resize(points);
  }
  for (auto* vector : {&solution_, &right_side_, &free_right_side_, &base_velocities_, &rotation_velocities_,
                       &displacements_})
    vector->resize(points);
  for (const std::uint8_t free : free_) held_axes_.push_back(free != 0 ? 0 : all_axes);
  mark_held_bodies();
}

/// Marks bodies with points that do not move freely, and nonlinear ones, whose end positions are found
/// otherwise.
void Dynamics::mark_held_bodies() {
  held_bodies_.assign(bodies_.size(), 0);
  for (std::size_t i = 0; i < masses_.size(); ++i)
    if (held_axes_[i] != 0 || is_full(i)) at(held_bodies_, body_of_point_[i]) = 1;
}

void Dynamics::set_fixed_axes(const Bodies& bodies, const Materials& materials,
                              std::span<const std::uint8_t> axes) {
  holds_ = AxisHolds(bodies, materials, axes, free_, masses_);
  holds_.mark(held_axes_);
  mark_held_bodies();
  holds_.stop(velocities_);
}

/// Sets the mass part and the stiffness factors of the matrix (linearise()).
void Dynamics::set_time_step(double time_step) {
  if (time_step == time_step_) return;
  time_step_ = time_step;
  updated_ = false;
  for (std::size_t i = 0; i < masses_.size(); ++i) {
    diagonal_[i] = masses_[i] * (1.0 + time_step * point_mass_damping_[i]);
  }
  elements_.set_time_step(time_step);
  for (std::size_t e = 0; e < factors_.size(); ++e) {
    const double elastic = time_step * elements_.viscosity().stiffness(e);
    factors_[e] = time_step * (element_stiffness_damping_[e] + elastic);
    elastic_fractions_[e] = elastic / (element_stiffness_damping_[e] + elastic);
    damping_fractions_[e] = 1.0 - elastic_fractions_[e];
  }
  elements_.set_factors(factors_);
}

/// Makes B = (1 + h a) M + (h b + h^2) K', with the damping a and b of the tets, and the forces: at the
/// positions at the start of the step, or at those of rotated bodies.
void Dynamics::linearise() {
  goes_on_ = false;
  at_end_ = false;
  set_base_velocities();
  if (rotations_.any() || refined_ || second_order_) {
    place_linear_positions();
    refined_ = refined_ || second_order_;
    elements_.update(threads_, linear_positions_);
    updated_ = false;
  } else {
    update_elements();
  }
  form_system();
}

/// Makes the matrix and the right side from the present elements.
void Dynamics::form_system() {
  matrix_.assemble(threads_, diagonal_);
  compute_point_forces();
  if (refined_) {
    add_displacement_forces();
  } else if (rotations_.any()) {
    add_rotation_forces();
  }
  compute_free_right_side();
}

/// Adds the terms of rotated frames to the forces: (h b + h^2) K' (x' - x) / h, since K' acts on
/// displacements from the rotated positions x', and inertia.
void Dynamics::add_rotation_forces() {
  couplings_.set({}, time_step_, free_);
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    rotation_velocities_[i] = padded((1.0 / time_step_) * (linear_positions_[i] - positions_[i]));
  });
  system_.multiply_exactly(threads_, rotation_velocities_, right_side_);
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    if (system_.free()[i] == 0) return;
    const Vec3 stiff = unpadded(right_side_[i]) - diagonal_[i] * unpadded(rotation_velocities_[i]);
    point_forces_[i] += (1.0 / time_step_) * stiff +
                        masses_[i] * rotations_.inertial_acceleration(body_of_point_[i], positions_[i]);
  });
}

/// Updates the elements unless they are current: they are if measuring the energy has already updated them.
void Dynamics::update_elements() {
  if (!updated_) elements_.update(threads_, positions_);
  updated_ = true;
}

void Dynamics::compute_point_forces() {
  const auto elastic = elements_.point_forces();
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    if (system_.free()[i] != 0) point_forces_[i] = loads_[i] + unpadded(elastic[i]);
  });
}

/// Sets gravity and external forces, and their norms.
void Dynamics::set_loads(const Vec3& gravity, std::span<const Vec3> external_forces) {
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    if (system_.free()[i] == 0) return;
    loads_[i] = masses_[i] * gravity;
    if (!external_forces.empty()) loads_[i] += external_forces[i];
  });
  // Norms of the impulse of gravity and loads in a step, and of the velocities that it alone would give, by
  // mass. At rest all forces cancel, so only these give a scale for errors.
  load_impulse_ =
      time_step_ * std::sqrt(parallel::sum(threads_, masses_.size(), partial_,
                                           [&](std::size_t i) { return squared_length(loads_[i]); }));
  load_scale_ = time_step_ * std::sqrt(parallel::sum(threads_, masses_.size(), partial_, [&](std::size_t i) {
                  const double load = squared_length(loads_[i]);
                  return load == 0.0 ? 0.0 : load / diagonal_[i];
                }));
}

/// The right side without couplings, b = h f - (h C + h^2 K') v = h f + M v - B v, by a product with the
/// present matrix B. At points that are not free v is the prescribed velocity, so that their columns act on
/// the free rows. In rotated frames v is the mean velocity without forces.
void Dynamics::compute_free_right_side() {
  couplings_.set({}, time_step_, free_);
  system_.multiply_exactly(threads_, base_velocities_, free_right_side_);
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    if (system_.free()[i] == 0) return;
    free_right_side_[i] = padded(time_step_ * point_forces_[i] + masses_[i] * unpadded(base_velocities_[i]) -
                                 unpadded(free_right_side_[i]));
  });
}

/// Adds the couplings' part, h f - W v.
void Dynamics::compute_right_side() {
  couplings_.multiply(threads_, base_velocities_);
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    right_side_[i] = free_right_side_[i];
    const auto point = static_cast<Index>(i);
    if (system_.free()[i] == 0 || !couplings_.holds(point)) return;
    right_side_[i] = padded(unpadded(free_right_side_[i]) + time_step_ * couplings_.start_force(point) -
                            couplings_.product(point));
  });
  holds_.hold(time_step_, base_velocities_, right_side_);
}

/// Sets the guess to dv of the last step. If that is zero, to free fall, which is then exact at any
/// tolerance. The solver drops a guess that is worse than zero.
void Dynamics::set_initial_guess(double time_step, const Vec3& gravity) {
  const double changed = parallel::sum(threads_, masses_.size(), partial_, [&](std::size_t i) {
    return velocity_changes_[i] == Vec3{} ? 0.0 : 1.0;
  });
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    const Vec3 fall = system_.free()[i] != 0 ? time_step * gravity : Vec3{};
    solution_[i] = padded(changed > 0.0 ? velocity_changes_[i] : fall);
  });
}

Dynamics::Report Dynamics::step(double time_step, const Vec3& gravity, std::span<const Vec3> external_forces,
                                std::span<const Coupling> couplings, double tolerance, int max_iterations) {
  check_solve({.tolerance = tolerance, .max_iterations = max_iterations});
  begin_step(time_step, gravity, external_forces);
  Report report = solve(couplings, {.tolerance = tolerance, .max_iterations = max_iterations});
  constexpr int max_rotation_solves = 8;
  for (int round = 0; follow_rotations(); ++round) {
    if (round == max_rotation_solves) {
      report.converged = false;
      break;
    }
    report = solve(couplings, {.tolerance = tolerance, .max_iterations = max_iterations});
  }
  constexpr int most_linearisations = 20;
  for (int n = 0; follow_tissue(tolerance); ++n) {
    if (n == most_linearisations) {
      end_where_linearised();
      report.converged = false;
      break;
    }
    report = solve(couplings, {.tolerance = tolerance, .max_iterations = max_iterations});
  }
  end_step();
  return report;
}

void Dynamics::prescribe(std::span<const Index> points, std::span<const Vec3> positions) {
  prescribed_points_.assign(points.begin(), points.end());
  prescribed_positions_.assign(positions.begin(), positions.end());
}

/// Sets the velocities that the solution adds to. New frames change them, so the solution is adapted.
void Dynamics::set_base_velocities() {
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    if (system_.free()[i] == 0) {
      base_velocities_[i] = {};
      return;
    }
    const Vec3 velocity = rotations_.free_velocity(body_of_point_[i], positions_[i], velocities_[i]);
    solution_[i] = padded(unpadded(solution_[i]) + unpadded(base_velocities_[i]) - velocity);
    base_velocities_[i] = padded(velocity);
  });
  for (std::size_t k = 0; k < prescribed_points_.size(); ++k) {
    const Index i = prescribed_points_[k];
    at(base_velocities_, i) = padded((1.0 / time_step_) * (prescribed_positions_[k] - at(positions_, i)));
  }
}

void Dynamics::begin_step(double time_step, const Vec3& gravity, std::span<const Vec3> external_forces) {
  check_step(time_step, gravity);
  if (!external_forces.empty())
    check_length("external_forces", external_forces.size(), masses_.size(), "point");
  duration_ = time_step;
  set_time_step(second_order_ ? 2.0 / 3.0 * time_step : time_step);
  if (elements_.is_viscous()) {
    elements_.find_history(threads_);
    updated_ = false;
  }
  multigrid().begin_step();
  refined_ = false;
  if (!second_order_) rotations_.begin(threads_, positions_, velocities_, time_step);
  set_loads(gravity, external_forces);
  linearise();
  set_initial_guess(time_step, gravity);
  find_end();
}

Dynamics::Report Dynamics::solve(std::span<const Coupling> couplings, SolveGoal goal) {
  check_solve(goal);
  goal.least_scale = load_scale_;
  goal.least_residual = load_impulse_;
  goal.jacobi_iterations = jacobi_iterations_;
  couplings_.set(couplings, time_step_, free_);
  system_.update_preconditioner(threads_);
  compute_right_side();
  check_right_side();
  const Report report =
      solver_.solve(threads_, system_, right_side_, solution_, goal, &multigrid(), positions_);
  jacobi_iterations_ = report.jacobi_iterations;
  check_solution(report.relative_residual);
  find_end();
  return report;
}

void Dynamics::check_right_side() {
  const auto finite = [](const simd::Padded3& a) { return is_finite(unpadded(a)); };
  if (!all_finite(right_side_)) {
    const auto bad = std::ranges::find_if_not(right_side_, finite);
    throw error_at_point(static_cast<std::size_t>(bad - right_side_.begin()), "a force that is not finite",
                         "finite forces, positions and velocities");
  }
}

void Dynamics::check_solution(double residual) {
  if (std::isfinite(residual) && all_finite(solution_)) return;
  // The solver spreads an overflow to all points; it began where the force is largest.
  const auto largest = std::ranges::max_element(
      right_side_, {}, [](const simd::Padded3& a) { return largest_component(unpadded(a)); });
  throw error_at_point(static_cast<std::size_t>(largest - right_side_.begin()),
                       "a velocity that is not finite", "numbers within the range of double precision");
}

bool Dynamics::follow_rotations() {
  if (second_order_ || !rotations_.follow(threads_, positions_, mean_velocities_)) return false;
  linearise();
  return true;
}

/// Finds the positions at the end of the step from the solution.
void Dynamics::find_end() {
  holds_.stop(base_velocities_, solution_);
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    mean_velocities_[i] = unpadded(base_velocities_[i]) + unpadded(solution_[i]);
    end_positions_[i] = positions_[i];
    if (system_.free()[i] != 0) end_positions_[i] += time_step_ * mean_velocities_[i];
  });
  straight_bodies_ = held_bodies_;
  for (const Index p : prescribed_points_) at(straight_bodies_, at(body_of_point_, p)) = 1;
  bent_ = !second_order_ && rotations_.bend(threads_, positions_, mean_velocities_, straight_bodies_);
  if (bent_) {
    parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
      end_positions_[i] += rotations_.arc(body_of_point_[i], positions_[i]);
    });
  }
  for (std::size_t k = 0; k < prescribed_points_.size(); ++k) {
    at(end_positions_, prescribed_points_[k]) =
        prescribed_positions_[k];  // so that rounding errors do not add up
  }
  holds_.keep(positions_, end_positions_);
}

void Dynamics::end_step() {
  store_past();
  prescribed_points_.clear();
  std::swap(velocities_, mean_velocities_);
  if (bent_ || rotations_.any()) {
    parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
      if (system_.free()[i] == 0) return;
      const Index body = body_of_point_[i];
      const Vec3 straight = velocities_[i] - rotations_.excess_velocity(body, positions_[i]);
      velocities_[i] = rotations_.bent_velocity(body, positions_[i], straight);
    });
    holds_.stop(velocities_);
  }
  std::swap(positions_, end_positions_);
  updated_ = at_end_ && elements_.nonlinear_begin() == 0 && plastic_strains_next_.empty();
  std::ranges::transform(solution_, velocity_changes_.begin(), unpadded);
  elements_.relax(threads_, positions_);
  advance_inversion_clocks();
  elements_.flow(threads_, positions_, duration_, plastic_strains_next_);
  elements_.set_plastic_strains(plastic_strains_next_);
  second_order_ = false;
}

bool Dynamics::all_finite(std::span<const Vec3> values) {
  return parallel::sum(threads_, values.size(), partial_,
                       [&](std::size_t i) { return is_finite(values[i]) ? 0.0 : 1.0; }) == 0.0;
}

bool Dynamics::all_finite(std::span<const simd::Padded3> values) {
  return parallel::sum(threads_, values.size(), partial_,
                       [&](std::size_t i) { return is_finite(unpadded(values[i])) ? 0.0 : 1.0; }) == 0.0;
}

void Dynamics::check_points(std::span<const Vec3> values, const char* name) {
  check_length(name, values.size(), masses_.size(), "point");
  if (!all_finite(values)) throw Error(source_name, name, "a value that is not finite", "finite values");
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
      throw Error(source_name, name, "a value that is not finite", "finite values");
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
          .multigrid_reference = multigrid_.reference(),
          .multigrid_stale_iterations = multigrid_.stale_iterations(),
          .past_positions = past_positions_,
          .past_velocities = past_velocities_,
          .past_duration = past_duration_,
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
  set_inversion_clocks(state.inversion_clocks);  // the last call that can throw
  std::ranges::copy(state.positions, positions_.begin());
  // set_velocities() would drop those of prescribed points, which friction depends on.
  std::ranges::copy(state.velocities, velocities_.begin());
  std::ranges::copy(state.velocity_changes, velocity_changes_.begin());
  elements_.set_plastic_strains(state.plastic_strains);
  elements_.set_viscous_stresses(state.viscous_stresses);
  jacobi_iterations_ = state.jacobi_iterations;
  jacobi_iterations_of_contacts_ = state.jacobi_iterations_of_contacts;
  multigrid_.set_reference(state.multigrid_reference, state.multigrid_stale_iterations);
  second_order_multigrid_.set_reference(state.second_order_multigrid_reference,
                                        state.second_order_multigrid_stale_iterations);
  past_positions_ = state.past_positions;
  past_velocities_ = state.past_velocities;
  past_duration_ = state.past_duration;
  updated_ = false;
}

double Dynamics::kinetic_energy() {
  return parallel::sum(threads_, masses_.size(), partial_, [&](std::size_t i) {
    return system_.free()[i] != 0 ? 0.5 * masses_[i] * squared_length(velocities_[i]) : 0.0;
  });
}

double Dynamics::elastic_energy() {
  update_elements();
  const bool apart = elements_.smoothing().is_viscous();
  const auto energy_of = [&](std::size_t e) {
    const auto element = static_cast<Index>(e);
    if (apart && elements_.is_smoothed(element)) return 0.0;
    return elements_.viscosity().has(e) ? elements_.energy(element, positions_) : elements_.energy(element);
  };
  const double sum = parallel::sum(threads_, static_cast<std::size_t>(elements_.size()), partial_, energy_of);
  return apart ? sum + elements_.smoothed_energy(threads_, partial_) : sum;
}

std::int64_t Dynamics::inverted_elements() {
  update_elements();
  return static_cast<std::int64_t>(
      parallel::sum(threads_, static_cast<std::size_t>(elements_.size()), partial_,
                    [&](std::size_t e) { return elements_.inverted(static_cast<Index>(e)) ? 1.0 : 0.0; }));
}

}  // namespace palpate::fem
