// Angular impulses that forces of a step lack in rotated frames.
#include <algorithm>

#include "fem/body_rotations.hpp"

namespace palpate::fem {
Vec3 BodyRotations::lost_impulse(Index body, const Vec3& position, const Vec3& place,
                                 const Vec3& force) const {
  if (!has_frame(body)) return {};
  const Frame& frame = at(frames_, body);
  const Vec3 acted_at = rotated(frame.rotation, position - frame.center);
  return time_step_ * cross(place - frame.center - acted_at, force);
}

Vec3 BodyRotations::lost_momentum(Index body, const Vec3& position, const Vec3& displacement) const {
  const Frame& frame = at(frames_, body);
  const Vec3 arm = rotated(frame.rotation, position - frame.center);
  return frame.coriolis * cross(cross(frame.angular_velocity, arm), displacement);
}

Vec3 BodyRotations::bounded_impulse(Index body, const Vec3& impulse) const {
  constexpr double most = 0.25;
  const Frame& frame = at(frames_, body);
  const double change = length(multiply_rotated(frame.rotation, at(starts_, body).inverse_inertia, impulse));
  const double bound = most * length(frame.angular_velocity);
  return change > bound ? (bound / change) * impulse : impulse;
}

Vec3 BodyRotations::allowed_impulse(Index body, const Vec3& lasting, const Vec3& contacts,
                                    std::span<const Vec3> positions, std::span<const Vec3> velocities) const {
  if (!has_frame(body)) return {};
  const Frame& frame = at(frames_, body);
  const auto by_inertia = [&](const Vec3& a) {
    return multiply_rotated(frame.rotation, at(starts_, body).inverse_inertia, a);
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
  return cross(multiply_rotated(frame.rotation, at(starts_, body).inverse_inertia, impulse),
               rotated(frame.rotation, position - frame.center));
}

}  // namespace palpate::fem
