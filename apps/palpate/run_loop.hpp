#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <palpate/simulation.hpp>

#include "body_forces.hpp"
#include "forces_file.hpp"
#include "frame_writer.hpp"
#include "interrupt.hpp"
#include "metrics_file.hpp"
#include "phase_times.hpp"
#include "progress.hpp"
#include "scene/outcome_probe.hpp"
#include "scene/stage_run.hpp"

namespace palpate::app {

/// A count: at the last step, its largest value with the step, and its sum over all steps.
struct Tally {
  std::size_t last = 0;
  std::size_t largest = 0;
  std::size_t total = 0;
  void add(std::size_t count);
};

/// Counts of a cuckoo table over a run.
struct CuckooRun {
  CuckooCounts last;  ///< counts of the last step
  double lowest_occupancy = 1.0;
  double highest_occupancy = 0.0;
  Tally bucket_retries;
  Tally redistributions;
  Tally growths;
  void add(const CuckooCounts& counts);
};

/// A completed stage.
struct StageRecord {
  std::string name;
  std::int64_t first_step = 0;
  std::int64_t last_step = 0;
  double time = 0.0;    ///< at the end of the stage
  bool reached = true;  ///< whether its condition was met
  std::int64_t steps_not_converged = 0;
  std::size_t inverted_tets = 0;       ///< at the end of the stage
  std::vector<OutcomeValue> outcomes;  ///< at the end of the stage
  std::string state_hash;
  std::vector<PlacedOverlap> overlaps{};  ///< at the end of the stage
};

/// What happened in a run.
struct RunOutcome {
  std::int64_t steps = 0;
  bool at_rest = false;
  bool interrupted = false;
  std::string failure;  ///< why the simulation stopped, or no picture was drawn; empty if all went well
  PhaseTimes times;
  Tally contacts;
  Tally border_edges;
  Tally crossings;
  Tally edge_contacts;
  Tally candidates;
  Tally movers;
  Tally depth_fallbacks;
  CuckooRun cuckoo_points;
  CuckooRun cuckoo_edges;
  Tally raised_depths;
  Tally cancelled_directions;
  Tally regions_without_border;
  Tally border_edges_without_crossing;
  Tally folded_pairs;
  Tally inverted_tets;
  std::int64_t late_steps = 0;  ///< steps in which the budget was too small for all clusters
  double least_completeness = 1.0;
  std::int64_t steps_without_prediction = 0;
  std::int64_t solver_iterations = 0;
  std::int64_t steps_not_converged = 0;  ///< steps with a solve that ended above the tolerance
  std::int64_t steps_divided = 0;        ///< steps that were divided into substeps
  /// Steps in which something may have passed through a body: points that ended on the wrong side or,
  /// without continuous detection or without all contacts, could have.
  std::int64_t steps_too_far = 0;
  double thinnest = 0.0;                       ///< least local thickness of bodies in these steps; 0: none
  std::vector<LargestForce> largest_forces{};  ///< (n_bodies) of contacts
  std::vector<StageRecord> stages{};           ///< completed stages
  std::vector<OutcomeValue> outcomes{};        ///< at the last step
};

class CheckpointWriter;

/// Where the outputs of a run go: files, and functions that are called at certain steps.
struct RunOutputs {
  FrameWriter& frames;
  MetricsFile& metrics;
  ForcesFile& forces;
  const ForceProbe& probe;
  CheckpointWriter& checkpoints;
  Progress& progress;
  StageRun& stages;
  const OutcomeProbe& outcomes;
  /// Called when a stage has ended, before the next one begins.
  std::function<void(const StageRecord&, const RunOutcome&)> at_stage_end;
};

/// Makes steps until all stages are complete, or until `most_steps`, rest (if asked for), an interrupt, or a
/// failure of the simulation. Writes a row for each step, the frames and checkpoints that are due, always the
/// first and the last state, and a checkpoint at an interrupt. Throws Error if they cannot be written.
/// \param before  outcome of the run that is resumed; empty for a new run
RunOutcome run_loop(Simulation& simulation, std::int64_t most_steps, bool until_rest,
                    const InterruptFlag& interrupt, const RunOutputs& outputs,
                    const std::optional<RunOutcome>& before);

}  // namespace palpate::app
