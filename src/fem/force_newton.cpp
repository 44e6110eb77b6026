#include "fem/force_newton.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fem/elimination.hpp"
#include "room.hpp"

namespace palpate::fem {
namespace {

constexpr int most_from_given = 20;  // iterations
constexpr int most_from_zero = 30;
constexpr int most_sweeps = 20;

}  // namespace

Vec3 CondensedContacts::add_velocity(std::size_t contact, std::span<const double> y, Vec3 start) const {
  const double* row = &rows[3 * size * contact];
  for (std::size_t i = 0; i < size; ++i) start += y[i] * Vec3{row[i], row[size + i], row[2 * size + i]};
  return start;
}

void CondensedContacts::add_impulse(std::size_t contact, const Vec3& f, std::span<double> y) const {
  const double* row = &rows[3 * size * contact];
  const Vec3 impulse = friction.time_step * f;
  for (std::size_t i = 0; i < size; ++i) y[i] += dot(impulse, Vec3{row[i], row[size + i], row[2 * size + i]});
}

void CondensedContacts::find_y(std::span<const Vec3> forces, std::span<double> y) const {
  std::ranges::fill(y, 0.0);
  for (std::size_t k = 0; k < forces.size(); ++k) add_impulse(k, forces[k], y);
}

ForceNewton::Scaled::Projection ForceNewton::Scaled::project(const Vec3& f, const Vec3& v,
                                                             double friction) const {
  const double along_f = dot(f, normal);
  const double along_v = dot(v, normal);
  Projection p;
  p.normal = std::max(along_f - along * along_v, 0.0);
  p.pull = (f - along_f * normal) - across * (v - along_v * normal);
  const double size = length(p.pull);
  const double bound = friction * p.normal;
  p.limit = size > bound ? bound / size : 1.0;
  p.force = p.normal * normal + p.limit * p.pull;
  return p;
}

void ForceNewton::begin(const CondensedContacts& problem) {
  const std::size_t count = problem.laws.size();
  const std::size_t n = problem.size;
  const double h = problem.friction.time_step;
  assign_with_room(scaled_, count, Scaled{});
  for (Iterate* list : {&now_, &trial_, &step_}) {
    assign_with_room(list->forces, count, Vec3{});
    assign_with_room(list->v, count, Vec3{});
  }
  assign_with_room(stiffness_, count, Matrix3{});
  assign_with_room(shift_, count, Vec3{});
  resize_with_room(matrix_, n * n);
  assign_with_room(y_, n, 0.0);
  double squares = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    const ContactLaw& law = problem.laws[k];
    const double resistance = law.resistance(h);
    if (!(resistance > 0.0)) continue;
    const double* rows = &problem.rows[3 * n * k];
    double along = 0.0;
    double trace = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 column{rows[i], rows[n + i], rows[2 * n + i]};
      const double part = dot(law.direction, column);
      along += h * part * part;
      trace += h * squared_length(column);
    }
    Scaled& scaled = scaled_[k];
    scaled.normal = law.direction;
    scaled.compliance = 1.0 / resistance;
    scaled.along = 1.0 / (along + scaled.compliance);
    scaled.across = 1.0 / (0.5 * (trace - along) + scaled.compliance);
    scaled.start =
        problem.free[k] + (law.stiffness * scaled.compliance) * (law.slip - law.depth * law.direction);
    squares += squared_length(scaled.start);
  }
  size_of_v_ = std::sqrt(squares);
}

/// How far the forces are from their projections, as velocities.
double ForceNewton::error(const CondensedContacts& problem, const Iterate& at) const {
  double squares = 0.0;
  for (std::size_t k = 0; k < problem.laws.size(); ++k) {
    const Scaled& scaled = scaled_[k];
    if (scaled.compliance == 0.0) continue;
    const Vec3 off = at.forces[k] - scaled.project(at.forces[k], at.v[k], problem.friction.coefficient).force;
    squares += squared_length(off) / (scaled.along * scaled.along);
  }
  return std::sqrt(squares);
}

/// Linearises the equation of each contact: f = now + shift - stiffness (u - u now).
void ForceNewton::linearise(const CondensedContacts& problem) {
  for (std::size_t k = 0; k < problem.laws.size(); ++k) {
    const Scaled& scaled = scaled_[k];
    if (scaled.compliance == 0.0) continue;
    const auto projection = scaled.project(now_.forces[k], now_.v[k], problem.friction.coefficient);
    const Vec3& n = scaled.normal;
    Matrix3 of_normal;   // derivative of the projection by the normal part
    Matrix3 of_tangent;  // and by the tangential part
    if (projection.normal > 0.0) {
      add_outer(of_normal, 1.0, n, n);
      of_tangent = identity() - of_normal;
      if (projection.limit < 1.0) {
        const Vec3 t = normalized(projection.pull);
        add_outer(of_normal, problem.friction.coefficient, t, n);
        add_outer(of_tangent, -1.0, t, t);
        for (double& value : of_tangent.values) value *= projection.limit;
      }
    }
    Matrix3 by_velocity;
    Matrix3 by_force = identity();
    for (std::size_t i = 0; i < 9; ++i) {
      by_velocity.values[i] = scaled.along * of_normal.values[i] + scaled.across * of_tangent.values[i];
      by_force.values[i] +=
          scaled.compliance * by_velocity.values[i] - (of_normal.values[i] + of_tangent.values[i]);
    }
    const Matrix3 inverted = inverse(by_force);
    stiffness_[k] = times_transposed(inverted, transposed(by_velocity));
    shift_[k] = inverted * (projection.force - now_.forces[k]);
  }
}

/// The Newton step of the forces and of v; false if there is none.
bool ForceNewton::find_step(const CondensedContacts& problem) {
  const std::size_t n = problem.size;
  linearise(problem);
  std::ranges::fill(matrix_, 0.0);
  std::ranges::fill(y_, 0.0);
  for (std::size_t k = 0; k < problem.laws.size(); ++k) {
    if (scaled_[k].compliance == 0.0) continue;
    problem.add_impulse(k, shift_[k], y_);
    const double* rows = &problem.rows[3 * n * k];
    const Matrix3 by_column = transposed(stiffness_[k]);
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 left =
          problem.friction.time_step * (by_column * Vec3{rows[i], rows[n + i], rows[2 * n + i]});
      double* row = &matrix_[n * i];
      for (std::size_t j = 0; j < n; ++j)
        row[j] += left.x * rows[j] + left.y * rows[n + j] + left.z * rows[2 * n + j];
    }
  }
  for (std::size_t i = 0; i < n; ++i) matrix_[n * i + i] += 1.0;
  if (!solve_by_elimination(matrix_.data(), n, n, y_.data())) return false;
  for (std::size_t k = 0; k < problem.laws.size(); ++k) {
    if (scaled_[k].compliance == 0.0) continue;
    const Vec3 du = problem.add_velocity(k, y_, {});
    step_.forces[k] = shift_[k] - stiffness_[k] * du;
    step_.v[k] = du + scaled_[k].compliance * step_.forces[k];
  }
  return true;
}

/// Newton's method with a line search: the error must fall below the largest of the last few.
bool ForceNewton::iterate(const CondensedContacts& problem, int most, std::span<Vec3> forces) {
  constexpr int most_halvings = 12;
  constexpr double decrease = 1e-4;
  constexpr double rounding = 1e-14;
  constexpr double enough = 1e-9;
  const std::size_t count = problem.laws.size();
  std::ranges::copy(forces, now_.forces.begin());
  problem.find_y(forces, y_);
  for (std::size_t k = 0; k < count; ++k)
    now_.v[k] = problem.add_velocity(k, y_, scaled_[k].start + scaled_[k].compliance * now_.forces[k]);
  double found = error(problem, now_);
  std::array<double, 5> last{};
  last.fill(found);
  const double goal = rounding * std::max(found, size_of_v_);
  for (int i = 0; i < most && found > goal && find_step(problem); ++i) {
    const double largest = *std::ranges::max_element(last);
    double part = 1.0;
    double at_trial = 0.0;
    for (int half = 0; half < most_halvings; ++half, part *= 0.5) {
      for (std::size_t k = 0; k < count; ++k) {
        trial_.forces[k] = now_.forces[k] + part * step_.forces[k];
        trial_.v[k] = now_.v[k] + part * step_.v[k];
      }
      at_trial = error(problem, trial_);
      if (at_trial < (1.0 - decrease * part) * largest) break;
    }
    if (!(at_trial < (1.0 - decrease * part) * largest)) break;
    std::swap(now_, trial_);
    found = at_trial;
    last[static_cast<std::size_t>(i) % last.size()] = found;
  }
  std::ranges::copy(now_.forces, forces.begin());
  return found <= enough * size_of_v_;
}

/// Projected Gauss-Seidel.
void ForceNewton::sweep(const CondensedContacts& problem, std::span<Vec3> forces) {
  problem.find_y(forces, y_);
  for (int i = 0; i < most_sweeps; ++i) {
    for (std::size_t k = 0; k < forces.size(); ++k) {
      const Scaled& scaled = scaled_[k];
      if (scaled.compliance == 0.0) continue;
      const Vec3 v = problem.add_velocity(k, y_, scaled.start + scaled.compliance * forces[k]);
      const Vec3 force = scaled.project(forces[k], v, problem.friction.coefficient).force;
      problem.add_impulse(k, force - forces[k], y_);
      forces[k] = force;
    }
  }
}

bool ForceNewton::solve(const CondensedContacts& problem, std::span<Vec3> forces) {
  begin(problem);
  for (std::size_t k = 0; k < forces.size(); ++k) {
    if (scaled_[k].compliance == 0.0) forces[k] = {};
  }
  resize_with_room(given_, forces.size());
  std::ranges::copy(forces, given_.begin());
  if (iterate(problem, most_from_given, forces)) return true;
  std::ranges::fill(forces, Vec3{});
  if (iterate(problem, most_from_zero, forces)) return true;
  std::ranges::copy(given_, forces.begin());
  sweep(problem, forces);
  return iterate(problem, most_from_given, forces);
}

}  // namespace palpate::fem
