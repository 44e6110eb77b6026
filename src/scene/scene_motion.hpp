#pragma once

#include "geometry/rotation.hpp"
#include "scene/scene.hpp"

/// Turns and motions of a scene, as the library has them.
namespace palpate {

inline Turn turn_of(const Rotation& rotation) {
  return rotation.quaternion ? palpate::turn_of(*rotation.quaternion)
                             : turn_about(rotation.axis, rotation.angle);
}

inline Motion motion_of(const SceneMotion& scene_motion) {
  Motion motion{scene_motion.center, {}, scene_motion.interpolation};
  for (const SceneKeyframe& key : scene_motion.keyframes) {
    const Turn turn = turn_of(key.rotate);
    motion.keyframes.push_back(
        {key.time, key.translate, {turn.scalar, turn.vector.x, turn.vector.y, turn.vector.z}});
  }
  return motion;
}

}  // namespace palpate
