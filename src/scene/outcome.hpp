#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <palpate/types.hpp>

#include "scene/parts.hpp"

/// Outcomes of a scene: the quantities that a run is to determine.
namespace palpate {

/// A material point, by its position in a body at rest; it moves with the tet that contains it.
struct ScenePoint {
  std::string body;
  Vec3 at{};
};
/// Displacement from rest: of the centre of mass of a body, or of a material point.
struct DisplacementOutcome {
  std::string body;
  std::optional<Vec3> at{};
  std::optional<Vec3> along{};  ///< given: only the component along this direction, with its sign
};
/// Rotation of a body from its placement: the best fit to its shape, weighted by mass.
struct RotationOutcome {
  std::string body;
  std::optional<Vec3> about{};  ///< given: only the component about this direction, with its sign
};
struct DistanceOutcome {
  ScenePoint from;
  ScenePoint to;
};
/// The half space on the side of a plane's normal.
struct ScenePlane {
  Vec3 point{};
  Vec3 normal{0.0, 0.0, 1.0};
};
/// Volume of the part of a body that is beyond all of these planes and inside another body.
struct VolumeOutcome {
  std::string body;
  std::vector<ScenePlane> beyond{};
  std::optional<std::string> within{};
};
/// Volume that a part of a body's surface encloses.
struct CavityOutcome {
  std::string body;
  std::vector<PointPart> walls;  ///< the surface triangles with all corners in the union of these selections
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
/// Contact force on a body: by all others, or by one.
struct ForceOutcome {
  std::string body;
  std::optional<std::string> from{};
  std::optional<Vec3> along{};
};

struct SceneOutcome {
  std::string name;
  std::variant<DisplacementOutcome, RotationOutcome, DistanceOutcome, VolumeOutcome, CavityOutcome,
               GapOutcome, ContactAreaOutcome, StressOutcome, ForceOutcome>
      of;
};

}  // namespace palpate
