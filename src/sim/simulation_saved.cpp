#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "contact/detector_steps.hpp"
#include "sim/simulation_state.hpp"

// The state of a simulation as bytes.
namespace palpate {

SavedState Simulation::State::saved_state() const {
  return {.fingerprint = core->fingerprint,
          .settings = bytes_of(settings),
          .metrics = metrics,
          .last_length = last_length,
          .slow_steps = slow_steps,
          .forces = loads.all().forces,
          .pressures = loads.all().pressures,
          .grabs = grabs.all(),
          .motions = {prescribed.motions().begin(), prescribed.motions().end()},
          .dynamics = dynamics.state(),
          .contacts = DetectorSteps::table(detector).history(),
          .kept_contacts = response.kept(),
          .edge_ends = response.edge_ends(),
          .detector = detector.memory(),
          .contact_forces = contact_forces,
          .acting_contacts = step_forces.contacts(),
          .tie_forces = step_forces.ties(),
          .records_reactions = records_reactions,
          .reactions = reactions,
          .changed = changed_model()};
}

void Simulation::State::copy_state(const SavedState& saved) {
  activate_fibres(saved.metrics.time);
  dynamics.set_state(saved.dynamics);
  detector.recall(saved.detector, dynamics.positions());
  loads.restore(saved.forces, saved.pressures);
  grabs.set_all(saved.grabs);
  DetectorSteps::table(detector).set_history(saved.contacts);
  prescribed.set_motions(saved.motions);
  response.set_kept(saved.kept_contacts);
  response.set_edge_ends(saved.edge_ends);
  contact_forces = saved.contact_forces;
  step_forces.set(saved.acting_contacts, saved.tie_forces);
  if (saved.records_reactions) dynamics.find_constrained_elements();
  records_reactions = saved.records_reactions;
  reactions = saved.reactions;
  set_metrics(saved.metrics);
  last_length = saved.last_length;
  metrics.time = static_cast<double>(metrics.step) * settings.time_step;
  metrics.inverted_tets = dynamics.inverted_elements();
  slow_steps = saved.slow_steps;
}

std::optional<ChangedModel> Simulation::State::changed_model() const {
  if (!changed) return std::nullopt;
  return ChangedModel{holds, loads.all().points, loads.all().surfaces};
}

std::unique_ptr<Simulation::State> Simulation::State::held_as(const SavedState& saved) const {
  if (!changed && !saved.changed) return nullptr;
  HeldModel held{.holds = core->held.holds, .motions = saved.motions};
  LoadSet set = core->loads;
  if (saved.changed) {
    held.holds = saved.changed->holds;
    set.points = saved.changed->point_loads;
    set.surfaces = saved.changed->surface_loads;
  }
  auto state = std::make_unique<State>(core, std::move(held), std::move(set), settings, threads.count());
  state->changed = saved.changed.has_value();
  return state;
}

std::vector<std::byte> Simulation::save() const {
  SavedState saved = state_->saved_state();
  ArchiveWriter writer;
  writer(saved);
  return sealed(state_seal, writer.take());
}

void Simulation::restore(std::span<const std::byte> bytes) {
  State& s = *state_;
  SavedState saved;
  ArchiveReader reader(unsealed(state_seal, bytes, "saved state"), "saved state");
  reader(saved);
  reader.finish();
  for (std::size_t i = 0; i < Fingerprint::names.size(); ++i) {
    if (saved.fingerprint.hashes[i] != s.core->fingerprint.hashes[i]) {
      throw Error("saved state", std::string(Fingerprint::names[i]), "values of another simulation",
                  "the same model and settings as when the state was saved");
    }
  }
  check_saved(saved, s.bodies);
  const std::size_t ties = saved.changed ? saved.changed->holds.ties.size() : s.core->held.holds.ties.size();
  if (saved.tie_forces.size() != ties) {
    throw Error("saved state", "tie_forces", std::to_string(saved.tie_forces.size()) + " values",
                std::to_string(ties));
  }
  const SavedState before = s.saved_state();
  try {
    if (saved.settings != before.settings) change(with_bytes(s.settings, saved.settings));
    std::unique_ptr<State> other = s.held_as(saved);
    if (other) {
      other->copy_state(saved);
      state_ = std::move(other);
    } else {
      s.copy_state(saved);
    }
  } catch (...) {
    if (saved.settings != before.settings) change(with_bytes(s.settings, before.settings));
    s.copy_state(before);
    throw;
  }
}

}  // namespace palpate
