#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <palpate/relax.hpp>
#include <palpate/simulation.hpp>

#include "crossings.hpp"
#include "model.hpp"
#include "one_thread.hpp"
#include "scene/outcome_probe.hpp"
#include "scene/scene.hpp"
#include "scene/stage_run.hpp"

namespace palpate::python {

/// A palpate::Simulation for several Python threads: a second one inside is refused.
class Simulation {
 public:
  /// Removes overlaps first if the scene asks for it. Releases Python's lock.
  Simulation(const Model& model, const Scene& scene, int threads);

  /// Makes a step; begins the next stage of the scene first, if it is due.
  void step();
  /// Changes constraints, ties and loads from now on.
  void change(const ModelChange& change);
  /// Adds a motion of these points from their current positions; returns its number.
  Index move(std::vector<Index> points, Motion motion);
  /// Ties points to the nearest tets of another body, at their current positions.
  void tie(const std::vector<Index>& points, Index to, std::optional<double> stiffness);
  /// Cuts all ties between two bodies; returns their number.
  Index untie(Index a, Index b);
  [[nodiscard]] const StageRun& stages() const { return *stages_; }
  [[nodiscard]] const OutcomeProbe& outcomes() const { return *outcomes_; }
  /// The outcomes at the ends of the stages that are over.
  [[nodiscard]] const std::vector<std::vector<OutcomeValue>>& stage_outcomes() const {
    return stage_outcomes_;
  }
  /// The saved state, including the progress through stages if there are any.
  std::vector<std::byte> save();
  void restore(std::span<const std::byte> saved);
  /// The report on the removal of overlaps; None if the scene did not ask for it.
  [[nodiscard]] const std::optional<RelaxReport>& relaxed() const { return relaxed_; }
  /// Steps of this object in which a solve ended above the tolerance.
  [[nodiscard]] std::int64_t steps_not_converged() const { return steps_not_converged_; }
  [[nodiscard]] std::int64_t steps_too_far() const { return steps_too_far_; }
  /// Largest StepMetrics::inverted_tets after a step of this object.
  [[nodiscard]] std::int64_t most_inverted_tets() const { return most_inverted_tets_; }
  /// The contacts at the current positions. Later steps do not change the result.
  std::shared_ptr<const Contacts> contacts();
  /// Crossings of border edges at the current positions.
  std::shared_ptr<const Crossings> crossings();
  /// Surface edges that pass through a body with both ends outside, at the current positions. A copy.
  EdgeContacts edge_contacts();

  /// The contacts of the last step with their forces, weights in the order of corners of the given mesh.
  ContactForces acting_contacts();
  /// Strain and stress of the tets. Releases Python's lock. The next call uses the arrays again if Python has
  /// dropped them: otherwise glibc may return them to the system each time, which may double their cost.
  std::shared_ptr<TissueState> tissue();
  /// Strain and stress of the points; computed from `of_tets` if it is given.
  std::shared_ptr<TissueState> tissue_at_points(const TissueState* of_tets);
  /// Numbers of the motions of prescribed points of a body, ascending.
  [[nodiscard]] std::vector<Index> prescribed_of(Index body);
  /// Throws Error if it is not the number of a motion, or that of a rigid body.
  void check_prescribed(Index number);
  /// The body's motion. Throws Error if it has none.
  [[nodiscard]] Index motion_of(Index body) const;
  /// Of its scene; SI for a model built in code.
  [[nodiscard]] const Units& units() const { return units_; }
  /// (n_points) 1 for points that follow a motion.
  [[nodiscard]] const std::vector<std::uint8_t>& prescribed() const { return prescribed_; }
  void change(const Scene& scene);
  void set_positions(std::span<const Index> points, std::span<const Vec3> positions);

  /// The simulation, for all other calls. Throws Error while another thread is inside.
  [[nodiscard]] palpate::Simulation& idle() {
    busy_.check("Simulation");
    return *simulation_;
  }

 private:
  std::vector<std::uint8_t> reoriented_;      ///< (n_tets) 1: two corners are swapped
  std::vector<std::uint8_t> self_collision_;  ///< (n_bodies)
  std::vector<Index> motion_of_body_;         ///< (n_bodies), or -1
  std::vector<std::uint8_t> prescribed_;      ///< (n_points)
  Units units_;
  std::optional<RelaxReport> relaxed_;
  std::unique_ptr<palpate::Simulation> simulation_;
  std::shared_ptr<Contacts> contacts_;
  std::shared_ptr<Crossings> crossings_;
  std::shared_ptr<TissueState> tissue_;  ///< of the last call
  std::shared_ptr<TissueState> tissue_at_points_;
  std::int64_t steps_not_converged_ = 0;
  std::int64_t steps_too_far_ = 0;
  std::int64_t most_inverted_tets_ = 0;
  std::unique_ptr<StageRun> stages_;
  std::unique_ptr<OutcomeProbe> outcomes_;
  std::vector<std::vector<OutcomeValue>> stage_outcomes_;
  Busy busy_;

  void follow_holds();
};

}  // namespace palpate::python
