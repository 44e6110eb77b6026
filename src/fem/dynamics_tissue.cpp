// Newton's method over hyperelastic tissue within a step.
#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/dynamics.hpp"
#include "fem/grains.hpp"
#include "fem/padded_vectors.hpp"

namespace palpate::fem {
namespace {

/// Smallest accepted decrease of the energy by an update, as a fraction of the decrease that the linear
/// system predicts.
constexpr double least_decrease = 1e-4;
constexpr int most_halvings = 10;
/// An update is extrapolated if it is more than this part of the one before, and if the square of the cosine
/// between them exceeds `least_cosine`.
constexpr double least_ratio = 0.2;
constexpr double least_cosine = 0.8;
constexpr double most_ratio = 0.9;
/// Ratios of updates that tell how many more are needed.
constexpr double fast = 0.6;
constexpr double fastest = 0.05;
/// Largest bound of the error for which ratios count, relative to the tolerance.
constexpr double farthest = 30.0;
/// Tolerance of a solve, relative to the expected size of its update.
constexpr double forcing = 0.1;
/// Relative rounding error of sums of energies.
constexpr double rounding = 1e-12;

}  // namespace

/// Positions at which tissue is linearised.
std::span<const Vec3> Dynamics::linear_positions() const {
  return rotations_.any() || refined_ ? linear_positions_ : positions_;
}

/// Sets the positions at which tissue is linearised. In rotated frames these are the rotated positions. In
/// steps of second order they are the positions without force, because the corotational tangent is not the
/// true derivative and would leave an error of first order at the start of the step. Hyperelastic bodies stay
/// where relinearise_tissue() has put them.
void Dynamics::place_linear_positions() {
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    if (refined_ && is_nonlinear(i)) return;
    linear_positions_[i] =
        positions_[i] + (second_order_ ? time_step_ * unpadded(base_velocities_[i])
                                       : rotations_.displacement(body_of_point_[i], positions_[i]));
  });
}

/// Adds the forces that arise because tissue is not linearised at the start of the step: the elastic part of
/// the matrix acts on displacements from the linearisation positions, the damping part on displacements from
/// the rotated bodies. Also adds the inertial forces of rotated frames.
void Dynamics::add_displacement_forces() {
  const double rate = 1.0 / time_step_;
  const auto add = [&](std::span<const simd::Padded3> products) {
    parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
      if (free_[i] != 0) point_forces_[i] += rate * unpadded(products[i]);
    });
  };
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    displacements_[i] = padded(rate * (linear_positions_[i] - positions_[i]));
  });
  add(elements_.multiply(threads_, displacements_, StiffnessPart::elastic));
  if (!rotations_.any()) return;
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    displacements_[i] = padded(rate * rotations_.displacement(body_of_point_[i], positions_[i]));
  });
  add(elements_.multiply(threads_, displacements_, StiffnessPart::damping));
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    if (free_[i] != 0) point_forces_[i] += frame_force(i);
  });
}

/// Elastic energy of bodies with hyperelastic tets, at the last update of the elements, J.
double Dynamics::nonlinear_energy() {
  const auto first = static_cast<std::size_t>(elements_.nonlinear_begin());
  return parallel::sum(threads_, static_cast<std::size_t>(elements_.size()) - first, partial_,
                       [&](std::size_t k) { return elements_.energy(static_cast<Index>(first + k)); });
}

/// Whether a hyperelastic body has an inverted tet at the last update of the elements. Then its energy has
/// many minima, and less exact solves find worse ones.
bool Dynamics::inverts_tissue() {
  const auto first = static_cast<std::size_t>(elements_.nonlinear_begin());
  return parallel::sum(threads_, static_cast<std::size_t>(elements_.size()) - first, partial_,
                       [&](std::size_t k) {
                         return elements_.inverted(static_cast<Index>(first + k)) ? 1.0 : 0.0;
                       }) > 0.0;
}

double Dynamics::product_by_mass(std::span<const simd::Padded3> a, std::span<const simd::Padded3> b) {
  return parallel::sum(threads_, masses_.size(), partial_, [&](std::size_t i) {
    return free_[i] == 0 ? 0.0 : diagonal_[i] * dot(unpadded(a[i]), unpadded(b[i]));
  });
}

/// What errors of the solution are relative to, by mass.
double Dynamics::tissue_scale() {
  return std::max(std::sqrt(product_by_mass(solution_, solution_)), load_scale_);
}

/// Bound of the relative error of the solution, by mass, if linear_forces_ are not the elastic forces at the
/// end: |h r| weighted by 1 / m, since the matrix minus diag(m) is positive semi-definite.
double Dynamics::tissue_error() {
  const auto elastic = elements_.point_forces();
  const double error = parallel::sum(threads_, masses_.size(), partial_, [&](std::size_t i) {
    if (free_[i] == 0 || !is_nonlinear(i)) return 0.0;
    return squared_length(time_step_ * (unpadded(elastic[i]) - linear_forces_[i])) / diagonal_[i];
  });
  const double beyond = std::sqrt(error) - rounding_ - tissue_rounding_;
  return beyond > 0.0 ? beyond / tissue_scale() : 0.0;  // at rest without loads the scale is zero, too
}

void Dynamics::TissueUpdates::add(double square_now, double size_now) {
  ++count;
  if (count > 2) {
    ratio_before = count == 3 ? 0.0 : ratio;
    ratio = size_now / size;
  }
  square = square_now;
  size = size_now;
}

double Dynamics::TissueUpdates::slowest() const {
  return std::max({ratio, ratio_before, fastest});
}

/// Twice the sum of all further updates if each is `slowest()` times the one before. In stiff tissue,
/// tissue_error() is far above it.
double Dynamics::TissueUpdates::error() const {
  const double q = slowest();
  if (count < 3 || !(q < fast)) return std::numeric_limits<double>::infinity();
  return 2.0 * size * q / (1.0 - q);
}

/// A fraction of the size that the next update is expected to have.
double Dynamics::TissueUpdates::next_tolerance() const {
  constexpr double second = 0.03;  // typical ratios
  constexpr double third = 0.3;
  const double q = count == 1 ? second : count == 2 ? third : std::min(slowest(), 1.0);
  return forcing * q * size;
}

std::optional<double> Dynamics::relinearise_tissue(double tolerance, double solved_to) {
  if (elements_.nonlinear_begin() == elements_.size()) return std::nullopt;
  at_end_ = false;
  const std::span<const Vec3> linearised = linear_positions();
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    displacements_[i] = is_nonlinear(i) ? padded(end_positions_[i] - linearised[i]) : simd::Padded3{};
  });
  // h^2 K' times it
  const auto stiff = elements_.multiply(threads_, displacements_, StiffnessPart::elastic);
  const auto elastic = elements_.point_forces();
  const double rate = 1.0 / (time_step_ * time_step_);
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    linear_forces_[i] = unpadded(elastic[i]) - rate * unpadded(stiff[i]);
  });
  const auto sum = [&](auto&& term) { return parallel::sum(threads_, masses_.size(), partial_, term); };
  const double work =
      sum([&](std::size_t i) { return dot(unpadded(elastic[i]), unpadded(displacements_[i])); });
  const double stiff_work =
      sum([&](std::size_t i) { return rate * dot(unpadded(stiff[i]), unpadded(displacements_[i])); });
  const double square = product_by_mass(displacements_, displacements_);
  const LinearTissue linear{nonlinear_energy(), work, stiff_work, 0.5 * (rate * square + stiff_work)};
  place_linear_positions();
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    if (is_nonlinear(i)) linear_positions_[i] = end_positions_[i];
  });
  refined_ = true;
  updated_ = false;
  elements_.update(threads_, linear_positions_);
  double ratio = 0.0;  // of this update to the last one, if they are nearly parallel
  if (updates_.plain > 0) {
    const double product = product_by_mass(displacements_, last_update_);
    if (product > 0.0 && product * product > least_cosine * square * updates_.square)
      ratio = std::min(product / updates_.square, most_ratio);
  }
  updates_.add(square, square > 0.0 ? std::sqrt(rate * square) / tissue_scale() : 0.0);
  const double bound = tissue_error();
  const bool close = bound <= tolerance || (bound <= farthest * tolerance && updates_.error() <= tolerance);
  if (close && solved_to <= tolerance) {
    at_end_ = true;
    return std::nullopt;
  }
  last_update_ = displacements_;
  ++updates_.plain;
  if (!extrapolate(linear, ratio)) backtrack(linear);
  reuses_directions_ = false;
  form_system();
  if (inverts_tissue()) return tolerance;
  constexpr double most = 0.01;  // while the tissue is far from its linearisation
  return std::max(tolerance, std::min(updates_.next_tolerance(), most * std::min(updates_.size, 1.0)));
}

/// Places the linearisation beyond the end of the update if Newton's method converges slowly. Its matrix
/// lacks the negative eigenvalues of compressed tissue, so it may be several times too stiff, and then each
/// update is about the same part q (`ratio`) of the one before. All of them together would be 1 / (1 - q)
/// times this one (Aitken). This is used if the total energy is lower there than at the end of the update, as
/// far as the rest of the problem is quadratic. The convergence of a step does not depend on it: what is
/// linearised here is solved next. Between two extrapolations there is an update without.
bool Dynamics::extrapolate(const LinearTissue& tissue, double ratio) {
  if (!(ratio > least_ratio)) return false;
  updates_.plain = 0;
  const double beyond = ratio / (1.0 - ratio);
  const auto place = [&](double more) {
    parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
      if (is_nonlinear(i)) linear_positions_[i] = end_positions_[i] + more * unpadded(displacements_[i]);
    });
    elements_.update(threads_, linear_positions_);
  };
  const auto total = [&](double fraction) {
    const double excess = nonlinear_energy() - tissue.energy_at(fraction);
    return excess - tissue.predicted_decrease * fraction * (2.0 - fraction);
  };
  const double at_end = total(1.0);
  place(beyond);
  if (at_end < 0.0 && total(1.0 + beyond) < at_end) return true;
  place(0.0);
  return false;
}

/// Backtracking line search: halves the update until the total energy certainly decreases. The rest of the
/// problem (inertia, couplings, contacts) is convex. With linear tissue the solution is the minimum of the
/// energy, at least `predicted_decrease` below the start. So after a fraction s of the update the total has
/// decreased if the tissue's energy exceeds that of linear tissue by less than s `predicted_decrease`.
void Dynamics::backtrack(const LinearTissue& tissue) {
  double fraction = 1.0;
  for (int halvings = 0; halvings < most_halvings; ++halvings) {
    const double now = nonlinear_energy();
    const double slack = rounding * (std::abs(tissue.energy) + std::abs(now));
    const double excess = now - tissue.energy_at(fraction);
    if (excess <= (1.0 - least_decrease) * fraction * tissue.predicted_decrease + slack) return;
    fraction *= 0.5;
    parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
      if (is_nonlinear(i))
        linear_positions_[i] = end_positions_[i] - (1.0 - fraction) * unpadded(displacements_[i]);
    });
    elements_.update(threads_, linear_positions_);
  }
}

void Dynamics::end_where_linearised() {
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    if (free_[i] == 0 || !is_nonlinear(i)) return;
    end_positions_[i] = linear_positions_[i];
    mean_velocities_[i] = (1.0 / time_step_) * (linear_positions_[i] - positions_[i]);
    solution_[i] = padded(mean_velocities_[i] - unpadded(base_velocities_[i]));
  });
}

void Dynamics::set_activations(std::span<const double> activations) {
  if (elements_.set_activations(activations)) updated_ = false;
}

}  // namespace palpate::fem
