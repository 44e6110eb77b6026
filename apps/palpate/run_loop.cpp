#include "run_loop.hpp"

#include <algorithm>
#include <limits>

#include <palpate/error.hpp>

#include "checkpoint.hpp"
#include "geometry/vector.hpp"
#include "sim/unseen_passes.hpp"
#include "stopwatch.hpp"

namespace palpate::app {
namespace {

void count(RunOutcome& outcome, const StepMetrics& m, ContinuousDetection continuous) {
  outcome.steps = m.step;
  outcome.contacts.add(m.detection.contacts);
  outcome.border_edges.add(m.detection.border_edges);
  outcome.crossings.add(m.detection.crossings);
  outcome.edge_contacts.add(m.detection.edge_contacts);
  outcome.candidates.add(m.detection.candidates);
  outcome.movers.add(m.detection.movers);
  outcome.depth_fallbacks.add(m.detection.depth_fallbacks);
  if (m.detection.cuckoo_points) outcome.cuckoo_points.add(*m.detection.cuckoo_points);
  if (m.detection.cuckoo_edges) outcome.cuckoo_edges.add(*m.detection.cuckoo_edges);
  outcome.raised_depths.add(m.detection.raised_depths);
  outcome.cancelled_directions.add(m.detection.cancelled_directions);
  outcome.regions_without_border.add(m.detection.regions_without_border);
  outcome.border_edges_without_crossing.add(m.detection.border_edges_without_crossing);
  outcome.folded_pairs.add(m.detection.folded_pairs);
  outcome.inverted_tets.add(static_cast<std::size_t>(m.inverted_tets));
  outcome.late_steps += m.detection.late_clusters > 0 ? 1 : 0;
  outcome.least_completeness = std::min(outcome.least_completeness, m.detection.completeness);
  outcome.steps_without_prediction += m.looks_ahead ? 0 : 1;
  outcome.solver_iterations += m.solver_iterations;
  outcome.steps_not_converged += m.solver_converged ? 0 : 1;
  outcome.steps_divided += m.substeps > 1 ? 1 : 0;
  if (may_have_passed(m, continuous)) {
    outcome.thinnest = thinner(outcome.thinnest, m.thinnest);
    ++outcome.steps_too_far;
  }
}

/// Writes a row of metrics and a row of forces, and updates the largest forces.
void add_rows(const Simulation& simulation, double seconds, RunOutcome& outcome, const RunOutputs& outputs) {
  const ForcesOfStep forces = outputs.probe.forces(simulation);
  outcome.outcomes = outputs.outcomes.values(simulation);
  outputs.metrics.add(simulation.metrics(), forces, outcome.outcomes, seconds);
  outputs.forces.add(simulation, forces);
  outcome.largest_forces.resize(forces.bodies.size());
  for (std::size_t b = 0; b < forces.bodies.size(); ++b) {
    const double force = length(forces.bodies[b].contact.force);
    if (force > outcome.largest_forces[b].force)
      outcome.largest_forces[b] = {force, simulation.metrics().step};
  }
}

/// Makes one step; false where the simulation failed.
bool step(Simulation& simulation, RunOutcome& outcome, const RunOutputs& outputs) {
  Stopwatch watch;
  try {
    simulation.step();
  } catch (const Error& error) {
    outcome.failure = error.what();
    return false;
  }
  const double seconds = watch.lap();
  outcome.times.add(simulation.metrics(), seconds);
  count(outcome, simulation.metrics(), simulation.settings().detection.continuous);
  add_rows(simulation, seconds, outcome, outputs);
  return true;
}

/// Records a stage that ended with this step, and keeps its end.
void end_stage(const Simulation& simulation, RunOutcome& outcome, const RunOutputs& outputs,
               const std::string& name, bool keep) {
  const StageEnding& ending = outputs.stages.progress().endings.back();
  std::int64_t not_converged = outcome.steps_not_converged;
  for (const StageRecord& before : outcome.stages) not_converged -= before.steps_not_converged;
  outcome.stages.push_back({.name = name,
                            .first_step = outcome.stages.empty() ? 0 : outcome.stages.back().last_step,
                            .last_step = ending.step,
                            .time = simulation.metrics().time,
                            .reached = ending.reached,
                            .steps_not_converged = not_converged,
                            .inverted_tets = static_cast<std::size_t>(simulation.metrics().inverted_tets),
                            .outcomes = outcome.outcomes,
                            .state_hash = simulation.state_hash(),
                            .overlaps = ending.overlaps});
  outputs.frames.add(simulation, true);
  if (keep) outputs.checkpoints.keep_stage(name, simulation, outcome, outputs);
  outputs.at_stage_end(outcome.stages.back(), outcome);
}

/// Begins the next stage if it is due; false where the simulation refuses it.
bool begin_stage(Simulation& simulation, RunOutcome& outcome, StageRun& stages) {
  try {
    stages.begin(simulation);
  } catch (const Error& error) {
    outcome.failure = "stage '" + stages.stage().name + "': " + error.what();
    return false;
  }
  return true;
}

}  // namespace

void Tally::add(std::size_t count) {
  last = count;
  largest = std::max(largest, count);
  total += count;
}

void CuckooRun::add(const CuckooCounts& counts) {
  last = counts;
  lowest_occupancy = std::min(lowest_occupancy, counts.occupancy());
  highest_occupancy = std::max(highest_occupancy, counts.occupancy());
  bucket_retries.add(counts.bucket_retries);
  redistributions.add(counts.redistributions);
  growths.add(counts.growths);
}

RunOutcome run_loop(Simulation& simulation, std::int64_t most_steps, bool until_rest,
                    const InterruptFlag& interrupt, const RunOutputs& outputs,
                    const std::optional<RunOutcome>& before) {
  const auto& [frames, metrics, forces, probe, checkpoints, progress, stages, values, at_stage_end] = outputs;
  RunOutcome outcome = before.value_or(RunOutcome{});
  const bool staged = stages.any();
  bool goes = begin_stage(simulation, outcome, stages);
  if (!before) {
    count(outcome, simulation.metrics(), simulation.settings().detection.continuous);
    add_rows(simulation, 0.0, outcome, outputs);
    frames.add(simulation, true);
  }
  while (goes && outcome.steps < most_steps && !(until_rest && simulation.at_rest()) &&
         !(staged && stages.done())) {
    if (interrupt.requested() || !step(simulation, outcome, outputs)) break;
    frames.add(simulation);
    const Stage stage = staged ? stages.stage() : Stage{};
    if (stages.ends(simulation)) {
      end_stage(simulation, outcome, outputs, stage.name, stage.checkpoint);
      goes = begin_stage(simulation, outcome, stages);
    }
    checkpoints.add(simulation, outcome, outputs);
    progress.update(simulation.metrics());
  }
  outcome.interrupted = interrupt.requested();
  // Written before the last frame, since a resumed run continues without that frame. A checkpoint at the end
  // allows the run to be extended.
  const bool ends_well = outcome.failure.empty() && checkpoints.regular();
  checkpoints.add(simulation, outcome, outputs, outcome.interrupted || ends_well);
  metrics.flush();
  forces.flush();
  outcome.at_rest = outcome.failure.empty() && simulation.at_rest();
  frames.add(simulation, true);  // after a failure: the last good state
  if (outcome.failure.empty()) progress.finish(simulation.metrics());
  return outcome;
}

}  // namespace palpate::app
