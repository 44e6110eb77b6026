#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <palpate/simulation.hpp>

#include "fem/dynamics.hpp"
#include "fem/matrix.hpp"
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

/// The part of a simulation that never changes, and its initial constraints and loads.
struct SimulationCore {
  /// Moves the data out of a model. Throws Error as Simulation does.
  SimulationCore(Model model, const SimulationSettings& settings, const parallel::Threads& threads);
  Fingerprint fingerprint;  ///< declared first, because the model is moved from later
  HeldModel held;           ///< at the start; declared before `bodies`, since both are made from the model
  LoadSet loads;            ///< at the start
  Bodies bodies;
  Materials materials;
};

/// The implementation of Simulation. Its constraints (Holds) are fixed: a ModelChange makes another State,
/// which copies positions, velocities and the states of contacts. Functions are in simulation.cpp,
/// simulation_step.cpp and simulation_substeps.cpp (the step), simulation_drive.cpp (changes between steps),
/// simulation_change.cpp (ModelChange), simulation_saved.cpp (save and restore) and simulation_forces.cpp
/// (forces and stress).
struct Simulation::State {
  /// A simulation at its start: points are at rest, and prescribed ones where their motion is at time 0.
  /// There are no contacts yet.
  State(std::shared_ptr<const SimulationCore> core, HeldModel held, LoadSet loads,
        const SimulationSettings& settings, int threads);
  /// Sets the first velocities and grabs, and detects the first contacts.
  void start(const std::vector<Vec3>& velocities, const std::vector<Grab>& grabs);
  /// Copies another state, whose constraints may differ.
  void copy_from(const State& from);

  void detect(std::span<const Vec3> positions, bool last);
  [[nodiscard]] bool spends_time() const;
  [[nodiscard]] double budget_seconds() const;
  [[nodiscard]] double budget_left() const;
  [[nodiscard]] bool can_predict() const;
  void measure();
  /// See StepMetrics::deepest. O(contacts log pairs of bodies).
  [[nodiscard]] double deepest();
  /// Length of the implicit Euler step that is solved, s; shorter than the substep with BDF2.
  [[nodiscard]] double step_length() const { return dynamics.step_length(substep.length); }
  void set_end();
  void reset_counts();
  void begin_step();
  void activate_fibres(double time);
  bool solve(double tolerance, bool loose, bool steady);
  [[nodiscard]] fem::ContactSet contact_set();
  [[nodiscard]] double normal_forces() const;
  /// The end of the current step as its last solve predicts it.
  [[nodiscard]] PredictedStep predicted() const;
  [[nodiscard]] int most_solves(bool stops_passes) const;
  [[nodiscard]] bool stops_fail() const;
  [[nodiscard]] bool sweeps() const;
  [[nodiscard]] double most_speed_of_stops() const;
  [[nodiscard]] bool is_limited(std::int64_t passes) const;
  bool stop_passes();
  void count_passes();
  /// What the loop of solves and detections of a substep goes by, besides the metrics of the step or substep
  /// before (`last`). The metrics of the current one only tell of it.
  struct Progress {
    int solves = 0;        ///< in the substep, with those of an attempt with BDF2
    bool may_stop = true;  ///< what would pass may be stopped
    std::int64_t stopped_passes = 0;
    std::int64_t iterations_with_stops = 0;  ///< of the solver in the substep, since something was stopped
    std::int64_t passes = 0;                 ///< that the last search has left
    double most_speed = 0.0;                 ///< of a point where passes are stopped, m/s
    std::int64_t least_stops = 0;            ///< in one search of the substep
    int failed_searches = 0;                 ///< since then, searches that found as many or more
    double detection_seconds = 0.0;          ///< of the time budget, in the substep
    bool complete = true;                    ///< the last detection found all contacts
    bool searched = false;  ///< the substep began with a detection of its own, in rotated frames
    bool computed = false;  ///< the contacts of the substep have been computed
  };
  /// How a solution came about.
  struct Solution {
    bool converged = false;
    std::int64_t speculative_contacts = 0;
  };
  Solution solve_with_speculative_contacts(const StepMetrics& last);
  [[nodiscard]] bool rotates_in_contact() const;
  void find_places();
  [[nodiscard]] bool places_are_shallow() const;
  [[nodiscard]] bool rotates(Index body) const;
  [[nodiscard]] std::span<const Vec3> find_contacts();
  Solution solve_step(const StepMetrics& last);
  void set_metrics(const StepMetrics& of);
  void undo_step(bool detected);
  bool solve_second_order(const StepMetrics& last);
  void advance();
  [[nodiscard]] double shortest_substep() const;
  /// Whether the substep may be divided.
  [[nodiscard]] bool may_divide() const { return 0.5 * substep.length >= shortest_substep(); }
  bool solve_substep(const StepMetrics& last, bool may_divide);
  bool try_substep(const StepMetrics& last, bool may_divide);
  void undo_substep();
  StepMetrics divide(StepMetrics last, StepMetrics& sum);
  void finish_substep();
  void collect_forces();
  [[nodiscard]] SavedState saved_state() const;
  /// The constraints and loads if a ModelChange has changed them; else empty.
  [[nodiscard]] std::optional<ChangedModel> changed_model() const;
  /// A new state with the constraints of a saved one; null if this state has the same constraints.
  [[nodiscard]] std::unique_ptr<State> held_as(const SavedState& saved) const;
  void copy_state(const SavedState& saved);
  /// Time from which on no motion, load or activation is given that changes, s.
  [[nodiscard]] double last_change() const;

  std::shared_ptr<const SimulationCore> core;
  const Bodies& bodies;
  const Materials& materials;
  Holds holds;
  bool changed = false;                 ///< constraints or loads differ from those of the model
  std::vector<std::uint8_t> obstacles;  ///< (n_bodies) 1: rigid or absent
  SimulationSettings settings;
  parallel::Threads threads;
  std::vector<double> activations;  ///< activation of the fibres of each material
  PrescribedMotions prescribed;
  fem::Dynamics dynamics;
  Loads loads;
  fem::ExternalForces step_loads;  ///< forces on points of the step
  Grabs grabs;
  Detector detector;
  std::vector<Material> contact_materials;
  ContactResponse response;
  SweptResponse swept;
  Ties ties;
  std::vector<fem::Coupling> couplings;  ///< of grabs, held axes, ties, then contacts
  std::size_t grab_couplings = 0;
  std::size_t first_tie = 0;      ///< index of the first tie in `couplings`
  std::size_t first_contact = 0;  ///< index of the first contact in `couplings`
  /// Contacts of a body, for find_places().
  struct Touched {
    fem::Matrix3 directions;  ///< sum of r r^T over its contacts
    Vec3 deeper;              ///< sum of r (r d), with the displacement d by the frame at the contact, m
  };
  std::vector<Touched> touched;       ///< (n_bodies) scratch
  std::vector<Vec3> places;           ///< (n_points x 3) scratch of find_places(), m
  std::size_t first_speculative = 0;  ///< index of the first speculative contact in `couplings`
  StepForces step_forces;
  bool records_reactions = false;
  std::vector<Vec3> reactions;  ///< (n_points) of the last step, N; or empty
  bool records_path = false;
  std::vector<std::vector<Vec3>> path;  ///< see SimulationPath
  double max_speed;
  std::vector<std::pair<Index, Index>> touching;  ///< scratch of deepest()
  std::vector<Vec3> contact_forces;
  std::vector<double> masses;
  std::vector<double> squared_speeds;  ///< per body: sum of m v^2
  /// A part of a time step that is solved as one step: all of it, unless that did not converge.
  struct Substep {
    double end = 0.0;     ///< time at its end, s
    double length = 0.0;  ///< s
  };
  Substep substep;
  double last_length;  ///< of the last substep, s; the time step before the first
  Progress progress;
  StepMetrics metrics;
  std::int64_t slow_steps = 0;  ///< consecutive steps in which no body was faster than the rest speed
};

}  // namespace palpate
