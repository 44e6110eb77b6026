#include "scene/stage_run.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "number_text.hpp"
#include "scene/json_text.hpp"
#include "scene/pair_force.hpp"
#include "scene/selector.hpp"

namespace palpate {
namespace {

/// The number of steps in a duration. A duration of 50 steps gives 50 steps, even if the quotient is rounded.
std::int64_t steps_in(const Scene& scene, std::size_t stage) {
  constexpr double rounding = 1e-9;
  constexpr double most = 1e15;
  const double steps =
      std::ceil(scene.stages[stage].until.limit() / scene.settings.time_step * (1.0 - rounding));
  if (!(steps < most)) {
    throw Error(scene.source, element_path("stages", stage) + ".until",
                number_text(steps) + " steps of time_step", "at most 1e15");
  }
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(steps));
}

}  // namespace

std::int64_t most_steps_of_stages(const Scene& scene) {
  std::int64_t sum = 0;
  for (std::size_t stage = 0; stage < scene.stages.size(); ++stage) sum += steps_in(scene, stage);
  return sum;
}

StageRun::StageRun(const Scene& scene, const Simulation& simulation)
    : source_(scene.source),
      time_unit_(scene.units.time),
      length_unit_(scene.units.length),
      stages_(scene.stages),
      changes_(scene, simulation.bodies()),
      placed_(scene, simulation.bodies()) {
  for (const Body& body : simulation.bodies().bodies()) body_names_.push_back(body.name);
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    most_steps_.push_back(steps_in(scene, i));
    const auto& force = stages_[i].until.force;
    const std::string path = element_path("stages", i) + ".until.force";
    force_on_.push_back(force ? body_named(scene, force->body, path, -1) : -1);
    force_from_.push_back(force && force->from ? body_named(scene, *force->from, path, -1) : -1);
  }
}

const Stage& StageRun::stage() const {
  return stages_[std::min(progress_.endings.size(), stages_.size() - 1)];
}

std::int64_t StageRun::first_step() const {
  return progress_.endings.empty() ? 0 : progress_.endings.back().step;
}

void StageRun::set_gravity(Simulation& simulation, std::size_t stage) const {
  SimulationSettings settings = simulation.settings();
  if (settings.gravity == changes_.gravity(stage)) return;
  settings.gravity = changes_.gravity(stage);
  simulation.change(settings);
}

std::optional<ModelChange> StageRun::begin(Simulation& simulation) {
  if (done() || progress_.begun) return std::nullopt;
  const std::size_t stage = progress_.endings.size();
  const std::vector<Tie> ties = simulation.ties();
  ModelChange change =
      changes_.at_start(stage, simulation.bodies(), simulation.positions(), ties, simulation.metrics().time);
  simulation.change(change);
  set_gravity(simulation, stage);
  progress_.begun = true;
  return change;
}

bool StageRun::reached(const Simulation& simulation) const {
  const std::size_t stage = progress_.endings.size();
  const StageEnd& until = stages_[stage].until;
  if (until.rest) return simulation.at_rest();
  if (!until.force) return simulation.metrics().step - first_step() >= most_steps_[stage];
  const Index on = force_on_[stage];
  const Index from = force_from_[stage];
  const Vec3 force = from < 0 ? at(simulation.contact_forces(), on) : force_by(simulation, on, from);
  return length(force) >= until.force->at_least;
}

bool StageRun::ends(const Simulation& simulation) {
  if (done()) return false;
  const std::int64_t step = simulation.metrics().step;
  const bool met = reached(simulation);
  if (!met && step - first_step() < most_steps_[progress_.endings.size()]) return false;
  progress_.endings.push_back({step, met, placed_.find(simulation)});
  progress_.begun = false;
  return true;
}

void StageRun::resume(Simulation& simulation, StageProgress progress) {
  if (progress.endings.size() > stages_.size()) {
    throw Error(source_, "stages", std::to_string(stages_.size()) + " of them",
                std::to_string(progress.endings.size()) + " or more, as the state has");
  }
  progress_ = std::move(progress);
  const std::size_t running = progress_.endings.size() + (progress_.begun ? 1U : 0U);
  if (running > 0) set_gravity(simulation, running - 1);
}

std::vector<std::string> StageRun::warnings() const {
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < progress_.endings.size(); ++i) {
    const StageEnding& ending = progress_.endings[i];
    const std::string stage = "stage '" + stages_[i].name + "'";
    const StageEnd& until = stages_[i].until;
    if (!ending.reached) {
      texts.push_back(stage + " ended after " + number_text(until.limit()) + " " + time_unit_ +
                      (until.rest ? ", not at rest" : ", its force not reached"));
    }
    for (const PlacedOverlap& overlap : ending.overlaps) {
      texts.push_back(stage + " puts '" + at(body_names_, overlap.placed) + "' into '" +
                      at(body_names_, overlap.other) + "', by " + short_number_text(overlap.deepest) + " " +
                      length_unit_ + " at its end");
    }
  }
  return texts;
}

}  // namespace palpate
