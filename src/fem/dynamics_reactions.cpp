#include <algorithm>
#include <array>

#include "fem/dynamics.hpp"
#include "fem/grains.hpp"
#include "fem/padded_vectors.hpp"

// Forces that hold the points that are not free, or not free along all axes.
namespace palpate::fem {

void Dynamics::find_constrained_elements() {
  lists_constrained_ = true;
  constrained_elements_.clear();
  held_domains_.clear();
  const auto held = [&](std::span<const Index> points) {
    return std::ranges::any_of(points, [&](Index p) { return at(held_axes_, p) != 0; });
  };
  for (Index e = 0; e < elements_.size(); ++e) {
    if (held(at(elements_.corners(), e))) constrained_elements_.push_back(e);
  }
  for (std::size_t d = 0; d < elements_.smoothing().size(); ++d) {
    if (held(elements_.smoothing().points(d))) held_domains_.push_back(d);
  }
}

void Dynamics::holding_forces(const Vec3& gravity, std::span<const Vec3> external_forces,
                              std::span<Vec3> forces) const {
  const auto elastic = elements_.point_forces();
  for (std::size_t i = 0; i < masses_.size(); ++i) {
    forces[i] = {};
    if (held_axes_[i] == 0) continue;
    const Vec3 acceleration = (1.0 / time_step_) * (mean_velocities_[i] - velocities_[i]);
    forces[i] = masses_[i] * (acceleration - gravity) - unpadded(elastic[i]);
    if (!external_forces.empty()) forces[i] -= external_forces[i];
  }
  add_damping_forces(forces);
  add_stiff_forces(forces);
  for (std::size_t i = 0; i < masses_.size(); ++i) forces[i] = along(held_axes_[i], forces[i]);
}

/// Adds mass damping, at points of deformable bodies.
void Dynamics::add_damping_forces(std::span<Vec3> forces) const {
  for (std::size_t i = 0; i < masses_.size(); ++i) {
    if (held_axes_[i] != 0 && at(rigid_, body_of_point_[i]) == 0)
      forces[i] += (masses_[i] * point_mass_damping_[i]) * mean_velocities_[i];
  }
}

/// The velocity that h (b + h) K' is multiplied by. Its elastic part acts on the displacement from the
/// linearisation positions, its damping part on the motion beyond the rotation of the frame.
/// \param elastic  fraction of the factor
Vec3 Dynamics::stiff_velocity(Index point, double elastic) const {
  const auto p = static_cast<std::size_t>(point);
  Vec3 velocity = mean_velocities_[p];
  if (rotations_.any() || refined_)
    velocity -= (elastic / time_step_) * (linear_positions_[p] - positions_[p]);
  velocity -=
      ((1.0 - elastic) / time_step_) * rotations_.rigid_displacement(body_of_point_[p], positions_[p]);
  return velocity;
}

void Dynamics::add_stiff_forces(std::span<Vec3> forces) const {
  const auto add = [&](Index point, const Vec3& stiff) {
    if (at(held_axes_, point) != 0) at(forces, point) += (1.0 / time_step_) * stiff;
  };
  for (const Index e : constrained_elements_) {
    const Tet& corners = at(elements_.corners(), e);
    const auto velocities = [&](double elastic) {
      std::array<Vec3, 4> found;
      for (std::size_t k = 0; k < 4; ++k) found[k] = stiff_velocity(corners[k], elastic);
      return found;
    };
    const bool is_held = elements_.is_held(e);
    const std::array<Vec3, 4> of_elastic = velocities(is_held ? 1.0 : elements_.elastic_fraction(e));
    const std::array<Vec3, 4> stiff = elements_.multiply(e, of_elastic);
    for (std::size_t k = 0; k < 4; ++k) add(corners[k], stiff[k]);
    if (!is_held) continue;
    std::array<Vec3, 4> of_damping = velocities(0.0);
    for (std::size_t k = 0; k < 4; ++k) of_damping[k] -= of_elastic[k];
    const std::array<Vec3, 4> damping = elements_.multiply_held(e, of_damping);
    for (std::size_t k = 0; k < 4; ++k) add(corners[k], damping[k]);
  }
  const SmoothingDomains& smoothing = elements_.smoothing();
  for (const std::size_t d : held_domains_) {
    const auto points = smoothing.points(d);
    const auto add_part = [&](StiffnessPart part, double elastic) {
      smoothing.multiply(
          d, part, [&](std::size_t k) { return stiff_velocity(points[k], elastic); },
          [&](std::size_t k, const Vec3& stiff) { add(points[k], stiff); });
    };
    if (smoothing.is_held(d)) {
      add_part(StiffnessPart::elastic, 1.0);
      add_part(StiffnessPart::damping, 0.0);
    } else {
      add_part(StiffnessPart::whole, elements_.elastic_fraction(smoothing.element(d)));
    }
  }
}

/// Adds what a force lacks that acts between bodies. Their momentum is kept if it acts on both at one place,
/// as seen from their centres at the start of the step.
/// \param lasts  it acted at the start of the step, too (a tie). A contact may begin within the step: without
///     a frame of the other body, its arm in the frame is right
void Dynamics::add_joint_impulse(const Coupling& joint, const Vec3& force, bool lasts) {
  const Index own = at(body_of_point_, joint.points[0]);
  std::array<Vec3, 2> places;
  std::array<double, 2> weights{};
  std::array<Index, 2> sides{own, own};
  for (std::size_t i = 0; i < joint.points.size(); ++i) {
    const Index p = joint.points[i];
    if (p < 0) continue;
    const Index body = at(body_of_point_, p);
    const std::size_t side = body == own ? 0 : 1;
    sides[side] = body;
    const Vec3& x = at(positions_, p);
    places[side] += joint.coefficients[i] * (x + rotations_.displacement(body, x));
    weights[side] += joint.coefficients[i];
  }
  if (sides[0] == sides[1]) return;
  const bool both = rotations_.has_frame(sides[0]) && rotations_.has_frame(sides[1]);
  if (!both && !lasts) return;
  // Without a frame, the other body has the arm of the start.
  const std::size_t fixed = rotations_.has_frame(sides[0]) ? 1 : 0;
  const Vec3 place = both ? 0.5 * ((1.0 / weights[0]) * places[0] + (1.0 / weights[1]) * places[1])
                          : (1.0 / weights[fixed]) * places[fixed];
  for (std::size_t i = 0; i < joint.points.size(); ++i) {
    const Index p = joint.points[i];
    if (p < 0 || at(system_.free(), p) == 0) continue;
    const Index body = at(body_of_point_, p);
    at(lasts ? lost_impulses_ : contact_impulses_, body) +=
        rotations_.lost_impulse(body, at(positions_, p), place, joint.coefficients[i] * force);
  }
}

void Dynamics::find_lost_impulses(const Joints& joints) {
  lost_impulses_.assign(bodies_.size(), Vec3{});
  contact_impulses_.assign(bodies_.size(), Vec3{});
  for (std::size_t k = 0; k < joints.couplings.size(); ++k)
    add_joint_impulse(joints.couplings[k], joints.forces[k], k < joints.lasting);
}

/// The angular momentum that a body in a rotated frame lacks because forces of the step deform it, N m s.
Vec3 Dynamics::impulse_by_deformation(Index body) const {
  Vec3 impulse;
  if (!rotations_.has_frame(body)) return impulse;
  const Range points = at(bodies_, body).points;
  for (Index i = points.begin; i < points.end; ++i) {
    impulse += at(masses_, i) *
               rotations_.lost_momentum(body, at(positions_, i), time_step_ * unpadded(at(solution_, i)));
  }
  return rotations_.bounded_impulse(body, impulse);
}

void Dynamics::add_lost_impulses() {
  for (Index body = 0; body < static_cast<Index>(bodies_.size()); ++body) {
    Vec3& impulse = at(lost_impulses_, body);
    const Vec3& of_contacts = at(contact_impulses_, body);
    if (impulse != Vec3{} || of_contacts != Vec3{})
      impulse = rotations_.allowed_impulse(body, impulse, of_contacts, positions_, velocities_);
    if (at(turning_bodies_, body) != 0) impulse += impulse_by_deformation(body);
  }
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    const Vec3& impulse = at(lost_impulses_, body_of_point_[i]);
    if (impulse == Vec3{}) return;
    const Vec3 velocity = rotations_.velocity_by(body_of_point_[i], positions_[i], impulse);
    if (system_.free()[i] != 0) {
      velocities_[i] += velocity;
    } else if (!frame_reactions_.empty()) {
      frame_reactions_[i] -= (masses_[i] / time_step_) * velocity;
    }
  });
}

/// Frames turn the velocities of free points without forces. What the whole body has as inertial forces adds
/// up to zero, so the held points have the rest.
void Dynamics::find_frame_reactions() {
  frame_reactions_.clear();
  if (!lists_constrained_ || !rotations_.any()) return;
  frame_reactions_.resize(masses_.size());
  for (std::size_t i = 0; i < masses_.size(); ++i) {
    const Index body = body_of_point_[i];
    if (held_axes_[i] == 0 || !rotations_.has_frame(body)) continue;
    const Vec3& x = positions_[i];
    const Vec3 turned =
        rotations_.free_velocity(body, x, velocities_[i]) - rotations_.excess_velocity(body, x);
    frame_reactions_[i] = -masses_[i] * ((1.0 / time_step_) * (turned - velocities_[i]) +
                                         rotations_.inertial_acceleration(body, x));
  }
}

}  // namespace palpate::fem
