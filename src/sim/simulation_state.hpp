#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <palpate/simulation.hpp>

#include "fem/dynamics.hpp"
#include "parallel/parallel.hpp"
#include "sim/grabs.hpp"
#include "sim/holds.hpp"
#include "sim/loads.hpp"
#include "sim/prescribed_motions.hpp"
#include "sim/response.hpp"
#include "sim/saved_state.hpp"
#include "sim/step_forces.hpp"
#include "sim/swept_response.hpp"
#include "sim/ties.hpp"

namespace palpate {

/// What of a simulation never changes, and what it begins with.
struct SimulationCore {
  /// Takes the bodies, materials and all that may change of a model. Throws Error as Simulation does.
  SimulationCore(Model model, const SimulationSettings& settings, const parallel::Threads& threads);
  Fingerprint fingerprint;  ///< of the model while it is whole
  HeldModel held;           ///< at the start; before `bodies`: made of the model while it is whole
  LoadSet loads;            ///< at the start
  Bodies bodies;
  Materials materials;
};

/// What a Simulation consists of. What holds it (Holds) is there for the life of a State: a ModelChange makes
/// another State, which copies positions, velocities and the states of contacts. Its functions are in
/// simulation.cpp (the step), simulation_drive.cpp (what changes it between steps), simulation_change.cpp
/// (another State), simulation_saved.cpp (save and restore) and simulation_forces.cpp (what it tells of
/// forces and stress).
struct Simulation::State {
  /// Points are at rest, prescribed ones where their motion is at time 0; without contacts as yet.
  State(std::shared_ptr<const SimulationCore> core, HeldModel held, LoadSet loads,
        const SimulationSettings& settings, int threads);
  /// The first positions, velocities and contacts.
  void start(const std::vector<Vec3>& velocities, const std::vector<Grab>& grabs);
  /// A simulation that goes on from another with other holds.
  void copy_from(const State& from);

  void detect(std::span<const Vec3> positions, bool last);
  [[nodiscard]] bool spends_time() const;
  [[nodiscard]] double budget_seconds() const;
  [[nodiscard]] double budget_left() const;
  [[nodiscard]] bool can_predict() const;
  void measure();
  /// See StepMetrics::deepest. O(contacts log pairs of bodies).
  [[nodiscard]] double deepest();
  void begin_step();
  void activate_fibres(double time);
  bool solve(bool loose, bool steady);
  [[nodiscard]] fem::ContactSet contact_set();
  [[nodiscard]] double normal_forces() const;
  /// The prediction of a step so far.
  [[nodiscard]] PredictedStep predicted() const;
  [[nodiscard]] int most_solves(bool stops_passes) const;
  bool stop_passes();
  void count_passes();
  void solve_with_speculative_contacts(const StepMetrics& last);
  void advance();
  void collect_forces();
  [[nodiscard]] SavedState saved_state() const;
  /// What a ModelChange has changed; none without one.
  [[nodiscard]] std::optional<ChangedModel> changed_model() const;
  /// A state with the holds of a saved one, to take it; null where this one has them.
  [[nodiscard]] std::unique_ptr<State> held_as(const SavedState& saved) const;
  void copy_state(const SavedState& saved);

  std::shared_ptr<const SimulationCore> core;
  const Bodies& bodies;
  const Materials& materials;
  Holds holds;
  bool changed = false;                 ///< these, or the loads, are not those that the simulation began with
  std::vector<std::uint8_t> obstacles;  ///< (n_bodies) with absent ones
  SimulationSettings settings;
  parallel::Threads threads;
  std::vector<double> activations;  ///< of the fibres of each material
  PrescribedMotions prescribed;
  fem::Dynamics dynamics;
  Loads loads;
  std::span<const Vec3> step_loads;  ///< forces on points of the step, N; or empty
  Grabs grabs;
  Detector detector;
  std::vector<Material> contact_materials;
  ContactResponse response;
  SweptResponse swept;
  Ties ties;
  std::vector<fem::Coupling> couplings;  ///< of grabs, held axes, ties, then contacts
  std::size_t grab_couplings = 0;
  std::size_t first_tie = 0;          ///< in the couplings
  std::size_t first_contact = 0;      ///< in the couplings
  std::size_t first_speculative = 0;  ///< contact, in the couplings
  StepForces step_forces;
  bool records_reactions = false;
  std::vector<Vec3> reactions;  ///< (n_points) of the last step, N; or empty
  double max_speed;
  std::vector<std::pair<Index, Index>> touching;  ///< scratch of deepest()
  std::vector<Vec3> contact_forces;
  std::vector<double> masses;
  std::vector<double> squared_speeds;  ///< per body: sum of m v^2
  StepMetrics metrics;
  std::int64_t slow_steps = 0;  ///< steps in a row in which no body was faster than the rest speed
};

}  // namespace palpate
