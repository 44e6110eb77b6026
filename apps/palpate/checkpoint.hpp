#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <palpate/simulation.hpp>

#include "forces_file.hpp"
#include "frame_writer.hpp"
#include "metrics_file.hpp"
#include "run_loop.hpp"
#include "scene/scene.hpp"
#include "sim/archive.hpp"

namespace palpate::app {

inline constexpr Seal checkpoint_seal{.kind = "PALPRUN ", .version = 6};

/// The settings of a run: enough to resume it without its scene file and flags. Meshes are read again.
struct RunPlan {
  std::string scene_file;
  std::string scene;         ///< write_scene(), with the settings that were used
  std::string source;        ///< Scene::source
  std::string scene_folder;  ///< Scene::folder, absolute
  std::int64_t most_steps = 0;
  bool until_rest = false;
  bool no_picture = false;
  bool strict = false;
  std::int64_t checkpoint_every = 0;  ///< in steps; 0: only if the run is interrupted
};

/// The state of a run at the end of a step, and the sizes of its files at that time.
struct Checkpoint {
  RunPlan plan;
  RunOutcome outcome;  ///< without times
  std::uint64_t metrics_bytes = 0;
  std::uint64_t forces_bytes = 0;
  FramesSoFar frames;
  std::vector<std::byte> simulation;  ///< Simulation::save()
  StageProgress stages;
};

/// The checkpoints of a run: RESULTS/checkpoints/step_NNNNNNNNN.palpate, the last two.
class CheckpointWriter {
 public:
  /// Removes the checkpoints of an earlier run, except the one from which this run is resumed. Throws Error
  /// naming what cannot be removed.
  CheckpointWriter(const std::filesystem::path& results, RunPlan plan,
                   const std::optional<std::filesystem::path>& resumed_from);

  /// Writes a checkpoint if its step is due, or if `always`; never the same step twice. Rows and frames so
  /// far reach the disk before it. Then removes all but this one and the one before it. Throws Error naming
  /// the file that cannot be written; existing checkpoints then stay.
  void add(const Simulation& simulation, const RunOutcome& outcome, const RunOutputs& outputs,
           bool always = false);
  /// Writes RESULTS/stages/NAME.palpate: the end of a stage, from which other runs can begin.
  void keep_stage(const std::string& name, const Simulation& simulation, const RunOutcome& outcome,
                  const RunOutputs& outputs) const;

  [[nodiscard]] bool regular() const { return plan_.checkpoint_every > 0; }
  /// The step of the last checkpoint; empty if there is none yet.
  [[nodiscard]] std::optional<std::int64_t> last_step() const { return last_step_; }

 private:
  void remove_but(const std::vector<std::filesystem::path>& kept) const;
  void write(const std::filesystem::path& path, const Simulation& simulation, const RunOutcome& outcome,
             const RunOutputs& outputs) const;

  std::filesystem::path folder_;
  std::filesystem::path stage_folder_;
  RunPlan plan_;
  std::optional<std::filesystem::path> last_;
  std::optional<std::int64_t> last_step_;
};

/// A checkpoint from which a run can be resumed.
struct FoundCheckpoint {
  std::filesystem::path path;
  Checkpoint checkpoint;
  std::vector<std::string> damaged;  ///< messages about later checkpoints that are truncated or damaged
};

/// The checkpoint at the end of a stage, in a folder of results. Throws BadInput, in one line with the names
/// of existing ones, if there is none.
FoundCheckpoint find_stage(const std::filesystem::path& results, const std::string& stage);

/// Whether there are checkpoints in a folder of results, undamaged or not.
bool has_checkpoints(const std::filesystem::path& results);

/// The last undamaged checkpoint in a folder of results. Throws BadInput, in one line, if there is none.
FoundCheckpoint find_checkpoint(const std::filesystem::path& results);

}  // namespace palpate::app
