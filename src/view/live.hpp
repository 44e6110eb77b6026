#pragma once

#include <map>
#include <optional>

#include <palpate/simulation.hpp>

#include "scene/field_values.hpp"
#include "scene/scene.hpp"
#include "scene/stage_run.hpp"
#include "view/colour_field.hpp"
#include "view/motion_control.hpp"
#include "view/pull_limits.hpp"
#include "view/source.hpp"
#include "view/wrenches.hpp"

namespace palpate::view {

/// A running simulation that pages can watch and change. It goes through the stages of its scene, and then
/// on.
class LiveSource : public Source {
 public:
  /// \param scene    for name, units, colours and settings
  /// \param model  the result of load_model(); overlaps may have been removed
  ///
  /// Throws Error if Simulation and StageRun do.
  LiveSource(const Scene& scene, Model model, int threads);

  [[nodiscard]] const Stage& stage() const override { return stage_; }
  [[nodiscard]] const Bodies& bodies() const override { return simulation_.bodies(); }
  [[nodiscard]] std::span<const Vec3> positions() const override { return simulation_.positions(); }
  [[nodiscard]] const Detector& detector() const override { return simulation_.detector(); }
  [[nodiscard]] double time() const override { return simulation_.metrics().time; }
  [[nodiscard]] std::optional<double> interval() const override { return simulation_.settings().time_step; }
  void advance() override;
  void reset() override;
  [[nodiscard]] const PhaseSeconds& seconds() const override { return seconds_; }
  [[nodiscard]] nlohmann::ordered_json counts() const override;
  [[nodiscard]] nlohmann::ordered_json forces() const override;
  [[nodiscard]] std::vector<double> field(const std::string& name) const override {
    const ColourField* const colour = find_colour_field(name);
    if (colour == nullptr) return {};
    return colour_values(*colour, field_array(simulation_, std::string(colour->info->name), false).values);
  }
  [[nodiscard]] std::size_t begun_stages() const override;
  [[nodiscard]] nlohmann::ordered_json settings() const override {
    return settings_json(simulation_.settings());
  }
  void apply(Client client, const Change& change) override;
  void apply(Client client, const Pull& pull) override;
  void apply(Client client, const MovePull& pull) override;
  void apply(Client client, const LetGo& pull) override;
  void apply(Client client, const DriveMotion& command) override;
  void apply(Client client, const ResumeMotion& command) override;
  void apply(Client client, const Seek& seek) override;
  void forget(Client client) override;

  [[nodiscard]] const Simulation& simulation() const { return simulation_; }

 private:
  struct Held {
    Index grab = -1;
    Index vertex = -1;
    Vec3 target{};           ///< position of the hand
    double stiffness = 0.0;  ///< of the spring while its force is below `most`
    double most = 0.0;       ///< largest force, see PullLimits
  };
  [[nodiscard]] nlohmann::ordered_json about(const Scene& scene) const;
  [[nodiscard]] nlohmann::ordered_json motions_json() const;
  [[nodiscard]] nlohmann::ordered_json pulls_json() const;
  [[nodiscard]] nlohmann::ordered_json driven_motions_json() const;
  [[nodiscard]] nlohmann::ordered_json bodies_with(bool (LiveSource::*has)(Index) const) const;
  [[nodiscard]] nlohmann::ordered_json stages_json() const;
  [[nodiscard]] bool is_absent(Index body) const { return !simulation_.is_present(body); }
  [[nodiscard]] bool is_rigid_now(Index body) const { return simulation_.is_rigid(body); }
  /// Begins a stage if one is due.
  void begin_stage();
  void count_passes(const StepMetrics& m);
  void take_gravity_of_stage(const Vec3& before);
  void take_constraints(const ModelChange& change);
  void take_motions();
  void lead_pulls();
  /// Makes or updates a grab with the current spring.
  [[nodiscard]] Index spring(const Held& held);
  [[nodiscard]] Index body_of_motion(Index motion) const;
  [[nodiscard]] std::vector<Index> movable_bodies(const Scene& scene) const;
  [[nodiscard]] MotionControl motions_at_start() const;
  [[nodiscard]] PullLimits pull_limits() const;
  [[nodiscard]] double usual_stiffness(Index body) const;
  [[nodiscard]] double typical_contact_stiffness() const;
  [[nodiscard]] bool is_free(Index point) const;

  Model model_;    ///< at the start
  Model present_;  ///< the same with the constraints of now
  int threads_;
  Simulation simulation_;
  StageRun all_stages_;  ///< before the first
  StageRun stages_;
  std::optional<Vec3> gravity_before_;  ///< the first stage that sets one
  Surface surface_;
  std::vector<double> edge_lengths_;  ///< (n_bodies) mean, at rest
  std::vector<Index> movable_;        ///< of each of `motions_` its rigid body; -1: none
  MotionControl motions_;
  PullLimits limits_;
  Stage stage_;
  PhaseSeconds seconds_{};
  std::int64_t steps_not_converged_ = 0;  ///< since the start or reset()
  std::int64_t most_inverted_tets_ = 0;   ///< since the start or reset()
  std::int64_t steps_too_far_ = 0;        ///< in which something may have gone through a body
  double thinnest_ = 0.0;                 ///< least local thickness there, m
  bool has_reactions_ = false;            ///< the last step computed reactions of prescribed bodies
  std::map<Client, Held> pulls_;
};

}  // namespace palpate::view
