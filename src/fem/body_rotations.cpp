#include "fem/body_rotations.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/lumping.hpp"
#include "fem/rotation.hpp"
#include "fem/symmetric_eigen.hpp"
#include "geometry/trigonometry.hpp"

namespace palpate::fem {
namespace {

/// Largest angle by which points move along arcs, rad. Contacts then have an error of 0.3 % of the body's
/// size.
constexpr double largest_arc_angle = 0.08;
/// A body whose matrix has the derivative of its forces by rotations has a frame if it rotates by more than
/// this in a step, rad.
constexpr double braked_angle = 1e-3;

Quaternion rotation_by(const Vec3& angle) {
  if (angle == Vec3{}) return {};
  return rotation_about(angle, 180.0 / std::numbers::pi * length(angle));
}
Vec3 rotated_back(const Quaternion& rotation, const Vec3& a) {
  return rotated({rotation.scalar, -rotation.vector}, a);
}
/// A body's symmetric matrix, rotated with the body, times a vector.
Vec3 turned(const Quaternion& rotation, const Matrix3& matrix, const Vec3& a) {
  return rotated(rotation, matrix * rotated_back(rotation, a));
}

/// Two rotations, the second argument first.
Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {a.scalar * b.scalar - dot(a.vector, b.vector),
          a.scalar * b.vector + b.scalar * a.vector + cross(a.vector, b.vector)};
}

/// The rotation vector of a rotation, its angle in [0, pi], rad.
Vec3 rotation_vector(const Quaternion& q) {
  const double sine = length(q.vector);
  if (sine == 0.0) return {};
  const double half = arc_tangent(sine, std::abs(q.scalar));
  return ((q.scalar < 0.0 ? -2.0 : 2.0) * half / sine) * q.vector;
}

/// All of the Coriolis force up to half a radian, none from one on.
double coriolis_fraction(double angle) {
  return std::clamp(2.0 * (1.0 - angle), 0.0, 1.0);
}

/// Fraction of the angular impulse that forces of joints lack. With all of it, tied bodies would gain up to 7
/// times the square of the angle of it.
double joint_fraction(double angle) {
  return std::max(0.0, 1.0 - 7.0 * angle * angle);
}

/// The rotation vector of a rigid body without torque over a step. A body with the middle principal moment of
/// inertia about all axes rotates about the angular momentum. The rest of the motion is made of short
/// rotations about the two other principal axes, one after the other (Dullweber, Leimkuhler & McLachlan, J.
/// Chem. Phys. 107 (1997), 5840). Angular momentum is constant, and errors do not grow from step to step.
/// Exact where two moments are equal. (The implicit midpoint rule, solved by repeated substitution, diverges
/// for slender bodies: a small tilt of the axis is a fast rotation about it.)
Vec3 free_angle(const RigidMotion& start, double time_step) {
  constexpr int parts = 4;
  const SymmetricEigen principal = symmetric_eigen(symmetric_part(start.inertia));
  const double middle = principal.values.y;
  const auto rate_beyond = [&](double inertia) { return 1.0 / inertia - 1.0 / middle; };
  const double largest = rate_beyond(principal.values.x);
  const double smallest = rate_beyond(principal.values.z);
  Quaternion body;
  const auto rotate = [&](const Vec3& axis, double rate, double fraction) {
    const Vec3 direction = rotated(body, axis);
    const double angle = fraction / parts * time_step * rate * dot(start.momentum, direction);
    body = product(rotation_by(angle * direction), body);
  };
  for (int i = 0; i < parts; ++i) {
    rotate(principal.vectors[0], largest, 0.5);
    rotate(principal.vectors[2], smallest, 1.0);
    rotate(principal.vectors[0], largest, 0.5);
  }
  return rotation_vector(product(rotation_by(time_step / middle * start.momentum), body));
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
      turns_(bodies_.size()) {
  for (Index body = 0; body < bodies.body_count(); ++body) {
    if (at(obstacles, body) != 0) continue;
    const Range tets = at(bodies_, body).tets;
    for (Index tet = tets.begin; tet < tets.end; ++tet) {
      at(stretch_energies_, body) += materials.of(tet, body).young_modulus * tet_volume_rest(bodies, tet);
    }
  }
}

RigidMotion BodyRotations::rigid_motion(std::size_t body, std::span<const Vec3> positions,
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
  Matrix3& inertia = motion.inertia;
  for (Index i = points.begin; i < points.end; ++i) {
    const double m = at(masses_, i);
    const Vec3 arm = at(positions, i) - motion.center;
    const Vec3 velocity = at(velocities, i) - motion.velocity;
    motion.momentum += m * cross(arm, velocity);
    motion.deformation[0] += m * arm.x * velocity;
    motion.deformation[1] += m * arm.y * velocity;
    motion.deformation[2] += m * arm.z * velocity;
    motion.energy += 0.5 * m * squared_length(velocity);
    add_outer(inertia, -m, arm, arm);
    for (int k = 0; k < 3; ++k) inertia(k, k) += m * squared_length(arm);
  }
  motion.inverse_inertia = inverse(inertia);
  const Vec3 angular_velocity = motion.angular_velocity();
  const double half_trace = 0.5 * trace(inertia);
  for (int k = 0; k < 3; ++k) {
    Vec3 second_moment = -row(inertia, k);  // sum of m r_k r
    (k == 0 ? second_moment.x : k == 1 ? second_moment.y : second_moment.z) += half_trace;
    at(motion.deformation, k) -= cross(angular_velocity, second_moment);
  }
  return motion;
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

/// \param momentum  angular momentum at the end of the step
void BodyRotations::set_frame(std::size_t body, const Vec3& angle, const Vec3& momentum) {
  const RigidMotion& start = starts_[body];
  const Quaternion rotation = rotation_by(angle);
  const auto rotated_by = [&](const Vec3& of_momentum) {
    return turned(rotation, start.inverse_inertia, of_momentum);
  };
  const Vec3 angular_velocity = rotated_by(momentum);
  const double coriolis = coriolis_fraction(length(angle));
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
                          std::span<const std::uint8_t> braked) {
  time_step_ = time_step;
  parallel::for_each(threads, bodies_.size(), 1, [&](std::size_t body) {
    frames_[body] = {};
    if (stretch_energies_[body] == 0.0) return;
    starts_[body] = rigid_motion(body, positions, velocities);
    if (!starts_[body].dominates()) return;
    const Vec3 angle = free_angle(starts_[body], time_step);
    const bool is_braked = !braked.empty() && braked[body] != 0 && length(angle) > braked_angle;
    if (is_braked || swells(body, angle, starts_[body].energy))
      set_frame(body, angle, starts_[body].momentum);
  });
}

bool BodyRotations::follow(const parallel::Threads& threads, std::span<const Vec3> positions,
                           std::span<const Vec3> velocities) {
  parallel::for_each(threads, bodies_.size(), 1, [&](std::size_t body) {
    changed_[body] = 0;
    if (stretch_energies_[body] == 0.0) return;
    const RigidMotion mean = rigid_motion(body, positions, velocities);
    const Frame& last = frames_[body];
    const Vec3 left = angle_of(body, mean, positions, velocities) - last.angle;
    if (length(left) <= largest_arc_angle || !swells(body, left, mean.energy)) return;
    const double step_length =
        last.left == Vec3{} ? 1.0 : next_step_length(last.left, left, last.step_length);
    const Vec3 angle = last.angle + step_length * left;
    // Angular momentum at mid-step: h times omega there is the angle.
    const Quaternion half = rotation_by(0.5 * angle);
    const Vec3 momentum = (1.0 / time_step_) * turned(half, starts_[body].inertia, angle);
    const Quaternion before = last.rotation;
    set_frame(body, angle, momentum);
    const Quaternion turn = product(frames_[body].rotation, {before.scalar, -before.vector});
    turns_[body] = {
        .rotation = turn, .angle = rotation_vector(turn), .before = before, .velocity = mean.velocity};
    frames_[body].left = left;
    frames_[body].step_length = step_length;
    changed_[body] = 1;
  });
  return std::ranges::find(changed_, 1) != changed_.end();
}

Vec3 BodyRotations::turned_velocity(Index body, const Vec3& position, const Vec3& velocity) const {
  const Turn& turn = at(turns_, body);
  const Vec3 arm = position - at(starts_, body).center;
  const Vec3 turned = rotated(turn.before, arm);
  // The displacement from the rotated body is the deformation and, along straight paths, the turn.
  const Vec3 displacement = time_step_ * (velocity - turn.velocity) - (turned - arm);
  const Vec3 deformation = displacement - cross(turn.angle, turned);
  const Vec3 end = rotated(turn.rotation, turned + deformation);
  return turn.velocity + (1.0 / time_step_) * (end - arm);
}

bool BodyRotations::any() const {
  return std::ranges::any_of(frames_, [](const Frame& frame) { return frame.angle != Vec3{}; });
}

double BodyRotations::largest_angle() const {
  double largest = 0.0;
  for (const Frame& frame : frames_) largest = std::max(largest, length(frame.angle));
  return largest;
}

Vec3 BodyRotations::displacement(Index body, const Vec3& position) const {
  const Frame& frame = at(frames_, body);
  if (frame.angle == Vec3{}) return {};
  const Vec3 arm = position - frame.center;
  return rotated(frame.rotation, arm) - arm;
}

BodyRotations::ArcMotion BodyRotations::arc_motion_of(std::size_t body, std::span<const Vec3> positions,
                                                      std::span<const Vec3> velocities) const {
  const Range points = bodies_[body].points;
  const Frame& frame = frames_[body];
  const RigidMotion& start = starts_[body];
  double mass = 0.0;
  ArcMotion arc;
  for (Index i = points.begin; i < points.end; ++i) {
    mass += at(masses_, i);
    arc.velocity += at(masses_, i) * at(velocities, i);
  }
  arc.velocity = (1.0 / mass) * arc.velocity;
  double energy = 0.0;  // of the motion about the centre
  for (Index i = points.begin; i < points.end; ++i)
    energy += 0.5 * at(masses_, i) * squared_length(at(velocities, i) - arc.velocity);
  // Moment of the displacements (beyond those of the frame) about the rotated positions.
  Vec3 moment;
  double moved = 0.0;
  for (Index i = points.begin; i < points.end; ++i) {
    const Vec3 arm = rotated(frame.rotation, at(positions, i) - start.center);
    const Vec3 motion = time_step_ * (at(velocities, i) - arc.velocity) -
                        displacement(static_cast<Index>(body), at(positions, i));
    moment += at(masses_, i) * cross(arm, motion);
    moved += at(masses_, i) * squared_length(motion);
  }
  const Vec3 angle = turned(frame.rotation, start.inverse_inertia, moment);
  const bool dominates = frame.angle != Vec3{} || dot(moment, angle) > 0.5 * moved;
  if (!dominates || !swells(body, angle, energy)) return {};
  arc.angle = angle;
  arc.rotation = rotation_by(angle);
  const Vec3 momentum =
      (1.0 / time_step_) * moment + turned(frame.rotation, start.inertia, frame.angular_velocity);
  const Vec3 lost = rotated_back(arc.rotation, momentum) - momentum;
  arc.correction = rotated(arc.rotation, turned(frame.rotation, start.inverse_inertia, lost));
  return arc;
}

bool BodyRotations::set_arcs(const parallel::Threads& threads, std::span<const Vec3> positions,
                             std::span<const Vec3> velocities, std::span<const std::uint8_t> held) {
  parallel::for_each(threads, bodies_.size(), 1, [&](std::size_t body) {
    arcs_[body] = {};
    if (stretch_energies_[body] > 0.0 && held[body] == 0)
      arcs_[body] = arc_motion_of(body, positions, velocities);
  });
  return std::ranges::any_of(arcs_, [](const ArcMotion& arc) { return arc.angle != Vec3{}; });
}

Vec3 BodyRotations::arc_displacement(Index body, const Vec3& position) const {
  const ArcMotion& arc = at(arcs_, body);
  if (arc.angle == Vec3{}) return {};
  const Frame& frame = at(frames_, body);
  const Vec3 arm = rotated(frame.rotation, position - at(starts_, body).center);
  return rotated(arc.rotation, arm) - arm - cross(arc.angle, arm);
}

Vec3 BodyRotations::arc_velocity(Index body, const Vec3& position, const Vec3& velocity) const {
  const ArcMotion& arc = at(arcs_, body);
  if (arc.angle == Vec3{}) return velocity;
  const Frame& frame = at(frames_, body);
  const Vec3 arm = rotated(arc.rotation, rotated(frame.rotation, position - at(starts_, body).center));
  return arc.velocity + rotated(arc.rotation, velocity - arc.velocity) + cross(arc.correction, arm);
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

Vec3 BodyRotations::lost_impulse(Index body, const Vec3& position, const Vec3& place,
                                 const Vec3& force) const {
  if (!has_frame(body)) return {};
  const Frame& frame = at(frames_, body);
  const Vec3 acted_at = rotated(frame.rotation, position - frame.center);
  return joint_fraction(length(frame.angle)) * time_step_ * cross(place - frame.center - acted_at, force);
}

Vec3 BodyRotations::allowed_impulse(Index body, const Vec3& lasting, const Vec3& contacts,
                                    std::span<const Vec3> positions, std::span<const Vec3> velocities) const {
  if (!has_frame(body)) return {};
  const Frame& frame = at(frames_, body);
  const auto by_inertia = [&](const Vec3& a) {
    return turned(frame.rotation, at(starts_, body).inverse_inertia, a);
  };
  Vec3 momentum;  // about the centre of the rotated body, whose arms add up to zero by mass
  const Range points = at(bodies_, body).points;
  for (Index i = points.begin; i < points.end; ++i) {
    momentum +=
        at(masses_, i) * cross(rotated(frame.rotation, at(positions, i) - frame.center), at(velocities, i));
  }
  const Vec3 left = by_inertia(momentum);
  const double fraction = dot(left, frame.angular_velocity) / squared_length(frame.angular_velocity);
  const Vec3 impulse = lasting + (dot(contacts, left) < 0.0 ? contacts : Vec3{});
  const Vec3 change = by_inertia(impulse);
  constexpr double most = 0.25;
  double part = std::min(1.0, most * length(frame.angular_velocity) / length(change));
  // A part of it that makes the body as fast as its frame, but not faster.
  const double faster = dot(change, frame.angular_velocity) / squared_length(frame.angular_velocity);
  if (part * faster > 0.0) part = std::min(part, std::max(0.0, 1.0 - fraction) / faster);
  return (part * std::clamp(4.0 * fraction - 2.0, 0.0, 1.0)) * impulse;
}

Vec3 BodyRotations::velocity_by(Index body, const Vec3& position, const Vec3& impulse) const {
  const Frame& frame = at(frames_, body);
  return cross(turned(frame.rotation, at(starts_, body).inverse_inertia, impulse),
               rotated(frame.rotation, position - frame.center));
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
