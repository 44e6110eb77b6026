#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <palpate/simulation.hpp>

#include "scene/placed_overlaps.hpp"
#include "scene/scene.hpp"
#include "scene/stage_change.hpp"

namespace palpate {

/// How a stage ended.
struct StageEnding {
  std::int64_t step = 0;
  bool reached = true;  ///< false: its condition was not met by the time it may last at most
  std::vector<PlacedOverlap> overlaps{};  ///< of bodies that the plan put into rigid ones
};

/// Where a run is in its stages: part of a checkpoint. A simulation's own saved state has what they changed,
/// but for gravity.
struct StageProgress {
  std::vector<StageEnding> endings;  ///< of the stages that are over
  bool begun = false;                ///< the next one
};

/// Steps that all stages of a scene take at most. Throws Error where they are more than can be counted.
[[nodiscard]] std::int64_t most_steps_of_stages(const Scene& scene);

/// Leads a simulation through the stages of a scene: begin(), then steps, and after each step ends(). A scene
/// without stages is done at once.
class StageRun {
 public:
  /// Throws Error as StageChanges does, and where steps of a stage are more than can be counted.
  StageRun(const Scene& scene, const Simulation& simulation);

  [[nodiscard]] bool any() const { return !stages_.empty(); }
  /// Whether all stages are over.
  [[nodiscard]] bool done() const { return progress_.endings.size() == stages_.size(); }
  /// The stage that is running, or that begins next; of a run that is done the last.
  [[nodiscard]] const Stage& stage() const;
  /// Begins the next stage: changes the simulation. Nothing where it has begun, or all are over. Throws Error
  /// where the simulation refuses a change.
  void begin(Simulation& simulation);
  /// After a step: whether the stage ends with it. Then another begin() is due, unless it was the last.
  bool ends(const Simulation& simulation);

  [[nodiscard]] const StageProgress& progress() const { return progress_; }
  /// Goes on where another run was. Throws Error on a progress with more stages than the scene has.
  void resume(Simulation& simulation, StageProgress progress);
  /// What is to be told of stages that are over: "stage 'settle' ended after 2 s, not at rest", and
  /// "stage 'insert' puts 'plate' into 'bone', by 1.2 mm at its end". Mostly empty.
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
  std::vector<std::int64_t> most_steps_;  ///< of each
  std::vector<Index> force_on_;           ///< of each; -1: no condition of force
  std::vector<Index> force_from_;         ///< of each; -1: of all
  StageChanges changes_;
  PlacedOverlaps placed_;
  StageProgress progress_;
};

}  // namespace palpate
