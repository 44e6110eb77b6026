#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <palpate/types.hpp>

#include "scene/parts.hpp"

/// Outcomes of a scene: the quantities that a run is about.
namespace palpate {

/// A place in a body at rest; it goes with the tet that holds it.
struct ScenePoint {
  std::string body;
  Vec3 at{};
};
/// How far the centre of mass of a body, or a place in it, is from where it is at rest.
struct DisplacementOutcome {
  std::string body;
  std::optional<Vec3> at{};
  std::optional<Vec3> along{};  ///< only the part along this direction, with its sign
};
/// By how much a body has turned from its placement: the rotation that is nearest to its shape by mass.
struct RotationOutcome {
  std::string body;
  std::optional<Vec3> about{};  ///< only the part about this direction, with its sign
};
struct DistanceOutcome {
  ScenePoint from;
  ScenePoint to;
};
/// What is on the side of the normal of a plane.
struct ScenePlane {
  Vec3 point{};
  Vec3 normal{0.0, 0.0, 1.0};
};
/// Volume of a body that is beyond all of these planes and in another body.
struct VolumeOutcome {
  std::string body;
  std::vector<ScenePlane> beyond{};
  std::optional<std::string> within{};
};
/// The least distance of two bodies, 0 where they touch.
struct GapOutcome {
  BodyNames bodies;
};
struct ContactAreaOutcome {
  BodyNames bodies;
};
/// The largest von Mises stress.
struct StressOutcome {
  std::string body;
};
/// Force of contacts on a body, of all or of one other.
struct ForceOutcome {
  std::string body;
  std::optional<std::string> from{};
  std::optional<Vec3> along{};
};

struct SceneOutcome {
  std::string name;
  std::variant<DisplacementOutcome, RotationOutcome, DistanceOutcome, VolumeOutcome, GapOutcome,
               ContactAreaOutcome, StressOutcome, ForceOutcome>
      of;
};

}  // namespace palpate
