#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <palpate/simulation.hpp>

#include "scene/placed_overlaps.hpp"
#include "scene/scene.hpp"
#include "scene/stage_change.hpp"

namespace palpate {

/// How a stage has ended.
struct StageEnding {
  std::int64_t step = 0;
  bool reached = true;                    ///< false: its time was over before its condition was met
  std::vector<PlacedOverlap> overlaps{};  ///< bodies that the scene has placed inside rigid ones
};

/// The progress of a run through its stages: part of a checkpoint. The saved state of the simulation contains
/// all that stages have changed, except gravity.
struct StageProgress {
  std::vector<StageEnding> endings;  ///< of completed stages
  bool begun = false;                ///< the next stage has begun
};

/// The sum of the largest numbers of steps of all stages. Throws Error if it overflows.
[[nodiscard]] std::int64_t most_steps_of_stages(const Scene& scene);

/// Runs a simulation through the stages of a scene: call begin(), then make steps, and after each step call
/// ends(). A scene without stages is complete at once.
class StageRun {
 public:
  /// Throws Error as StageChanges does, and if the number of steps of a stage overflows.
  StageRun(const Scene& scene, const Simulation& simulation);

  [[nodiscard]] bool any() const { return !stages_.empty(); }
  /// Whether all stages are complete.
  [[nodiscard]] bool done() const { return progress_.endings.size() == stages_.size(); }
  /// The current stage, or the next one to begin; after the end, the last one.
  [[nodiscard]] const Stage& stage() const;
  /// Begins the next stage and changes the simulation; returns what it changed, besides gravity. Does nothing
  /// where it has begun or all are complete. Throws Error if the simulation refuses a change.
  std::optional<ModelChange> begin(Simulation& simulation);
  /// Call after a step: returns whether the stage ends with it. Then call begin() again, unless it was the
  /// last stage.
  bool ends(const Simulation& simulation);

  [[nodiscard]] const StageProgress& progress() const { return progress_; }
  /// Continues from the progress of another run. Throws Error if that has more stages than the scene.
  void resume(Simulation& simulation, StageProgress progress);
  /// Warnings about stages that are over: "stage 'settle' ended after 2 s, not at rest", or "stage 'insert'
  /// puts 'plate' into 'bone', by 1.2 mm at its end". Usually empty.
  [[nodiscard]] std::vector<std::string> warnings() const;

 private:
  [[nodiscard]] bool reached(const Simulation& simulation) const;
  [[nodiscard]] std::int64_t first_step() const;
  void set_gravity(Simulation& simulation, std::size_t stage) const;

  std::string source_;
  std::string time_unit_;
  std::string length_unit_;
  std::vector<std::string> body_names_;
  std::vector<Stage> stages_;
  std::vector<std::int64_t> most_steps_;  ///< per stage
  std::vector<Index> force_on_;           ///< per stage: the body of the force condition; -1: none
  std::vector<Index> force_from_;         ///< per stage: the other body; -1: all bodies
  StageChanges changes_;
  PlacedOverlaps placed_;
  StageProgress progress_;
};

}  // namespace palpate
