// Points that move along arcs instead of the straight paths of a solution.
#include <algorithm>

#include "fem/body_rotations.hpp"

namespace palpate::fem {

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
  const Vec3 angle = multiply_rotated(frame.rotation, start.inverse_inertia, moment);
  const bool dominates = frame.angle != Vec3{} || dot(moment, angle) > 0.5 * moved;
  if (!dominates || !swells(body, angle, energy)) return {};
  arc.angle = angle;
  arc.rotation = rotation_by(angle);
  const Vec3 momentum =
      (1.0 / time_step_) * moment + multiply_rotated(frame.rotation, start.inertia, frame.angular_velocity);
  const Vec3 lost = rotated_back(arc.rotation, momentum) - momentum;
  arc.correction = rotated(arc.rotation, multiply_rotated(frame.rotation, start.inverse_inertia, lost));
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

}  // namespace palpate::fem
