#pragma once

#include <cmath>

#include "geometry/rotation.hpp"
#include "scene/scene.hpp"

/// Converts rotations and motions of a scene to those of the library.
namespace palpate {

inline Quaternion quaternion_of(const Rotation& rotation) {
  return rotation.quaternion ? palpate::quaternion_of(*rotation.quaternion)
                             : rotation_about(rotation.axis, rotation.angle);
}

/// Whether two keyframes have angles about one axis that differ by more than half a turn. Between them a
/// motion would take the shorter arc, the other way round.
inline bool turns_too_far(const SceneKeyframe& from, const SceneKeyframe& to) {
  const Rotation& a = from.rotate;
  const Rotation& b = to.rotate;
  if (a.quaternion || b.quaternion) return false;
  constexpr double parallel = 1.0 - 1e-9;
  const bool any_axis = a.angle == 0.0 || b.angle == 0.0;
  const double cosine_of_axes = any_axis ? 1.0 : dot(a.axis, b.axis) / (length(a.axis) * length(b.axis));
  return std::abs(cosine_of_axes) > parallel &&
         std::abs(b.angle - std::copysign(a.angle, a.angle * cosine_of_axes)) > 180.0;
}

inline Motion motion_of(const SceneMotion& scene_motion) {
  Motion motion{scene_motion.center, {}, scene_motion.interpolation};
  for (const SceneKeyframe& key : scene_motion.keyframes) {
    const Quaternion rotation = quaternion_of(key.rotate);
    motion.keyframes.push_back({key.time,
                                key.translate,
                                {rotation.scalar, rotation.vector.x, rotation.vector.y, rotation.vector.z}});
  }
  return motion;
}

}  // namespace palpate
