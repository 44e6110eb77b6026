#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>
#include <unistd.h>

#include "body_report.hpp"
#include "exit_codes.hpp"
#include "geometry/vector.hpp"
#include "messages.hpp"
#include "numbers.hpp"
#include "run_report.hpp"

namespace palpate::app {
namespace {

std::string ending(const RunReport& report) {
  if (report.outcome.interrupted) return "interrupted";
  return report.outcome.at_rest ? "at rest" : "not at rest";
}

std::string tally_line(const char* name, const Tally& tally) {
  return fmt::format("{:<14}{} at the end, {} at most\n", name, tally.last, tally.largest);
}

/// A line for a run in which something may have gone through a body, with the settings that prevent
/// it. Empty if nothing may.
std::string too_far_line(const RunReport& report) {
  const RunOutcome& outcome = report.outcome;
  if (outcome.steps_too_far == 0) return "";
  const DetectionSettings& detection = report.simulation.settings().detection;
  std::string cures = "a smaller time_step";
  if (!detection.edge_contacts) cures += ", or contact.edge_contacts true";
  if (detection.continuous == ContinuousDetection::off) cures += R"(, or contact.continuous "limited")";
  if (detection.continuous == ContinuousDetection::limited) cures += R"(, or contact.continuous "full")";
  if (detection.cells_per_primitive) cures += R"(, or contact.cells_per_primitive "exact")";
  if (outcome.late_steps > 0) cures += ", or a larger contact.budget";
  return fmt::format("too far       in {} something may have gone through a body{}; take {}\n",
                     counted(static_cast<std::size_t>(outcome.steps_too_far), "step"), thickness_text(report),
                     cures);
}

/// A line for a run whose budget was too small: how much work is left undone, and in which bodies. Empty if
/// none is.
std::string budget_lines(const RunReport& report) {
  const RunOutcome& outcome = report.outcome;
  std::string text;
  if (outcome.late_steps > 0) {
    text +=
        fmt::format("budget        too small in {}: contacts may be missing; {} % of the work done at least",
                    counted(static_cast<std::size_t>(outcome.late_steps), "step"),
                    short_text(100.0 * outcome.least_completeness));
    const std::string late = late_bodies_text(report.simulation.bodies(), report.simulation.detector());
    if (!late.empty()) text += "; at the end in " + late;
    text += '\n';
  }
  if (outcome.steps_without_prediction > 0) {
    text += fmt::format(
        "budget        no time to search for speculative contacts in {}: new contacts act one step later\n",
        counted(static_cast<std::size_t>(outcome.steps_without_prediction), "step"));
  }
  return text;
}

std::string phases_text(const PhaseTimes& times) {
  std::string text = fmt::format("{:<14}{:>10}{:>10}\n", "ms per step", "mean", "median");
  for (std::size_t phase = 0; phase < PhaseTimes::names.size(); ++phase) {
    text += fmt::format("  {:<12}{:>10.3f}{:>10.3f}\n", PhaseTimes::names[phase], 1e3 * times.mean(phase),
                        1e3 * times.median(phase));
  }
  return text;
}

/// A line for each body whose mesh file needed repairs or had other content.
std::string notes_lines(const RunReport& report) {
  std::string text;
  const Bodies& bodies = report.simulation.bodies();
  for (Index b = 0; b < bodies.body_count(); ++b) {
    const auto& file = report.files[static_cast<std::size_t>(b)];
    const std::string notes = notes_text(file ? &*file : nullptr, at(bodies.notes(), b));
    if (!notes.empty())
      text += fmt::format("note          {}: {}\n", shown_name(at(bodies.bodies(), b).name), notes);
  }
  return text;
}

/// Bodies on which contacts acted during the run: held ones first, since their forces are usually wanted,
/// then free ones, each in the order of the scene.
std::vector<std::size_t> touched_bodies(const RunReport& report) {
  std::vector<std::size_t> held;
  std::vector<std::size_t> free;
  for (std::size_t b = 0; b < report.outcome.largest_forces.size(); ++b) {
    if (report.outcome.largest_forces[b].force == 0.0) continue;
    (report.probe.is_held(b) ? held : free).push_back(b);
  }
  held.insert(held.end(), free.begin(), free.end());
  return held;
}

/// Forces on bodies at the end, and the largest of the run, in N.
std::string forces_lines(const RunReport& report) {
  constexpr std::size_t most_lines = 8;
  const Units& units = report.scene.units;
  const std::vector<BodyForces> forces = report.probe.forces(report.simulation).bodies;
  const std::vector<std::size_t> bodies = touched_bodies(report);
  std::string text;
  for (const std::size_t b : std::span(bodies).first(std::min(most_lines, bodies.size()))) {
    const LargestForce& largest = report.outcome.largest_forces[b];
    text += fmt::format("{:<14}{}: contacts {} at the end, {} at most (step {})", "force",
                        shown_name(report.probe.names()[b]),
                        in_words(length(forces[b].contact.force), units, dimension::force),
                        in_words(largest.force, units, dimension::force), largest.step);
    if (report.scene.bodies[b].motion) {
      text += fmt::format("; its motor {}",
                          in_words(length(forces[b].held.value_or(Wrench{}).force), units, dimension::force));
    }
    text += '\n';
  }
  if (bodies.size() > most_lines)
    text += fmt::format("{:<14}... and {} more, in forces.csv\n", "force", bodies.size() - most_lines);
  return text;
}

/// The largest stress of all bodies.
std::string stress_line(const RunReport& report) {
  const std::vector<LargestStress> stresses = largest_stresses(report.simulation);
  const auto most = std::ranges::max_element(stresses, {}, &LargestStress::von_mises);
  if (most == stresses.end() || most->tet < 0) return {};
  return fmt::format("{:<14}von Mises {} at most, in tet {} of {}\n", "stress",
                     in_words(most->von_mises, report.scene.units, dimension::pressure), most->tet,
                     shown_name(report.probe.names()[static_cast<std::size_t>(most - stresses.begin())]));
}

/// A line for each completed stage, and for each outcome.
std::string outcome_lines(const RunReport& report) {
  std::string text;
  for (const StageRecord& stage : report.outcome.stages) {
    text += fmt::format("{:<14}{}: {}, until {} {}{}\n", "stage", stage.name,
                        counted(static_cast<std::size_t>(stage.last_step - stage.first_step), "step"),
                        short_text(stage.time), report.scene.units.time,
                        stage.reached ? "" : ", NOT REACHED: ended by its time");
  }
  for (std::size_t i = 0; i < report.outcome.outcomes.size(); ++i) {
    text += fmt::format("{:<14}{}: {}\n", "outcome", report.outcomes.infos()[i].name,
                        report.outcomes.in_words(i, report.outcome.outcomes[i].value));
  }
  return text;
}

std::string places_text(const RunReport& report) {
  const std::string folder = report.folder.string();
  std::string text =
      fmt::format("results       {}/frames.pvd ({})\n", folder, counted(report.frames, "frame"));
  text += fmt::format("metrics       {}/metrics.csv\n", folder);
  text += fmt::format("forces        {}/forces.csv\n", folder);
  if (!report.scene.outcomes.empty() || !report.scene.stages.empty())
    text += fmt::format("outcomes      {}/outcomes.json\n", folder);
  text += fmt::format("report        {}/run.json\n", folder);
  return text;
}

std::string divided_text(const RunOutcome& outcome) {
  return outcome.steps_divided == 0 ? "" : fmt::format("; {} divided", outcome.steps_divided);
}

}  // namespace

std::string not_converged_text(const RunOutcome& outcome) {
  if (outcome.steps_not_converged == 0) return {};
  return fmt::format("NOT CONVERGED in {} of {}: do not trust positions", outcome.steps_not_converged,
                     counted(static_cast<std::size_t>(outcome.steps), "step"));
}

std::string thickness_text(const RunReport& report) {
  const double thinnest = report.outcome.thinnest;
  return thinnest > 0.0 ? fmt::format(" ({} {} thin)", short_text(thinnest), report.scene.units.length) : "";
}

std::string pictures_text(std::span<const std::filesystem::path> pictures) {
  std::string text;
  for (const auto& picture : pictures) text += fmt::format("picture       {}\n", picture.string());
  return text;
}

std::string report_text(const RunReport& report) {
  const RunOutcome& outcome = report.outcome;
  const StepMetrics& metrics = report.simulation.metrics();
  const Units& units = report.scene.units;
  std::string text = not_converged_text(outcome);
  if (!text.empty()) text = coloured(text, Colour::red, STDOUT_FILENO) + '\n';
  text += fmt::format("{}: {}, {} {} simulated, {}\n", shown_name(report.scene.name),
                      counted(static_cast<std::size_t>(outcome.steps), "step"), short_text(metrics.time),
                      units.time, ending(report));
  if (report.relaxed) {
    text += fmt::format("relaxed       deepest overlap {} before, {} after {}; largest displacement {}\n",
                        in_words(report.relaxed->deepest_before, units, dimension::length),
                        in_words(report.relaxed->deepest_after, units, dimension::length),
                        counted(static_cast<std::size_t>(report.relaxed->steps), "step"),
                        in_words(report.relaxed->largest_move, units, dimension::length));
  }
  text += tally_line("contacts", outcome.contacts);
  if (outcome.edge_contacts.largest > 0) text += tally_line("edge contacts", outcome.edge_contacts);
  text += tally_line("crossings", outcome.crossings);
  text += fmt::format("deepest       {}\n", in_words(metrics.deepest, units, dimension::length));
  text += fmt::format("fastest       {} (point), {} (body, root mean square)\n",
                      in_words(metrics.largest_speed, units, dimension::speed),
                      in_words(metrics.fastest_body, units, dimension::speed));
  text += outcome_lines(report) + forces_lines(report) + stress_line(report);
  if (outcome.inverted_tets.largest > 0) text += tally_line("inverted tets", outcome.inverted_tets);
  text += phases_text(outcome.times);
  text += fmt::format("converged     in {} of {}{}\n", outcome.steps - outcome.steps_not_converged,
                      counted(static_cast<std::size_t>(outcome.steps), "step"), divided_text(outcome));
  text += too_far_line(report);
  text += budget_lines(report);
  text += fmt::format("wall time     {} s on {}\n", short_text(report.wall_seconds),
                      counted(static_cast<std::size_t>(report.threads), "thread"));
  text += fmt::format("state hash    {}\n", report.simulation.state_hash());
  return text + notes_lines(report) + places_text(report);
}

std::string resume_hint(const std::filesystem::path& folder) {
  return "to resume: palpate run --resume " + path_word(folder.string());
}

int exit_code(const RunReport& report, bool strict) {
  const RunOutcome& outcome = report.outcome;
  if (!outcome.failure.empty()) throw std::runtime_error(outcome.failure);
  if (outcome.interrupted) {
    say_error(fmt::format("interrupted after step {} of {}; results so far are in {}; {}", outcome.steps,
                          report.most_steps, report.folder.string(), resume_hint(report.folder)));
    return exit_failed;
  }
  if (strict && !report.stage_warnings.empty()) {
    throw std::runtime_error(fmt::format("{} (--strict); results are in {}", report.stage_warnings.front(),
                                         report.folder.string()));
  }
  if (!strict || outcome.steps_not_converged == 0) return exit_done;
  throw std::runtime_error(
      fmt::format("not converged in {} of {} (--strict); results are in {}", outcome.steps_not_converged,
                  counted(static_cast<std::size_t>(outcome.steps), "step"), report.folder.string()));
}

}  // namespace palpate::app
