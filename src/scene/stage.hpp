#pragma once

#include <optional>
#include <string>
#include <vector>

#include <palpate/types.hpp>

#include "scene/parts.hpp"

/// Stages of a scene: what changes at the start of each, and when it ends.
namespace palpate {

/// A body, or a part of it.
struct StageBody {
  std::string body;
  std::optional<PointPart> part{};  ///< none: the whole body
};
/// Moves a body, or a part of it, from its position at the start of the stage. Whatever is attached to a
/// rigid body moves with it.
struct StageMove {
  std::string body;
  std::optional<PointPart> part{};
  SceneMotion motion;  ///< times count from the start of the stage
};
/// Ties points of a body to another deformable body, at their positions at the start of the stage.
struct StageTie {
  std::string body;
  std::string to;
  std::optional<double> stiffness{};
  Selection points;
};
/// Cuts all ties between two bodies.
struct StageCut {
  BodyNames bodies;
};
/// Loads that replace all loads of a body. Times of ramps count from the start of the stage.
struct StageLoads {
  std::string body;
  std::vector<Load> loads;
};

/// A contact force on a body: by all others, or by one.
struct ForceReached {
  std::string body;
  std::optional<std::string> from{};
  double at_least = 0.0;
};
/// The end of a stage: one of three conditions.
struct StageEnd {
  std::optional<double> time{};         ///< after this time
  std::optional<bool> rest{};           ///< true: when all bodies are at rest
  std::optional<ForceReached> force{};  ///< when this force is reached
  std::optional<double> most{};         ///< in any case after this time; not with `time`
  [[nodiscard]] double limit() const { return time ? *time : most.value_or(0.0); }
};

/// A part of a run. Its changes are applied in the order of the members.
struct Stage {
  std::string name;
  BodyNames insert{};  ///< bodies that are inserted
  BodyNames remove{};  ///< bodies that are removed
  std::vector<StageBody> release{};
  std::vector<StageBody> fix{};
  std::vector<StageMove> move{};
  std::vector<StageCut> untie{};
  std::vector<StageTie> tie{};
  std::vector<StageLoads> loads{};
  std::optional<Vec3> gravity{};
  StageEnd until{};
  bool checkpoint = false;  ///< its end is saved, so that other runs can start there
};

}  // namespace palpate
