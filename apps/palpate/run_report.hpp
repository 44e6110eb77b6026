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

/// All results of a run at its end. Large data are borrowed.
struct RunReport {
  std::filesystem::path scene_file;
  const Scene& scene;  ///< with the settings that were used
  const Simulation& simulation;
  const std::vector<std::optional<MeshRecord>>& files;  ///< (n_bodies)
  const std::vector<std::uint8_t>& obstacles;           ///< (n_bodies)
  const ForceProbe& probe;
  const OutcomeProbe& outcomes;
  const std::optional<RelaxReport>& relaxed;  ///< none: the scene did not ask for it
  const RunOutcome& outcome;
  std::optional<std::int64_t> resumed_from;  ///< step; none: it began at the start
  std::optional<std::string> from_stage;     ///< it began at the end of this stage of another run
  std::vector<std::string> stage_warnings;   ///< StageRun::warnings()
  std::filesystem::path folder;
  std::size_t frames = 0;
  std::vector<FieldMaximum> maxima;             ///< of the fields that frames have
  std::vector<std::filesystem::path> pictures;  ///< picture.png and the views; empty where none was taken
  std::int64_t most_steps = 0;
  int threads = 0;
  double wall_seconds = 0.0;
};

/// The bodies that a budget did not suffice for in the last step.
std::vector<std::string> late_body_names(const Bodies& bodies, const Detector& detector);
/// Their names for people, "liver, spleen"; empty where there are none.
std::string late_bodies_text(const Bodies& bodies, const Detector& detector);

/// The content of run.json.
nlohmann::ordered_json report_json(const RunReport& report);

/// The largest stress of a body at the end of a run.
struct LargestStress {
  double von_mises = 0.0;
  Index tet = -1;  ///< of the body's own tets
  Vec3 place{};    ///< its centre
};
/// (n_bodies); rigid bodies have none. O(tets).
std::vector<LargestStress> largest_stresses(const Simulation& simulation);

/// What nobody is to overlook of a run in which steps did not converge; empty where all did.
std::string not_converged_text(const RunOutcome& outcome);

/// The summary that a person reads at the end of a run; pictures, which come later, are not in it.
std::string report_text(const RunReport& report);

/// A line for each picture.
std::string pictures_text(std::span<const std::filesystem::path> pictures);

/// How a run is taken up again.
std::string resume_hint(const std::filesystem::path& folder);

/// Ends a run: one that did not get to its end has results, but the exit code says that they are not all.
/// Throws std::runtime_error where the simulation failed, and with `strict` where steps did not converge.
int exit_code(const RunReport& report, bool strict);

}  // namespace palpate::app
