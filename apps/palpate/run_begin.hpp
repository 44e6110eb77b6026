#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "checkpoint.hpp"
#include "detection_options.hpp"
#include "scene_input.hpp"

namespace palpate::app {

/// The flags of `palpate run`.
struct RunOptions {
  SceneChoice scene;
  std::optional<std::filesystem::path> resume;
  std::optional<std::int64_t> checkpoint_every;
  std::optional<std::int64_t> steps;
  bool until_rest = false;
  std::optional<std::filesystem::path> out;
  std::optional<std::string> from_stage;
  std::optional<std::filesystem::path> from;
  bool replace = false;
  bool report = false;
  std::optional<int> every;
  bool no_picture = false;
  bool strict = false;
  bool json = false;
  bool quiet = false;
  int threads = 0;
  DetectionOptions detection;
};

/// A run that is about to begin or to be resumed: its settings, from a scene and flags or from a checkpoint.
struct Begin {
  RunPlan plan;
  SceneInput input;
  std::filesystem::path folder;
  std::optional<FoundCheckpoint> checkpoint;
  bool replace = false;                     ///< replace results, also those of a killed run
  std::optional<std::string> from_stage{};  ///< the checkpoint is the end of this stage of another run
  std::optional<std::filesystem::path> other_folder{};  ///< results of that run; none: in the same folder
};

/// The run that the flags ask for: a new one, a resumed one, or one that begins at the end of a stage. Throws
/// BadInput in one line if that is impossible.
Begin begin_run(const RunOptions& options);

/// Throws BadInput if the folder has checkpoints of a run that was killed, interrupted or failed, and the
/// run was not asked to replace them: the user may not know that they would be lost.
void check_replaceable(const Begin& begin);

/// Copies the rows of the run in the other folder, if there is one, up to where this run begins. Call it when
/// the folder is locked and nothing else can be refused. Throws BadInput without a change if they are not
/// there.
void copy_earlier_rows(const Begin& begin);

/// Whether the files of the resumed run have the same columns as this run.
bool has_same_columns(const Begin& begin);

}  // namespace palpate::app
