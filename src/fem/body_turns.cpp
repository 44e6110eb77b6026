#include "fem/body_turns.hpp"

#include <algorithm>
#include <numbers>

#include "fem/lumping.hpp"
#include "geometry/trigonometry.hpp"

namespace palpate::fem {
namespace {

Turn turn_by(const Vec3& angle) {
  if (angle == Vec3{}) return {};
  return turn_about(angle, 180.0 / std::numbers::pi * length(angle));
}
Vec3 turned_back(const Turn& turn, const Vec3& a) {
  return rotated({turn.scalar, -turn.vector}, a);
}

/// The angle of a rigid body without torque over a step: h omega of the middle of the step.
Vec3 free_angle(const RigidMotion& start, double time_step) {
  Vec3 angle = time_step * start.angular_velocity();
  constexpr int rounds = 3;  // the third changes it by less than the rule's own error
  for (int i = 0; i < rounds; ++i) {
    const Turn half = turn_by(0.5 * angle);
    angle = time_step * rotated(half, start.inverse_inertia * turned_back(half, start.momentum));
  }
  return angle;
}

/// How much longer the angle of a turn is than its sine, by which straight ways to its end turn the body.
double arc_share(const RigidMotion& mean, double time_step) {
  const double turned = std::min(time_step * length(mean.angular_velocity()), 1.0);
  return turned > 0.0 ? arc_sine(turned) / turned : 1.0;
}

}  // namespace

BodyTurns::BodyTurns(const Bodies& bodies, const Materials& materials, std::span<const double> masses,
                     std::span<const std::uint8_t> obstacles)
    : bodies_(bodies.bodies().begin(), bodies.bodies().end()),
      masses_(masses.begin(), masses.end()),
      stretch_energies_(bodies_.size(), 0.0),
      frames_(bodies_.size()),
      starts_(bodies_.size()),
      changed_(bodies_.size(), 0) {
  for (Index body = 0; body < bodies.body_count(); ++body) {
    if (at(obstacles, body) != 0) continue;
    const Range tets = at(bodies_, body).tets;
    for (Index tet = tets.begin; tet < tets.end; ++tet) {
      at(stretch_energies_, body) += materials.of(tet, body).young_modulus * tet_volume_rest(bodies, tet);
    }
  }
}

RigidMotion BodyTurns::rigid_motion(std::size_t body, std::span<const Vec3> positions,
                                    std::span<const Vec3> velocities) const {
  const Range points = bodies_[body].points;
  double mass = 0.0;
  RigidMotion motion;
  for (Index i = points.begin; i < points.end; ++i) {
    const double m = at(masses_, i);
    mass += m;
    motion.center += m * at(positions, i);
    motion.velocity += m * at(velocities, i);
  }
  motion.center = (1.0 / mass) * motion.center;
  motion.velocity = (1.0 / mass) * motion.velocity;
  Matrix3 inertia;
  for (Index i = points.begin; i < points.end; ++i) {
    const double m = at(masses_, i);
    const Vec3 arm = at(positions, i) - motion.center;
    const Vec3 velocity = at(velocities, i) - motion.velocity;
    motion.momentum += m * cross(arm, velocity);
    motion.energy += 0.5 * m * squared_length(velocity);
    motion.whole_energy += 0.5 * m * squared_length(at(velocities, i));
    add_outer(inertia, -m, arm, arm);
    for (int k = 0; k < 3; ++k) inertia(k, k) += m * squared_length(arm);
  }
  motion.inverse_inertia = inverse(inertia);
  return motion;
}

/// Whether a turn by `angle` beyond that of the frame swells a body by much of this energy.
bool BodyTurns::swells(std::size_t body, const Vec3& angle, double energy) const {
  const double swelling = 1.0 - cosine(length(angle));
  constexpr double allowed = 1e-3;
  return stretch_energies_[body] * swelling * swelling > allowed * energy;
}

/// \param momentum  angular, at the end of the step
void BodyTurns::set_frame(std::size_t body, const Vec3& angle, const Vec3& momentum) {
  const RigidMotion& start = starts_[body];
  const Turn turn = turn_by(angle);
  const auto turned_by = [&](const Vec3& of_momentum) {
    return rotated(turn, start.inverse_inertia * turned_back(turn, of_momentum));
  };
  const Vec3 angular_velocity = turned_by(momentum);
  frames_[body] = {.center = start.center,
                   .velocity = start.velocity,
                   .angle = angle,
                   .turn = turn,
                   .angular_velocity = angular_velocity,
                   .angular_acceleration = turned_by(cross(momentum, angular_velocity)),
                   .correction = turned_by(start.momentum - rotated(turn, start.momentum))};
}

void BodyTurns::begin(const parallel::Threads& threads, std::span<const Vec3> positions,
                      std::span<const Vec3> velocities, double time_step) {
  time_step_ = time_step;
  parallel::for_each(threads, bodies_.size(), 1, [&](std::size_t body) {
    frames_[body] = {};
    if (stretch_energies_[body] == 0.0) return;
    starts_[body] = rigid_motion(body, positions, velocities);
    if (!starts_[body].dominates()) return;
    const Vec3 angle = free_angle(starts_[body], time_step);
    if (swells(body, angle, starts_[body].whole_energy)) set_frame(body, angle, starts_[body].momentum);
  });
}

bool BodyTurns::follow(const parallel::Threads& threads, std::span<const Vec3> positions,
                       std::span<const Vec3> velocities) {
  parallel::for_each(threads, bodies_.size(), 1, [&](std::size_t body) {
    changed_[body] = 0;
    if (stretch_energies_[body] == 0.0) return;
    const RigidMotion mean = rigid_motion(body, positions, velocities);
    const double longer = mean.dominates() ? arc_share(mean, time_step_) : 0.0;
    const Vec3 angle = longer > 0.0 ? (longer * time_step_) * mean.angular_velocity() : Vec3{};
    if (!swells(body, angle - frames_[body].angle, mean.whole_energy)) return;
    set_frame(body, angle, longer * mean.momentum);
    changed_[body] = 1;
  });
  return std::ranges::find(changed_, 1) != changed_.end();
}

bool BodyTurns::any() const {
  return std::ranges::any_of(frames_, [](const Frame& frame) { return frame.angle != Vec3{}; });
}

Vec3 BodyTurns::displacement(Index body, const Vec3& position) const {
  const Frame& frame = at(frames_, body);
  if (frame.angle == Vec3{}) return {};
  const Vec3 arm = position - frame.center;
  return rotated(frame.turn, arm) - arm;
}

Vec3 BodyTurns::excess_velocity(Index body, const Vec3& position) const {
  const Frame& frame = at(frames_, body);
  if (frame.angle == Vec3{}) return {};
  const Vec3 arm_end = rotated(frame.turn, position - frame.center);
  return (1.0 / time_step_) * displacement(body, position) - cross(frame.angular_velocity, arm_end);
}

Vec3 BodyTurns::inertial_acceleration(Index body, const Vec3& position) const {
  const Frame& frame = at(frames_, body);
  const Vec3 arm_end = rotated(frame.turn, position - frame.center);
  return -(cross(frame.angular_velocity, cross(frame.angular_velocity, arm_end)) +
           cross(frame.angular_acceleration, arm_end));
}

Vec3 BodyTurns::free_velocity(Index body, const Vec3& position, const Vec3& velocity) const {
  const Frame& frame = at(frames_, body);
  if (frame.angle == Vec3{}) return velocity;
  const Vec3 arm_end = rotated(frame.turn, position - frame.center);
  const Vec3 velocity_end =
      frame.velocity + rotated(frame.turn, velocity - frame.velocity) + cross(frame.correction, arm_end);
  return velocity_end + excess_velocity(body, position);
}

}  // namespace palpate::fem
