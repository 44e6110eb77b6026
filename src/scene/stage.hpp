#pragma once

#include <optional>
#include <string>
#include <vector>

#include <palpate/types.hpp>

#include "scene/parts.hpp"

/// Stages of a scene: what changes at the start of each, and when it ends.
namespace palpate {

/// Some points of a body, by where they are when the run starts.
struct StagePart {
  Selection points;
};
/// A body, or a part of it.
struct StageBody {
  std::string body;
  std::optional<StagePart> part{};  ///< none: all of it
};
/// Moves a body, or a part of it, from where it is when the stage starts. A rigid body takes what is attached
/// to it along.
struct StageMove {
  std::string body;
  std::optional<StagePart> part{};
  SceneMotion motion;  ///< its times count from the start of the stage
};
/// Ties points of a body to another that deforms, where they are when the stage starts.
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
/// Loads in place of all those of a body; times of ramps count from the start of the stage.
struct StageLoads {
  std::string body;
  std::vector<Load> loads;
};

/// The force of contacts on a body, of all or of one other.
struct ForceReached {
  std::string body;
  std::optional<std::string> from{};
  double at_least = 0.0;
};
/// When a stage ends: one of three.
struct StageEnd {
  std::optional<double> time{};         ///< after so long
  std::optional<bool> rest{};           ///< true: once all bodies are at rest
  std::optional<ForceReached> force{};  ///< once this force is reached
  std::optional<double> most{};         ///< at the latest after so long; none with `time`
  [[nodiscard]] double limit() const { return time ? *time : most.value_or(0.0); }
};

/// A part of a run. What it changes is changed in the order of the members.
struct Stage {
  std::string name;
  BodyNames insert{};  ///< bodies that are there from now on
  BodyNames remove{};  ///< bodies that are not there any more
  std::vector<StageBody> release{};
  std::vector<StageBody> fix{};
  std::vector<StageMove> move{};
  std::vector<StageCut> untie{};
  std::vector<StageTie> tie{};
  std::vector<StageLoads> loads{};
  std::optional<Vec3> gravity{};
  StageEnd until{};
  bool checkpoint = false;  ///< its end is kept, so that other runs can begin there
};

}  // namespace palpate
