#include "report_page.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <vector>

#include <palpate/version.hpp>

#include "displacement.hpp"
#include "geometry/vector.hpp"
#include "html_page.hpp"
#include "io/machine.hpp"
#include "numbers.hpp"
#include "overlaps.hpp"
#include "run_pictures.hpp"

namespace palpate::app {
namespace {

using Rows = std::vector<std::vector<std::string>>;

void add_warnings(const RunReport& report, HtmlPage& page) {
  const RunOutcome& outcome = report.outcome;
  std::vector<std::string> warnings = report.stage_warnings;
  if (!outcome.failure.empty()) warnings.push_back("the run failed: " + outcome.failure);
  if (outcome.interrupted)
    warnings.emplace_back("the run was interrupted: results end before the planned end");
  if (outcome.steps_not_converged > 0) warnings.push_back(not_converged_text(outcome));
  if (outcome.inverted_tets.largest > 0) {
    warnings.push_back(fmt::format("inverted tets: {} at the end, {} at most", outcome.inverted_tets.last,
                                   outcome.inverted_tets.largest));
  }
  if (outcome.steps_too_far > 0) {
    warnings.push_back(fmt::format("something may have gone through a body in {}{}",
                                   counted(static_cast<std::size_t>(outcome.steps_too_far), "step"),
                                   thickness_text(report)));
  }
  if (outcome.late_steps > 0) {
    warnings.push_back(fmt::format("the detection budget was too small in {}: contacts may be missing",
                                   counted(static_cast<std::size_t>(outcome.late_steps), "step")));
  }
  if (report.relaxed && !report.relaxed->relaxed)
    warnings.emplace_back("overlaps at the start were not removed to the allowed depth");
  for (const std::string& warning : warnings) page.warning(warning);
  if (!warnings.empty()) return;
  page.paragraph("No warnings: all steps converged, no tet was inverted, nothing went through a body.");
}

/// A row for each outcome: its values at the end, and at the end of each stage.
void add_outcomes(const RunReport& report, HtmlPage& page) {
  const RunOutcome& outcome = report.outcome;
  if (outcome.outcomes.empty()) return;
  page.heading("Outcomes");
  Rows rows{{"outcome", "kind", "at the end"}};
  for (const StageRecord& stage : outcome.stages) rows.front().push_back("end of " + stage.name);
  for (std::size_t i = 0; i < outcome.outcomes.size(); ++i) {
    const OutcomeInfo& info = report.outcomes.infos()[i];
    auto& row = rows.emplace_back(
        std::vector{info.name, info.kind, report.outcomes.in_words(i, outcome.outcomes[i].value)});
    for (const StageRecord& stage : outcome.stages)
      row.push_back(i < stage.outcomes.size() ? report.outcomes.in_words(i, stage.outcomes[i].value) : "");
  }
  page.table(rows);
}

void add_stages(const RunReport& report, HtmlPage& page) {
  if (report.outcome.stages.empty()) return;
  page.heading("Stages");
  Rows rows{{"stage", "steps", "until, " + report.scene.units.time, "condition", "steps not converged",
             "inverted tets", "state hash"}};
  for (const StageRecord& stage : report.outcome.stages) {
    rows.push_back({stage.name, fmt::format("{} to {}", stage.first_step, stage.last_step),
                    short_text(stage.time), stage.reached ? "met" : "NOT MET",
                    fmt::format("{}", stage.steps_not_converged), fmt::format("{}", stage.inverted_tets),
                    stage.state_hash});
  }
  page.table(rows);
}

void add_picture(const std::filesystem::path& path, const std::string& caption, HtmlPage& page) {
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored)) page.picture(path, caption);
}

void add_pictures(const RunReport& report, HtmlPage& page) {
  page.heading("Pictures");
  for (const auto& picture : report.pictures) add_picture(picture, "end: " + picture.stem().string(), page);
  for (const StageRecord& stage : report.outcome.stages) {
    for (const auto& path : stage_picture_paths(report.folder, report.scene, stage.name))
      add_picture(path, "end of " + path.stem().string(), page);
  }
}

void add_bodies(const RunReport& report, HtmlPage& page) {
  page.heading("Bodies");
  const Simulation& simulation = report.simulation;
  const Units& units = report.scene.units;
  const std::vector<LargestStress> stresses = largest_stresses(simulation);
  Rows rows{{"body", "tets", "mass", "least dihedral angle, deg", "inverted tets", "contact force at the end",
             "largest contact force", "largest von Mises stress", "there at the end"}};
  for (Index b = 0; b < simulation.bodies().body_count(); ++b) {
    const Body& body = at(simulation.bodies().bodies(), b);
    const MeshStatistics mesh = mesh_statistics(simulation.bodies(), simulation.bodies().points_rest(), b);
    rows.push_back(
        {body.name, fmt::format("{}", body.tets.size()),
         in_words(at(simulation.masses(), b), units, dimension::mass),
         fmt::format("{:.1f}", mesh.dihedral_angle.min), fmt::format("{}", inverted_tets(simulation, b)),
         in_words(length(at(simulation.contact_forces(), b)), units, dimension::force),
         in_words(at(report.outcome.largest_forces, b).force, units, dimension::force),
         at(stresses, b).tet < 0 ? "" : in_words(at(stresses, b).von_mises, units, dimension::pressure),
         simulation.is_present(b) ? "yes" : "no"});
  }
  page.table(rows);
}

void add_run(const RunReport& report, HtmlPage& page) {
  page.heading("Run");
  const RunOutcome& outcome = report.outcome;
  const io::Machine machine = io::describe_machine();
  const SimulationSettings& settings = report.simulation.settings();
  page.table({{"", ""},
              {"steps", fmt::format("{} of {}", outcome.steps, short_text(settings.time_step)) + " " +
                            report.scene.units.time},
              {"at rest at the end", outcome.at_rest ? "yes" : "no"},
              {"deepest contact at the end",
               in_words(report.simulation.metrics().deepest, report.scene.units, dimension::length)},
              {"contacts",
               fmt::format("{} at the end, {} at most", outcome.contacts.last, outcome.contacts.largest)},
              {"friction", short_text(settings.response.friction)},
              {"solver tolerance", short_text(settings.solver.tolerance)},
              {"wall time", short_text(report.wall_seconds) + " s on " +
                                counted(static_cast<std::size_t>(report.threads), "thread")},
              {"state hash", report.simulation.state_hash()},
              {"palpate", fmt::format("{}, commit {}", PALPATE_VERSION, machine.commit)},
              {"compiler", fmt::format("{}, {}", machine.compiler, machine.build_type)},
              {"scene file", report.scene_file.string()}});
}

}  // namespace

std::string report_page(const RunReport& report) {
  HtmlPage page(report.scene.name);
  add_warnings(report, page);
  add_outcomes(report, page);
  add_stages(report, page);
  add_pictures(report, page);
  add_bodies(report, page);
  add_run(report, page);
  page.folded("The scene, all settings written out", write_scene(report.scene));
  return page.take();
}

}  // namespace palpate::app
