#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <palpate/error.hpp>

#include "detection_options.hpp"
#include "exit_codes.hpp"
#include "io/atomic_file.hpp"
#include "messages.hpp"
#include "numbers.hpp"
#include "option_values.hpp"
#include "parallel/parallel.hpp"
#include "run_pictures.hpp"
#include "run_report.hpp"
#include "scene/json_text.hpp"
#include "stopwatch.hpp"
#include "subcommands.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* examples = R"(Examples:
  palpate run scenes/stacking.json
  palpate run scenes/stacking.json --until-rest --out results/at-rest
  palpate run scene.json --steps 50 --no-picture --json | jq .state_hash

Writes frames.pvd with frames/*.vtu (for ParaView), metrics.csv (a row for each step), run.json and picture.png; what
an earlier run left there is replaced. Ctrl-C ends after the current step and keeps what is done.)";

struct RunOptions {
  fs::path scene;
  std::optional<std::int64_t> steps;
  bool until_rest = false;
  std::optional<fs::path> out;
  std::optional<int> every;
  bool no_picture = false;
  bool json = false;
  bool quiet = false;
  int threads = 0;
  DetectionOptions detection;
};

/// A scene's name as the name of a folder: letters, digits, '.', '_' and '-' stay.
std::string folder_name(const std::string& name) {
  std::string folder;
  for (const char c : name) {
    const bool plain = ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9') ||
                       c == '_' || c == '-' || (c == '.' && !folder.empty());
    folder += plain ? c : '-';
  }
  return folder;
}

std::int64_t most_steps(const RunOptions& options, const Scene& scene) {
  if (options.steps) return *options.steps;
  // A duration of 50 steps is 50 steps, whatever the rounding of the quotient.
  constexpr double rounding = 1e-9;
  const double steps = std::ceil(scene.duration / scene.settings.time_step * (1.0 - rounding));
  constexpr double largest = 1e15;
  if (steps > largest) {
    throw BadInput(scene.source, "duration", short_text(steps) + " steps of time_step", "at most 1e15");
  }
  return static_cast<std::int64_t>(steps);
}

/// What an earlier run left must not be taken for a result of this one.
void remove_old_results(const fs::path& folder, const Scene& scene) {
  std::vector<fs::path> paths = picture_paths(folder, scene);
  paths.push_back(folder / "run.json");
  for (const fs::path& path : paths) {
    std::error_code failed;
    fs::remove(path, failed);
    if (failed) throw Error(path.string(), "removing", "'" + failed.message() + "'", "a file or none");
  }
}

/// Ends a run that did not get to its end: the results are there, the exit code says that they are not all.
int exit_code(const RunReport& report) {
  if (!report.outcome.failure.empty()) throw std::runtime_error(report.outcome.failure);
  if (!report.outcome.interrupted) return exit_done;
  say_error(fmt::format("interrupted after step {} of {}; results so far are in {}", report.outcome.steps,
                        report.most_steps, report.folder.string()));
  return exit_failed;
}

/// Removes the overlaps at the start where the scene asks for it.
std::optional<RelaxReport> relax_model(const Scene& scene, Model& model, const RunOptions& options) {
  if (!scene.relax) return std::nullopt;
  const InterruptFlag interrupt;
  const auto progress = [&](int steps, double deepest) {
    if (interrupt.requested()) throw std::runtime_error("interrupted while relaxing; there are no results");
    if (steps % 10 == 0 && !options.quiet) {
      say_progress(fmt::format("relaxing: step {} of {} at most, {} {} deep at most", steps,
                               scene.relax->max_steps, short_text(deepest), scene.units.length));
    }
  };
  RelaxReport report;
  as_input([&] {
    report = relax(model, scene.settings, *scene.relax, options.threads, progress);
    return 0;
  });
  if (!report.relaxed) {
    say_note(fmt::format("{}: overlaps of {} {} are left after relaxing, more than the {} {} allowed",
                         scene.source, short_text(report.deepest_after), scene.units.length,
                         short_text(report.allowed_depth), scene.units.length));
  }
  return report;
}

int run(const RunOptions& options) {
  Stopwatch watch;
  SceneInput input = read_scene_input(options.scene);
  Scene& scene = input.scene;
  options.detection.apply(scene.settings.detection);
  scene.output.every = options.every.value_or(scene.output.every);
  const std::vector<std::uint8_t> obstacles = input.model.obstacles;
  const std::int64_t steps = most_steps(options, scene);
  const std::optional<RelaxReport> relaxed = relax_model(scene, input.model, options);
  Simulation simulation = make_simulation(scene, std::move(input.model), options.threads);

  const std::vector<Vec3> start(simulation.positions().begin(), simulation.positions().end());

  const fs::path folder = options.out.value_or(fs::path("results") / folder_name(scene.name));
  FrameWriter frames(folder, scene.output.every);
  remove_old_results(folder, scene);
  MetricsFile metrics(folder / "metrics.csv", scene.units);
  RunOutcome outcome;
  {
    // Only while it steps: Ctrl-C during the picture ends the command at once, when all but the picture is
    // there.
    const InterruptFlag interrupt;
    Progress progress(steps, options.quiet);
    outcome = run_loop(simulation, steps, options.until_rest, interrupt, frames, metrics, progress);
  }
  const double wall_seconds = watch.lap();
  const auto report_with = [&](const std::vector<fs::path>& pictures) {
    return RunReport{.scene_file = options.scene,
                     .scene = scene,
                     .simulation = simulation,
                     .files = input.files,
                     .obstacles = obstacles,
                     .relaxed = relaxed,
                     .outcome = outcome,
                     .folder = folder,
                     .frames = frames.count(),
                     .pictures = pictures,
                     .most_steps = steps,
                     .threads = parallel::Threads(options.threads).count(),
                     .wall_seconds = wall_seconds};
  };
  const auto write_report = [&](const RunReport& report) {
    std::string json = format_json(report_json(report)) + "\n";
    io::write_atomically(folder / "run.json", json);
    return json;
  };
  write_report(report_with({}));
  std::vector<fs::path> pictures;
  if (!options.no_picture && !outcome.interrupted && outcome.failure.empty()) {
    try {
      take_pictures({folder, scene, simulation, start, outcome, options.threads});
      pictures = picture_paths(folder, scene);
    } catch (const Error& error) {  // the run itself is done
      outcome.failure = error.what();
    }
  }
  const RunReport report = report_with(pictures);
  const std::string json = write_report(report);
  if (options.json) print_out(json);
  if (!options.json && !options.quiet) print_out(report_text(report));
  return exit_code(report);
}

void add_flags(CLI::App& app, RunOptions& options) {
  constexpr auto any_count = std::numeric_limits<std::int64_t>::max();
  add_path(app, "SCENE", options.scene, "scene file (.json)");
  add_value(app, "--steps", "N", "end after N steps, in place of the scene's duration",
            [&options](const std::string& flag, const std::string& text) {
              options.steps = parse_integer(flag, text, 0, any_count);
            });
  app.add_flag("--until-rest", options.until_rest,
               "end once nothing moves; at the latest after --steps or the duration");
  add_value(app, "--out", "DIR", "folder of the results; default: results/NAME of the scene",
            [&options](const std::string&, const std::string& text) { options.out = text; });
  add_value(app, "--every", "N", "steps from one frame to the next, in place of the scene's",
            [&options](const std::string& flag, const std::string& text) {
              options.every = static_cast<int>(parse_integer(flag, text, 1, std::numeric_limits<int>::max()));
            });
  app.add_flag("--no-picture", options.no_picture, "take no picture");
  add_threads(app, options.threads);
  add_detection_options(app, options.detection);
  add_json(app, options.json, "print run.json in place of the summary");
  app.add_flag("--quiet", options.quiet, "no progress and no summary");
}

}  // namespace

Subcommand add_run(CLI::App& command) {
  CLI::App* app =
      command.add_subcommand("run", "simulate a scene and write frames, metrics, a report and a picture");
  app->footer(examples);
  auto options = std::make_shared<RunOptions>();
  add_flags(*app, *options);
  return {app, [options] { return run(*options); }};
}

}  // namespace palpate::app
