#include "fem/dynamics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "fem/body_title.hpp"
#include "fem/check_length.hpp"
#include "fem/grains.hpp"
#include "fem/lumping.hpp"
#include "fem/material_check.hpp"
#include "fem/padded_vectors.hpp"
#include "mesh/grouped.hpp"
#include "number_text.hpp"

namespace palpate::fem {
namespace {

constexpr const char* source_name = "dynamics";

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

/// Mean length of the edges of the tets, m; edges of several tets count several times. O(tets).
double mean_edge(std::span<const Tet> tets, std::span<const Vec3> positions) {
  double sum = 0.0;
  for (const Tet& tet : tets) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < i; ++j) sum += length(at(positions, tet[i]) - at(positions, tet[j]));
    }
  }
  return tets.empty() ? 0.0 : sum / (6.0 * static_cast<double>(tets.size()));
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
      rotations_(bodies, materials, masses_, obstacle_bodies),
      energy_limit_(bodies_.size()) {
  const std::size_t points = masses_.size();
  const auto elements = static_cast<std::size_t>(elements_.size());
  point_mass_damping_ = mass_dampings(bodies, materials, masses_);
  element_stiffness_damping_.resize(elements);
  for (std::size_t e = 0; e < elements; ++e) {
    element_stiffness_damping_[e] =
        materials.of(elements_.tet_of_element()[e], elements_.body_of_element()[e]).stiffness_damping;
    has_stiffness_damping_ = has_stiffness_damping_ || element_stiffness_damping_[e] > 0.0;
  }
  double mass = 0.0;
  for (std::size_t i = 0; i < points; ++i) mass += free_[i] != 0 ? masses_[i] : 0.0;
  edge_by_mass_ = mean_edge(elements_.corners(), positions_) * std::sqrt(mass);
  inversion_clocks_.resize(elements, 0.0);
  plastic_strains_next_.assign(elements_.plastic_strains().begin(), elements_.plastic_strains().end());
  end_positions_ = positions_;
  partial_.reserve(parallel::chunk_count(std::max(points, elements), parallel::sum_grain));
  diagonal_.resize(points);
  factors_.resize(elements);
  elastic_fractions_.resize(elements);
  nonlinear_points_.resize(points);
  nonlinear_stiffness_.resize(points);
  braked_bodies_.resize(bodies_.size());
  for (Index e = elements_.nonlinear_begin(); e < elements_.size(); ++e) {
    for (int i = 0; i < 4; ++i) {
      const Index corner = at(elements_.corners(), e)[static_cast<std::size_t>(i)];
      const Matrix3 block = elements_.stiffness_rest(e, i, i);
      at(nonlinear_points_, corner) = 1;
      at(nonlinear_stiffness_, corner) += block(0, 0) + block(1, 1) + block(2, 2);
    }
    at(braked_bodies_, at(elements_.body_of_element(), e)) = 1;
  }
  for (std::size_t d = 0; d < elements_.smoothing().size(); ++d)
    at(braked_bodies_, at(elements_.body_of_element(), elements_.smoothing().element(d))) = 1;
  for (auto* vector : {&velocities_, &velocity_changes_, &point_forces_, &mean_velocities_,
                       &linear_positions_, &loads_, &linear_forces_, &damping_changes_}) {
    vector->resize(points);
  }
  for (auto* vector : {&solution_, &right_side_, &free_right_side_, &base_velocities_, &rotation_velocities_,
                       &displacements_})
    vector->resize(points);
  const std::span<const Index> body_of_element = elements_.body_of_element();
  elements_of_body_ = grouped(body_of_element.size(), bodies_.size(),
                              [&](std::size_t e) { return std::array{body_of_element[e]}; });
  for (const std::uint8_t free : free_) held_axes_.push_back(free != 0 ? 0 : all_axes);
  mark_held_bodies();
}

void Dynamics::set_fixed_axes(const Bodies& bodies, const Materials& materials,
                              std::span<const std::uint8_t> axes) {
  holds_ = AxisHolds(bodies, materials, axes, free_, masses_);
  holds_.mark(held_axes_);
  mark_held_bodies();
  holds_.stop(velocities_);
}

/// Sets the mass part and the stiffness factors of the matrix (see linearise()).
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
  }
  elements_.set_factors(factors_, elastic_fractions_);
}

/// Sets the guess: dv of the last step, or, if that is zero, dv of free fall, which is then exact at any
/// tolerance. The solver uses zero instead of a guess that is worse than zero.
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
  begin_step(time_step, gravity, {.all = external_forces, .turning = {}, .ambient = {}});
  Report report = solve(couplings, {.tolerance = tolerance, .max_iterations = max_iterations});
  constexpr int max_rotation_solves = 8;
  for (int round = 0; update_rotating_frames(); ++round) {
    if (round == max_rotation_solves) {
      report.converged = false;
      break;
    }
    report = solve(couplings, {.tolerance = tolerance, .max_iterations = max_iterations});
  }
  constexpr int most_linearisations = 20;
  auto next = relinearise_tissue(tolerance);
  for (int n = 0; next; ++n) {
    if (n == most_linearisations) {
      end_where_linearised();
      report.converged = false;
      break;
    }
    report = solve(couplings, {.tolerance = *next, .max_iterations = max_iterations});
    next = relinearise_tissue(tolerance, *next);
  }
  end_step();
  return report;
}

void Dynamics::prescribe(std::span<const Index> points, std::span<const Vec3> positions) {
  prescribed_points_.assign(points.begin(), points.end());
  prescribed_positions_.assign(positions.begin(), positions.end());
}

void Dynamics::begin_step(double time_step, const Vec3& gravity, const ExternalForces& external_forces) {
  check_step(time_step, gravity);
  for (const auto& forces : {external_forces.all, external_forces.turning})
    if (!forces.empty()) check_length("external_forces", forces.size(), masses_.size(), "point");
  turning_forces_ = external_forces.turning;
  if (elements_.set_ambient(external_forces.ambient)) updated_ = false;
  duration_ = time_step;
  set_time_step(step_length(time_step));
  if (elements_.is_viscous()) {
    elements_.find_history(threads_);
    updated_ = false;
  }
  multigrid().begin_step();
  refined_ = false;
  updates_ = {};
  begin_rotations(time_step);
  begin_energies();
  set_loads(gravity, external_forces.all);
  linearise();
  set_initial_guess(time_step, gravity);
  find_end();
}

Dynamics::Report Dynamics::solve(std::span<const Coupling> couplings, SolveGoal goal) {
  check_solve(goal);
  goal.least_scale = least_scale(goal.tolerance);
  goal.least_residual = load_impulse_;
  goal.jacobi_iterations = jacobi_iterations_;
  couplings_.set(threads_, couplings, time_step_, free_);
  system_.update_preconditioner(threads_);
  compute_right_side();
  check_right_side();
  const Report report =
      solver_.solve(threads_, system_, right_side_, solution_, goal, &multigrid(), linear_positions());
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
  // The solver spreads an overflow to all points. Report the point with the largest force, where it began.
  const auto largest = std::ranges::max_element(
      right_side_, {}, [](const simd::Padded3& a) { return largest_component(unpadded(a)); });
  throw error_at_point(static_cast<std::size_t>(largest - right_side_.begin()),
                       "a velocity that is not finite", "numbers within the range of double precision");
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
  has_arcs_ = !second_order_ && rotations_.set_arcs(threads_, positions_, mean_velocities_, straight_bodies_);
  if (has_arcs_) {
    parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
      end_positions_[i] += rotations_.arc_displacement(body_of_point_[i], positions_[i]);
    });
  }
  for (std::size_t k = 0; k < prescribed_points_.size(); ++k) {
    at(end_positions_, prescribed_points_[k]) =
        prescribed_positions_[k];  // set exactly, so that rounding errors do not accumulate
  }
  holds_.keep(positions_, end_positions_);
}

void Dynamics::end_step(const Joints& joints) {
  store_past();
  if (rotations_.any()) find_lost_impulses(joints);
  find_frame_reactions();
  prescribed_points_.clear();
  std::swap(velocities_, mean_velocities_);
  if (has_arcs_ || rotations_.any()) {
    parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
      if (system_.free()[i] == 0) return;
      const Index body = body_of_point_[i];
      const Vec3 straight = velocities_[i] - rotations_.excess_velocity(body, positions_[i]);
      velocities_[i] = rotations_.arc_velocity(body, positions_[i], straight);
    });
    if (rotations_.any()) add_lost_impulses();
    holds_.stop(velocities_);
  }
  std::swap(positions_, end_positions_);
  updated_ = at_end_ && elements_.nonlinear_begin() == 0 && plastic_strains_next_.empty();
  std::ranges::transform(solution_, velocity_changes_.begin(), unpadded);
  elements_.relax(threads_, positions_);
  advance_inversion_clocks();
  elements_.flow(threads_, positions_, duration_, plastic_strains_next_);
  elements_.set_plastic_strains(plastic_strains_next_);
  if (!second_order_) limit_energies(joints);
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

}  // namespace palpate::fem
