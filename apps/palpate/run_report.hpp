#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <palpate/relax.hpp>
#include <palpate/simulation.hpp>

#include "run_loop.hpp"
#include "scene_input.hpp"

namespace palpate::app {

/// All results of a run at its end. References must outlive it.
struct RunReport {
  std::filesystem::path scene_file;
  const Scene& scene;  ///< with the settings that were used
  const Simulation& simulation;
  const std::vector<std::optional<MeshRecord>>& files;  ///< (n_bodies)
  const std::vector<std::uint8_t>& obstacles;           ///< (n_bodies)
  const ForceProbe& probe;
  const OutcomeProbe& outcomes;
  const std::optional<RelaxReport>& relaxed;  ///< empty: the scene did not ask for it
  const RunOutcome& outcome;
  std::optional<std::int64_t>
      resumed_from;  ///< the step from which the run was resumed; none: it began at the start
  std::optional<std::string> from_stage;    ///< the stage of another run at whose end it began
  std::vector<std::string> stage_warnings;  ///< StageRun::warnings()
  std::filesystem::path folder;
  std::size_t frames = 0;
  std::vector<FieldMaximum> maxima;             ///< of the fields of frames
  std::vector<std::filesystem::path> pictures;  ///< picture.png and the views; empty where none was drawn
  bool page = false;                            ///< report.html is written, too
  std::int64_t most_steps = 0;
  int threads = 0;
  double wall_seconds = 0.0;
};

/// Names of the bodies with clusters that the budget left out in the last step.
std::vector<std::string> late_body_names(const Bodies& bodies, const Detector& detector);
/// The names of the late bodies as a text such as "liver, spleen"; empty if there are none.
std::string late_bodies_text(const Bodies& bodies, const Detector& detector);

/// The content of run.json.
nlohmann::ordered_json report_json(const RunReport& report);

/// The largest stress of a body at the end of a run.
struct LargestStress {
  double von_mises = 0.0;
  Index tet = -1;  ///< index among the body's own tets
  Vec3 place{};    ///< its centre
};
/// Computes the largest stress of each body (n_bodies); rigid bodies have none. O(tets).
std::vector<LargestStress> largest_stresses(const Simulation& simulation);

/// A warning on a run with steps that did not converge; empty where all converged.
std::string not_converged_text(const RunOutcome& outcome);
/// " (2 mm thin)" for the parts through which something may have gone; empty where their thickness is not
/// known.
std::string thickness_text(const RunReport& report);

/// The summary on the terminal at the end of a run, without pictures, which come later.
std::string report_text(const RunReport& report);

/// A line for each picture.
std::string pictures_text(std::span<const std::filesystem::path> pictures);

/// A line that says how to resume the run.
std::string resume_hint(const std::filesystem::path& folder);

/// The exit code of a run. It differs for a run that has results but did not reach its end. Throws
/// std::runtime_error if the simulation failed, and with `strict` if steps did not converge.
int exit_code(const RunReport& report, bool strict);

}  // namespace palpate::app
