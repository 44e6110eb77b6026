#pragma once

#include "geometry/rotation.hpp"
#include "scene/scene.hpp"

/// Converts rotations and motions of a scene to those of the library.
namespace palpate {

inline Quaternion quaternion_of(const Rotation& rotation) {
  return rotation.quaternion ? palpate::quaternion_of(*rotation.quaternion)
                             : rotation_about(rotation.axis, rotation.angle);
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
