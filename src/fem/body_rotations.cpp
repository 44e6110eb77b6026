#include "fem/body_rotations.hpp"

#include <algorithm>
#include <numbers>

#include "fem/lumping.hpp"
#include "fem/rotation.hpp"
#include "geometry/trigonometry.hpp"

namespace palpate::fem {
namespace {

/// Largest angle by which points move along arcs, rad. Contacts then have an error of 0.3 % of the body's
/// size.
constexpr double largest_arc_angle = 0.08;
/// Above this angular velocity times the time step, the angle of a solution has another sign or lacks whole
/// turns.
constexpr double largest_known_angle = std::numbers::pi;
/// A free body has a frame if it rotates by more than this in a step, rad.
constexpr double least_angle = 1e-3;
/// And if the energy of its motion is at most this part of that of a strain of 1. Implicit Euler without
/// frames brings bodies back that their spin tears inside out.
constexpr double most_of_stretch = 0.05;

/// All of the Coriolis force up to half a radian, none from one on.
double coriolis_fraction(double angle) {
  return std::clamp(2.0 * (1.0 - angle), 0.0, 1.0);
}

/// The rotation vector of a rotation, its angle in [0, pi], rad.
Vec3 rotation_vector(const Matrix3& q) {
  // Axis times twice the sine of the angle; accurate for small angles.
  const Vec3 twice{q(2, 1) - q(1, 2), q(0, 2) - q(2, 0), q(1, 0) - q(0, 1)};
  const double sine = 0.5 * length(twice);
  const double cosine = 0.5 * (q(0, 0) + q(1, 1) + q(2, 2) - 1.0);
  return sine > 0.0 ? (arc_tangent(sine, cosine) / (2.0 * sine)) * twice : Vec3{};
}

/// Step length of a fixed-point iteration from its last two residuals. It only damps oscillations: where the
/// residual does not decrease along itself, they say nothing about the next step.
/// \param last  step length after `before`
double next_step_length(const Vec3& before, const Vec3& now, double last) {
  constexpr double shortest = 0.1;
  const Vec3 change = now - before;
  const double decrease = -dot(before, change);
  if (decrease <= 0.0) return 1.0;
  return std::clamp(last * decrease / squared_length(change), shortest, 1.0);
}

}  // namespace

BodyRotations::BodyRotations(const Bodies& bodies, const Materials& materials, std::span<const double> masses,
                             std::span<const std::uint8_t> obstacles)
    : bodies_(bodies.bodies().begin(), bodies.bodies().end()),
      masses_(masses.begin(), masses.end()),
      stretch_energies_(bodies_.size(), 0.0),
      frames_(bodies_.size()),
      arcs_(bodies_.size()),
      starts_(bodies_.size()),
      changed_(bodies_.size(), 0),
      changes_(bodies_.size()) {
  for (Index body = 0; body < bodies.body_count(); ++body) {
    if (at(obstacles, body) != 0) continue;
    const Range tets = at(bodies_, body).tets;
    for (Index tet = tets.begin; tet < tets.end; ++tet) {
      at(stretch_energies_, body) += materials.of(tet, body).young_modulus * tet_volume_rest(bodies, tet);
    }
  }
}

/// Rotation vector of the rigid rotation that fits the motion of a body in the step best. Zero if the
/// rotation is less than half of the motion about the centre.
/// \param mean  rigid motion of these velocities
Vec3 BodyRotations::angle_of(std::size_t body, const RigidMotion& mean, std::span<const Vec3> positions,
                             std::span<const Vec3> velocities) const {
  const Range points = bodies_[body].points;
  const auto for_each_arm = [&](const auto& use) {
    for (Index i = points.begin; i < points.end; ++i) {
      const Vec3 arm = at(positions, i) - mean.center;
      use(at(masses_, i), arm, arm + time_step_ * (at(velocities, i) - mean.velocity));
    }
  };
  Matrix3 moment;
  for_each_arm([&](double m, const Vec3& arm, const Vec3& end) { add_outer(moment, m, end, arm); });
  const Matrix3 q = nearest_rotation(moment);
  double moved = 0.0;
  double beside = 0.0;
  for_each_arm([&](double m, const Vec3& arm, const Vec3& end) {
    moved += m * squared_length(end - arm);
    beside += m * squared_length(end - q * arm);
  });
  return beside < 0.5 * moved ? rotation_vector(q) : Vec3{};
}

/// Whether a rotation by `angle` beyond that of the frame would expand a body enough to store a significant
/// part of this energy.
bool BodyRotations::swells(std::size_t body, const Vec3& angle, double energy) const {
  const double swelling = 1.0 - cosine(length(angle));
  constexpr double allowed = 5e-4;
  return stretch_energies_[body] * swelling * swelling > allowed * energy;
}

/// The angle by which a body rotates freely in the step if that is more than half a turn, otherwise 0, rad.
/// Rotation vectors do not count whole turns.
double BodyRotations::whole_revolutions(std::size_t body) const {
  const RigidMotion& start = starts_[body];
  const double angle = start.dominates() ? time_step_ * length(start.angular_velocity()) : 0.0;
  return angle > largest_known_angle ? angle : 0.0;
}

/// \param momentum  angular momentum at the end of the step
void BodyRotations::set_frame(std::size_t body, const Vec3& angle, const Vec3& momentum) {
  const RigidMotion& start = starts_[body];
  const Quaternion rotation = rotation_by(angle);
  const auto rotated_by = [&](const Vec3& of_momentum) {
    return multiply_rotated(rotation, start.inverse_inertia, of_momentum);
  };
  const Vec3 angular_velocity = rotated_by(momentum);
  const double coriolis = coriolis_fraction(std::max(length(angle), whole_revolutions(body)));
  // The angular momentum of a step without forces: that of the rigid motion, and of the deformation.
  Vec3 at_end = rotated(rotation, start.momentum);
  constexpr std::array<Vec3, 3> axes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 deformation = coriolis * start.deformation[k];
    at_end += cross(rotated(rotation, axes[k]), deformation) +
              time_step_ * cross(deformation, rotated(rotation, cross(start.angular_velocity(), axes[k])));
  }
  frames_[body] = {.center = start.center,
                   .velocity = start.velocity,
                   .angle = angle,
                   .rotation = rotation,
                   .angular_velocity = angular_velocity,
                   .angular_acceleration = rotated_by(cross(momentum, angular_velocity)),
                   .correction = rotated_by(start.momentum - at_end),
                   .coriolis = coriolis};
}

void BodyRotations::begin(const parallel::Threads& threads, std::span<const Vec3> positions,
                          std::span<const Vec3> velocities, double time_step,
                          std::span<const std::uint8_t> free) {
  time_step_ = time_step;
  parallel::for_each(threads, bodies_.size(), 1, [&](std::size_t body) {
    frames_[body] = {};
    if (stretch_energies_[body] == 0.0) return;
    starts_[body] = motion_of(body, positions, velocities);
    if (!starts_[body].dominates()) return;
    const Vec3 angle = free_angle(starts_[body], time_step);
    const RigidMotion& start = starts_[body];
    const bool is_stiff = start.energy <= most_of_stretch * stretch_energies_[body] && start.is_rigid();
    const bool rotates = !free.empty() && (free[body] == 2 || (free[body] == 1 && is_stiff));
    const bool rotates_freely = rotates && length(angle) > least_angle;
    if (rotates_freely || swells(body, angle, starts_[body].energy))
      set_frame(body, angle, starts_[body].momentum);
  });
}

bool BodyRotations::follow(const parallel::Threads& threads, std::span<const Vec3> positions,
                           std::span<const Vec3> velocities) {
  parallel::for_each(threads, bodies_.size(), 1, [&](std::size_t body) {
    changed_[body] = 0;
    if (stretch_energies_[body] == 0.0) return;
    if (time_step_ * length(starts_[body].angular_velocity()) > largest_known_angle) return;
    const RigidMotion mean = motion_of(body, positions, velocities);
    const Frame& last = frames_[body];
    const Vec3 left = angle_of(body, mean, positions, velocities) - last.angle;
    if (length(left) <= largest_arc_angle || !swells(body, left, mean.energy)) return;
    const double step_length =
        last.left == Vec3{} ? 1.0 : next_step_length(last.left, left, last.step_length);
    const Vec3 angle = last.angle + step_length * left;
    // Angular momentum at mid-step: h times omega there is the angle.
    const Quaternion half = rotation_by(0.5 * angle);
    const Vec3 momentum = (1.0 / time_step_) * multiply_rotated(half, starts_[body].inertia, angle);
    const Quaternion before = last.rotation;
    set_frame(body, angle, momentum);
    const Quaternion change = product(frames_[body].rotation, {before.scalar, -before.vector});
    changes_[body] = {
        .rotation = change, .angle = rotation_vector(change), .before = before, .velocity = mean.velocity};
    frames_[body].left = left;
    frames_[body].step_length = step_length;
    changed_[body] = 1;
  });
  return std::ranges::find(changed_, 1) != changed_.end();
}

Vec3 BodyRotations::rotated_velocity(Index body, const Vec3& position, const Vec3& velocity) const {
  const FrameChange& change = at(changes_, body);
  const Vec3 arm = position - at(starts_, body).center;
  const Vec3 now = rotated(change.before, arm);
  // The displacement from the rotated body is the deformation and, along straight paths, the rotation.
  const Vec3 displacement = time_step_ * (velocity - change.velocity) - (now - arm);
  const Vec3 deformation = displacement - cross(change.angle, now);
  const Vec3 end = rotated(change.rotation, now + deformation);
  return change.velocity + (1.0 / time_step_) * (end - arm);
}

bool BodyRotations::any() const {
  return std::ranges::any_of(frames_, [](const Frame& frame) { return frame.angle != Vec3{}; });
}

double BodyRotations::largest_angle() const {
  double largest = 0.0;
  for (std::size_t body = 0; body < frames_.size(); ++body) {
    if (stretch_energies_[body] > 0.0)
      largest = std::max({largest, length(frames_[body].angle), whole_revolutions(body)});
  }
  return largest;
}

Vec3 BodyRotations::displacement(Index body, const Vec3& position) const {
  const Frame& frame = at(frames_, body);
  if (frame.angle == Vec3{}) return {};
  const Vec3 arm = position - frame.center;
  return rotated(frame.rotation, arm) - arm;
}

Vec3 BodyRotations::excess_velocity(Index body, const Vec3& position) const {
  const Frame& frame = at(frames_, body);
  if (frame.angle == Vec3{}) return {};
  const Vec3 arm_end = rotated(frame.rotation, position - frame.center);
  return (1.0 / time_step_) * displacement(body, position) - cross(frame.angular_velocity, arm_end);
}

Vec3 BodyRotations::turned_vector(Index body, const Vec3& a) const {
  const Frame& frame = at(frames_, body);
  return frame.angle == Vec3{} ? a : rotated(frame.rotation, a);
}

Vec3 BodyRotations::rigid_velocity(Index body, const Vec3& position) const {
  const RigidMotion& start = at(starts_, body);
  const Vec3 angular_velocity = start.angular_velocity();
  return is_finite(angular_velocity) ? cross(angular_velocity, position - start.center) : Vec3{};
}

Vec3 BodyRotations::rigid_displacement(Index body, const Vec3& position) const {
  return has_frame(body) ? displacement(body, position) : time_step_ * rigid_velocity(body, position);
}

Vec3 BodyRotations::inertial_acceleration(Index body, const Vec3& position) const {
  const Frame& frame = at(frames_, body);
  const Vec3 arm_end = rotated(frame.rotation, position - frame.center);
  return -(cross(frame.angular_velocity, cross(frame.angular_velocity, arm_end)) +
           cross(frame.angular_acceleration, arm_end));
}

Vec3 BodyRotations::free_velocity(Index body, const Vec3& position, const Vec3& velocity) const {
  const Frame& frame = at(frames_, body);
  if (frame.angle == Vec3{}) return velocity;
  const Vec3 arm = position - frame.center;
  const Vec3 rigid = cross(at(starts_, body).angular_velocity(), arm);
  const Vec3 deformation = velocity - frame.velocity - rigid;
  const Vec3 turns = rigid + (1.0 - frame.coriolis) * deformation;
  const Vec3 velocity_end = frame.velocity + rotated(frame.rotation, turns) + frame.coriolis * deformation +
                            cross(frame.correction, rotated(frame.rotation, arm));
  return velocity_end + excess_velocity(body, position);
}

}  // namespace palpate::fem
