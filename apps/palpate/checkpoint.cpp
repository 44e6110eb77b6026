#include "checkpoint.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string_view>
#include <system_error>
#include <utility>

#include <palpate/error.hpp>

#include "exit_codes.hpp"
#include "io/atomic_file.hpp"
#include "io/file_bytes.hpp"
#include "scene/stage_archive.hpp"
#include "sim/saved_state.hpp"

namespace palpate::app {

// Functions that list the members of a checkpoint for archives, which find them by argument-dependent lookup.

template <class Archive>
void serialize(Archive& archive, RunPlan& p) {
  archive(p.scene_file, p.scene, p.source, p.scene_folder, p.most_steps, p.until_rest, p.no_picture, p.strict,
          p.checkpoint_every);
}

template <class Archive>
void serialize(Archive& archive, Tally& tally) {
  archive(tally.last, tally.largest, tally.total);
}

template <class Archive>
void serialize(Archive& archive, CuckooRun& run) {
  archive(run.last, run.lowest_occupancy, run.highest_occupancy, run.bucket_retries, run.redistributions,
          run.growths);
}

template <class Archive>
void serialize(Archive& archive, LargestForce& largest) {
  archive(largest.force, largest.step);
}

template <class Archive>
void serialize(Archive& archive, StageRecord& r) {
  archive(r.name, r.first_step, r.last_step, r.time, r.reached, r.steps_not_converged, r.inverted_tets,
          r.outcomes, r.state_hash, r.overlaps);
}

template <class Archive>
void serialize(Archive& archive, RunOutcome& o) {
  archive(o.steps, o.contacts, o.border_edges, o.crossings, o.edge_contacts, o.candidates, o.movers,
          o.depth_fallbacks, o.cuckoo_points, o.cuckoo_edges, o.raised_depths, o.cancelled_directions,
          o.regions_without_border, o.border_edges_without_crossing, o.folded_pairs, o.inverted_tets,
          o.late_steps, o.least_completeness, o.steps_without_prediction, o.solver_iterations,
          o.steps_not_converged, o.steps_divided, o.steps_too_far, o.thinnest, o.largest_forces, o.stages,
          o.outcomes);
}

template <class Archive>
void serialize(Archive& archive, FieldMaximum& m) {
  archive(m.name, m.value, m.step, m.body, m.item, m.of_tets, m.place);
}

template <class Archive>
void serialize(Archive& archive, FramesSoFar& frames) {
  archive(frames.times, frames.last_step, frames.maxima);
}

template <class Archive>
void serialize(Archive& archive, Checkpoint& c) {
  archive(c.plan, c.outcome, c.metrics_bytes, c.forces_bytes, c.frames, c.simulation, c.stages);
}

namespace {

namespace fs = std::filesystem;

constexpr std::string_view folder_name = "checkpoints";
constexpr std::string_view stage_folder_name = "stages";
constexpr std::string_view extension = ".palpate";

std::string file_name(std::int64_t step) {
  return fmt::format("step_{:09}{}", step, extension);
}

/// The files of a folder that have the name of a checkpoint, the latest step first; empty where the folder
/// does not exist.
std::vector<fs::path> checkpoints_in(const fs::path& folder) {
  std::error_code ignored;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("step_") && name.ends_with(extension)) files.push_back(entry.path());
  }
  // Compares lengths first, since steps may have more than nine digits.
  std::ranges::sort(files, [](const fs::path& a, const fs::path& b) {
    const std::string x = a.filename().string();
    const std::string y = b.filename().string();
    return std::pair(x.size(), x) > std::pair(y.size(), y);
  });
  return files;
}

Checkpoint read_archive(const fs::path& path) {
  const std::string bytes = io::read_file(path, "a checkpoint");
  ArchiveReader reader(unsealed(checkpoint_seal, std::as_bytes(std::span(bytes)), path.string()),
                       path.string());
  Checkpoint checkpoint;
  reader(checkpoint);
  reader.finish();
  return checkpoint;
}

Checkpoint read_checkpoint(const fs::path& path) {
  Checkpoint checkpoint = read_archive(path);
  if (path.filename() != file_name(checkpoint.outcome.steps)) {
    throw Error(path.string(), "", fmt::format("a checkpoint of step {}", checkpoint.outcome.steps),
                "a checkpoint of the step in the file name");
  }
  return checkpoint;
}

}  // namespace

CheckpointWriter::CheckpointWriter(const fs::path& results, RunPlan plan,
                                   const std::optional<fs::path>& resumed_from)
    : folder_(results / folder_name),
      stage_folder_(results / stage_folder_name),
      plan_(std::move(plan)),
      last_(resumed_from) {
  if (!resumed_from) remove_but({});
}

void CheckpointWriter::remove_but(const std::vector<fs::path>& kept) const {
  for (const fs::path& path : checkpoints_in(folder_)) {
    if (std::ranges::count(kept, path) > 0) continue;
    std::error_code failed;
    fs::remove(path, failed);
    if (failed)
      throw Error(path.string(), "removing", "'" + failed.message() + "'", "a file that can be removed");
  }
}

void CheckpointWriter::write(const fs::path& path, const Simulation& simulation, const RunOutcome& outcome,
                             const RunOutputs& outputs) const {
  outputs.metrics.sync();
  outputs.forces.sync();
  Checkpoint checkpoint{.plan = plan_,
                        .outcome = outcome,
                        .metrics_bytes = outputs.metrics.bytes(),
                        .forces_bytes = outputs.forces.bytes(),
                        .frames = outputs.frames.so_far(),
                        .simulation = simulation.save(),
                        .stages = outputs.stages.progress()};
  ArchiveWriter writer;
  writer(checkpoint);
  const std::vector<std::byte> bytes = sealed(checkpoint_seal, writer.take());
  // Creates only the folder of checkpoints. If the folder of results is gone, a new one with nothing but a
  // checkpoint would look like a run that can be resumed.
  std::error_code failed;
  fs::create_directory(path.parent_path(), failed);
  if (failed) {
    throw Error(path.parent_path().string(), "making", "'" + failed.message() + "'",
                "a folder of results that is still there");
  }
  io::AtomicFile file(path);
  file.write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  file.sync();
  file.commit();
}

void CheckpointWriter::keep_stage(const std::string& name, const Simulation& simulation,
                                  const RunOutcome& outcome, const RunOutputs& outputs) const {
  write(stage_folder_ / (name + std::string(extension)), simulation, outcome, outputs);
}

void CheckpointWriter::add(const Simulation& simulation, const RunOutcome& outcome, const RunOutputs& outputs,
                           bool always) {
  const std::int64_t step = outcome.steps;
  const bool due = regular() && step % plan_.checkpoint_every == 0 && step > 0;
  if (step == last_step_ || (!due && !always)) return;
  const fs::path path = folder_ / file_name(step);
  write(path, simulation, outcome, outputs);
  // A resumed run that has no steps left writes its own checkpoint again.
  if (last_ != path) remove_but({path, last_.value_or(path)});
  last_ = path;
  last_step_ = step;
}

bool has_checkpoints(const fs::path& results) {
  return !checkpoints_in(results / folder_name).empty();
}

FoundCheckpoint find_stage(const fs::path& results, const std::string& stage) {
  const fs::path folder = results / stage_folder_name;
  FoundCheckpoint found{.path = folder / (stage + std::string(extension)), .checkpoint = {}, .damaged = {}};
  std::error_code ignored;
  if (fs::exists(found.path, ignored)) {
    as_input([&] {
      found.checkpoint = read_archive(found.path);
      return 0;
    });
    return found;
  }
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (entry.path().extension() == extension) names.push_back(entry.path().stem().string());
  std::ranges::sort(names);
  throw BadInput(folder.string(), "", fmt::format("no saved state at the end of stage '{}'", stage),
                 names.empty()
                     ? std::string("the results of a run that saved one (\"checkpoint\": true in the stage)")
                     : fmt::format("one of {}", fmt::join(names, ", ")));
}

FoundCheckpoint find_checkpoint(const fs::path& results) {
  const std::vector<fs::path> files = checkpoints_in(results / folder_name);
  if (files.empty()) {
    throw BadInput((results / folder_name).string(), "", "no checkpoint",
                   "the folder of results of a run that was interrupted, or run with --checkpoint-every");
  }
  FoundCheckpoint found;
  for (const fs::path& path : files) {
    try {
      found.checkpoint = read_checkpoint(path);
      found.path = path;
      return found;
    } catch (const Error& error) {
      found.damaged.emplace_back(error.what());
    }
  }
  throw BadInput(
      found.damaged.front() +
      (files.size() > 1 ? fmt::format(" (all {} checkpoints of the folder are damaged)", files.size()) : ""));
}

}  // namespace palpate::app
