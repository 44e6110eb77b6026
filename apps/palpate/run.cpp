#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <palpate/error.hpp>

#include "checkpoint.hpp"
#include "detection_options.hpp"
#include "exit_codes.hpp"
#include "folder_lock.hpp"
#include "io/atomic_file.hpp"
#include "messages.hpp"
#include "option_values.hpp"
#include "outcomes_json.hpp"
#include "parallel/parallel.hpp"
#include "relax_model.hpp"
#include "report_page.hpp"
#include "run_begin.hpp"
#include "run_pictures.hpp"
#include "run_report.hpp"
#include "scene/json_text.hpp"
#include "stopwatch.hpp"
#include "subcommands.hpp"
#include "tissue_presets.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* run_examples = R"(Examples:
  palpate run scenes/stacking.json
  palpate run scenes/stacking.json --until-rest --out results/at-rest
  palpate run scene.json --steps 50 --no-picture --json | jq .state_hash
  palpate run scene.json --set contact.friction=0.3 --set bodies.liver.material.young_modulus=5e3
  python3 make_scene.py | palpate run -             a scene from standard input
  palpate run scene.json --checkpoint-every 100     lose no more than 100 steps, whatever happens
  palpate run --resume results/scene                resume that run where it ended
  palpate run variant.json --from-stage rest --from results/plan    a variant of the stages behind 'rest'

Writes frames.pvd with frames/*.vtu (for ParaView), metrics.csv and forces.csv (a row for each step), run.json and picture.png;
outcomes.json if the scene has outcomes or stages; report.html with --report. Results of an earlier run in the folder are
replaced, except checkpoints of a run that did not reach its end (see --replace). Ctrl-C ends the run after the current step,
keeps its results and writes a checkpoint; --resume continues from the last checkpoint.)";

/// Removes files of an earlier run, which could be mistaken for results of this one.
void remove_old_results(const fs::path& folder, const Scene& scene, bool stages) {
  std::vector<fs::path> paths = picture_paths(folder, scene);
  for (const char* name : {"run.json", "outcomes.json", "report.html"}) paths.push_back(folder / name);
  if (stages) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder / "stages", ignored)) {
      const std::string kind = entry.path().extension().string();
      if (kind == ".palpate" || kind == ".png") paths.push_back(entry);
    }
  }
  for (const fs::path& path : paths) {
    std::error_code failed;
    fs::remove(path, failed);
    if (failed)
      throw Error(path.string(), "removing", "'" + failed.message() + "'", "a file that can be removed");
  }
}

/// Restores the stages from the checkpoint, if there is one.
void resume_stages(const Begin& begin, Simulation& simulation, StageRun& stages) {
  if (!begin.checkpoint) return;
  try {
    simulation.restore(begin.checkpoint->checkpoint.simulation);
    stages.resume(simulation, begin.checkpoint->checkpoint.stages);
  } catch (const Error& error) {  // the message must name the file
    throw BadInput(begin.checkpoint->path.string(), error.where(), error.found(), error.expected());
  }
}

MetricsFile open_metrics(const Begin& begin, const OutcomeProbe& outcomes) {
  const fs::path path = begin.folder / "metrics.csv";
  if (begin.checkpoint && has_same_columns(begin)) return {path, begin.checkpoint->checkpoint.metrics_bytes};
  if (!begin.checkpoint) check_replaceable(begin);
  return {path, begin.input.scene.units, outcomes};
}

ForcesFile open_forces(const Begin& begin, const ForceProbe& probe) {
  const fs::path path = begin.folder / "forces.csv";
  if (begin.checkpoint) return {path, begin.checkpoint->checkpoint.forces_bytes};
  return {path, probe, begin.input.scene.units};
}

/// The files and folders where the results of a run are written. The CSV files are opened first: if they
/// cannot be continued, nothing has been changed yet.
struct Outputs {
  Outputs(const Begin& begin, const ForceProbe& probe, const OutcomeProbe& outcomes)
      : metrics(open_metrics(begin, outcomes)),
        forces(open_forces(begin, probe)),
        frames(begin.folder, begin.input.scene.output, begin.input.scene.units,
               begin.checkpoint ? begin.checkpoint->checkpoint.frames : FramesSoFar{}),
        checkpoints(
            begin.folder, begin.plan,
            begin.checkpoint && !begin.from_stage ? std::optional(begin.checkpoint->path) : std::nullopt) {
    remove_old_results(begin.folder, begin.input.scene, !begin.checkpoint);
  }
  MetricsFile metrics;
  ForcesFile forces;
  FrameWriter frames;
  CheckpointWriter checkpoints;
};

RunOutcome step_through(const Begin& begin, Simulation& simulation, const InterruptFlag& interrupt,
                        const RunOutputs& outputs) {
  try {
    return run_loop(simulation, begin.plan.most_steps, begin.plan.until_rest, interrupt, outputs,
                    begin.checkpoint ? std::optional(begin.checkpoint->checkpoint.outcome) : std::nullopt);
  } catch (const Error& error) {
    const std::optional<std::int64_t> step = outputs.checkpoints.last_step();
    if (!step || !has_checkpoints(begin.folder)) throw;
    throw std::runtime_error(fmt::format("{}; the last checkpoint is of step {}: {}", error.what(), *step,
                                         resume_hint(begin.folder)));
  }
}

void say_where_it_begins(const Begin& begin, std::int64_t step) {
  if (begin.from_stage) {
    print_note(fmt::format("{}: from step {}, the end of stage '{}'", begin.folder.string(), step,
                           *begin.from_stage));
  } else {
    print_note(fmt::format("{}: resumes from step {}", begin.folder.string(), step));
  }
}

void say_missing_frames(const FrameWriter& frames) {
  const auto& missing = frames.missing();
  if (missing.empty()) return;
  print_note(fmt::format(
      "{}: {} earlier frame{} missing (the first is number {}), left out of the collection",
      frames.collection().string(), missing.size(), missing.size() == 1 ? " is" : "s are", missing.front()));
}

/// Prints warnings that users must not overlook.
void say_warnings(const RunReport& report) {
  if (const std::string warning = not_converged_text(report.outcome); !warning.empty())
    print_note(fmt::format("{}: {}", report.folder.string(), warning));
  for (const std::string& stage : report.stage_warnings)
    print_note(fmt::format("{}: {}", report.folder.string(), stage));
}

std::string write_results(const RunReport& report) {
  std::string json = format_json(report_json(report)) + "\n";
  io::write_atomically(report.folder / "run.json", json);
  if (!report.scene.outcomes.empty() || !report.scene.stages.empty())
    io::write_atomically(report.folder / "outcomes.json", format_json(outcomes_json(report)) + "\n");
  return json;
}

int run(const RunOptions& options) {
  Stopwatch watch;
  Begin begin = begin_run(options);
  const Scene& scene = begin.input.scene;
  const std::vector<std::uint8_t> obstacles = begin.input.model.obstacles;
  std::optional<InterruptFlag> interrupt(std::in_place);
  const std::optional<RelaxReport> relaxed =
      relax_model(scene, begin.input.model, options.threads, options.quiet, *interrupt);
  const ForceProbe probe(scene, begin.input.model);
  const std::vector<Index> material_of_tet = begin.input.model.material_of_tet;
  Simulation simulation = make_simulation(scene, std::move(begin.input.model), options.threads);
  simulation.record_reactions(true);
  const std::vector<Vec3> start(simulation.positions().begin(), simulation.positions().end());
  const OutcomeProbe outcomes = as_input([&] { return OutcomeProbe(scene, simulation.bodies()); });
  StageRun stages = as_input([&] { return StageRun(scene, simulation); });
  resume_stages(begin, simulation, stages);
  const std::optional<std::int64_t> first =
      begin.checkpoint ? std::optional(simulation.metrics().step) : std::nullopt;

  const fs::path& folder = begin.folder;
  const FolderLock lock(folder);
  copy_earlier_rows(begin);
  Outputs outputs(begin, probe, outcomes);
  if (first && !options.quiet) say_where_it_begins(begin, *first);
  say_missing_frames(outputs.frames);
  StagePictures stage_pictures(folder, scene, simulation, start, material_of_tet, options.threads);
  const bool pictured = scene.output.report && !begin.plan.no_picture;
  Progress progress(simulation.metrics().step, begin.plan.most_steps, options.quiet);
  RunOutcome outcome =
      step_through(begin, simulation, *interrupt,
                   {outputs.frames, outputs.metrics, outputs.forces, probe, outputs.checkpoints, progress,
                    stages, outcomes, [&](const StageRecord& stage, const RunOutcome& so_far) {
                      if (pictured) stage_pictures.take(stage.name, so_far);
                    }});
  const double wall_seconds = watch.lap();
  const auto report_with = [&](const std::vector<fs::path>& pictures, bool page) {
    return RunReport{.scene_file = begin.plan.scene_file,
                     .scene = scene,
                     .simulation = simulation,
                     .files = begin.input.files,
                     .obstacles = obstacles,
                     .probe = probe,
                     .outcomes = outcomes,
                     .relaxed = relaxed,
                     .outcome = outcome,
                     .resumed_from = first,
                     .from_stage = begin.from_stage,
                     .stage_warnings = stages.warnings(),
                     .folder = folder,
                     .frames = outputs.frames.count(),
                     .maxima = outputs.frames.maxima(),
                     .pictures = pictures,
                     .page = page,
                     .most_steps = begin.plan.most_steps,
                     .threads = parallel::Threads(options.threads).count(),
                     .wall_seconds = wall_seconds};
  };
  write_results(report_with({}, false));
  if (!options.quiet) say_warnings(report_with({}, false));
  const bool tells = !options.json && !options.quiet;
  if (tells) print_out(report_text(report_with({}, false)));
  // From here on Ctrl-C ends the command at once, and only pictures and the page are missing.
  interrupt.reset();
  std::vector<fs::path> pictures;
  if (!begin.plan.no_picture && !outcome.interrupted && outcome.failure.empty()) {
    try {
      render_pictures({folder, scene, simulation, start, material_of_tet, outcome, options.threads},
                      options.quiet);
      pictures = picture_paths(folder, scene);
    } catch (const Error& error) {  // the results of the run are complete
      outcome.failure = error.what();
    }
  }
  const RunReport report = report_with(pictures, scene.output.report);
  if (report.page) io::write_atomically(folder / "report.html", report_page(report));
  const std::string json = write_results(report);
  if (options.json) print_out(json);
  if (tells) print_out(pictures_text(pictures));
  if (tells && report.page) print_out(fmt::format("page          {}/report.html\n", folder.string()));
  return exit_code(report, begin.plan.strict);
}

void add_flags(CLI::App& app, RunOptions& options) {
  constexpr auto any_count = std::numeric_limits<std::int64_t>::max();
  add_path(app, "SCENE", options.scene.file, "scene file (.json), '-' for standard input; none with --resume")
      ->required(false);
  add_changes(app, options.scene.changes);
  add_value(app, "--steps", "N", "end after N steps, instead of the scene's duration",
            [&options](const std::string& flag, const std::string& text) {
              options.steps = parse_integer(flag, text, 0, any_count);
            });
  app.add_flag("--until-rest", options.until_rest,
               "end when all bodies are at rest; at the latest after --steps or the duration");
  add_value(app, "--out", "DIR", "folder of the results; default: results/NAME, by the name of the scene",
            [&options](const std::string&, const std::string& text) { options.out = text; });
  add_value(app, "--every", "N", "steps from one frame to the next, instead of the scene's",
            [&options](const std::string& flag, const std::string& text) {
              options.every = static_cast<int>(parse_integer(flag, text, 1, std::numeric_limits<int>::max()));
            });
  app.add_flag("--replace", options.replace,
               "start a new run although the folder has checkpoints of an incomplete run, which are deleted");
  CLI::Option* const from_stage =
      add_value(app, "--from-stage", "NAME",
                "begin at the end of this stage, which an earlier run has saved (docs/stages.md)",
                [&options](const std::string&, const std::string& text) { options.from_stage = text; });
  add_value(app, "--from", "DIR",
            "the results folder of the earlier run that saved the stage; default: the folder of this run",
            [&options](const std::string&, const std::string& text) { options.from = text; })
      ->needs(from_stage);
  app.add_flag("--report", options.report, "write report.html: a page about the run");
  app.add_flag("--strict", options.strict,
               "exit with 1 if a step did not converge or a stage ended by its time; results are written "
               "anyway");
  app.add_flag("--no-picture", options.no_picture, "write no picture");
  add_value(app, "--checkpoint-every", "N", "steps from one checkpoint to the next; the last two are kept",
            [&options](const std::string& flag, const std::string& text) {
              options.checkpoint_every = parse_integer(flag, text, 1, any_count);
            });
  add_threads(app, options.threads);
  add_detection_options(app, options.detection);
  add_json(app, options.json, "print run.json instead of the summary");
  app.add_flag("--quiet", options.quiet, "no progress and no summary");
  CLI::Option* const resume = add_value(
      app, "--resume", "DIR", "resume from the last checkpoint in these results, with its scene and flags",
      [&options](const std::string&, const std::string& text) { options.resume = text; });
  // A resumed run keeps the settings that it began with.
  for (const char* other :
       {"SCENE", "--set", "--out", "--replace", "--every", "--from-stage", "--from", "--report",
        "--structure", "--order", "--sort", "--cell-size", "--cells-per-primitive"})
    resume->excludes(app.get_option(other));
}

}  // namespace

Subcommand add_run(CLI::App& command) {
  CLI::App* app =
      command.add_subcommand("run", "simulate a scene and write frames, metrics, a report and a picture");
  app->footer(std::string(run_examples) + tissue_lines());
  auto options = std::make_shared<RunOptions>();
  add_flags(*app, *options);
  return {app, [options] { return run(*options); }};
}

}  // namespace palpate::app
