#include "run_begin.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include <palpate/error.hpp>

#include "exit_codes.hpp"
#include "io/atomic_file.hpp"
#include "io/file_bytes.hpp"
#include "messages.hpp"
#include "numbers.hpp"
#include "scene/stage_run.hpp"
#include "scene/suggest.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

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
  if (!scene.stages.empty()) return as_input([&] { return most_steps_of_stages(scene); });
  // A duration of 50 steps gives 50 steps, also if the quotient is rounded.
  constexpr double rounding = 1e-9;
  const double steps = std::ceil(scene.duration / scene.settings.time_step * (1.0 - rounding));
  constexpr double largest = 1e15;
  if (steps > largest) {
    throw BadInput(scene.source, "duration", short_text(steps) + " steps of time_step", "at most 1e15");
  }
  return static_cast<std::int64_t>(steps);
}

Begin begin_anew(const RunOptions& options) {
  if (options.scene.file.empty()) throw BadInput("run: SCENE is required (see --help)");
  Begin begin{.plan = {},
              .input = read_scene_input(options.scene),
              .folder = {},
              .checkpoint = {},
              .replace = options.replace};
  Scene& scene = begin.input.scene;
  options.detection.apply(scene.settings.detection);
  scene.output.every = options.every.value_or(scene.output.every);
  scene.output.report = scene.output.report || options.report;
  if (options.until_rest && !scene.stages.empty()) {
    throw BadInput("--until-rest", "", "a scene with stages",
                   "no --until-rest: each stage has its own condition to end");
  }
  begin.folder = options.out.value_or(fs::path("results") / folder_name(scene.name));
  begin.plan = {.scene_file = options.scene.file.string(),
                .scene = write_scene(scene),
                .source = scene.source,
                .scene_folder = fs::absolute(scene.folder.empty() ? "." : scene.folder).string(),
                .most_steps = most_steps(options, scene),
                .until_rest = options.until_rest,
                .no_picture = options.no_picture,
                .strict = options.strict,
                .checkpoint_every = options.checkpoint_every.value_or(0)};
  return begin;
}

/// Whether run.json exists and its run was completed.
bool has_ended(const fs::path& folder) {
  std::ifstream file(folder / "run.json");
  const nlohmann::json report = nlohmann::json::parse(file, nullptr, false);
  return report.is_object() && report.value("interrupted", nlohmann::json()) == false &&
         report.value("error", nlohmann::json()).is_null();
}

}  // namespace

void check_replaceable(const Begin& begin) {
  const fs::path& folder = begin.folder;
  if (begin.replace || !has_checkpoints(folder) || has_ended(folder)) return;
  throw BadInput(
      folder.string(), "", "checkpoints of a run that has not ended",
      fmt::format("--resume {} to continue it, or --replace to start again", path_word(folder.string())));
}

bool has_same_columns(const Begin& begin) {
  const auto outcomes_of = [](const std::string& text) {
    const auto scene = nlohmann::json::parse(text);
    return scene.value("outcomes", nlohmann::json::array());
  };
  return outcomes_of(begin.checkpoint->checkpoint.plan.scene) == outcomes_of(begin.plan.scene);
}

namespace {

/// A variant that begins at the end of a stage must have the same stages until there, in the same order.
void check_same_stages(const Scene& scene, const FoundCheckpoint& found, const std::string& stage) {
  std::vector<std::string_view> names(scene.stages.size());
  std::ranges::transform(scene.stages, names.begin(),
                         [](const Stage& known) { return std::string_view(known.name); });
  const auto place = std::ranges::find(names, stage);
  if (place == names.end())
    throw BadInput("--from-stage", "", "'" + stage + "'", expected_name(stage, names));
  const auto stages_of = [](const std::string& text) { return nlohmann::json::parse(text)["stages"]; };
  const nlohmann::json now = stages_of(write_scene(scene));
  const nlohmann::json then = stages_of(found.checkpoint.plan.scene);
  for (std::size_t i = 0; i <= static_cast<std::size_t>(place - names.begin()); ++i) {
    if (i < then.size() && now[i] == then[i]) continue;
    throw BadInput(scene.source, fmt::format("stages[{}]", i),
                   "a stage that differs from the one of the earlier run",
                   fmt::format("the stages of the earlier run, unchanged up to '{}'", stage));
  }
}

/// Begins a run at the end of a stage of another run.
Begin begin_from_stage(const RunOptions& options) {
  Begin begin = begin_anew(options);
  const fs::path from = options.from.value_or(begin.folder);
  begin.from_stage = options.from_stage;
  begin.checkpoint = find_stage(from, *options.from_stage);
  check_same_stages(begin.input.scene, *begin.checkpoint, *options.from_stage);
  check_replaceable(begin);
  if (fs::weakly_canonical(from) != fs::weakly_canonical(begin.folder)) {
    begin.other_folder = from;
    begin.checkpoint->checkpoint.frames = {};
  }
  return begin;
}

Begin begin_again(const RunOptions& options) {
  FoundCheckpoint found = find_checkpoint(*options.resume);
  for (const std::string& damage : found.damaged)
    print_note(fmt::format("{}; resumes from {}", damage, found.path.filename().string()));
  RunPlan plan = found.checkpoint.plan;
  plan.most_steps = options.steps.value_or(plan.most_steps);
  const std::int64_t done = found.checkpoint.outcome.steps;
  if (plan.most_steps < done) {
    throw BadInput("--steps", "", fmt::format("{}", plan.most_steps),
                   fmt::format("{} or more: {} is of that step", done, found.path.string()));
  }
  plan.until_rest = plan.until_rest || options.until_rest;
  plan.no_picture = plan.no_picture || options.no_picture;
  plan.strict = plan.strict || options.strict;
  plan.checkpoint_every = options.checkpoint_every.value_or(plan.checkpoint_every);
  Scene scene = as_input([&] { return read_scene_text(plan.scene, plan.source, plan.scene_folder); });
  return {.plan = std::move(plan),
          .input = load_scene_input(std::move(scene)),
          .folder = *options.resume,
          .checkpoint = std::move(found)};
}

}  // namespace

void copy_earlier_rows(const Begin& begin) {
  if (!begin.other_folder) return;
  const Checkpoint& checkpoint = begin.checkpoint->checkpoint;
  const auto rows = [&](const char* name, std::uint64_t bytes) {
    return as_input([&] {
      return io::read_file(*begin.other_folder / name, "the rows of the earlier run").substr(0, bytes);
    });
  };
  const std::string metrics = rows("metrics.csv", checkpoint.metrics_bytes);
  const std::string forces = rows("forces.csv", checkpoint.forces_bytes);
  io::write_atomically(begin.folder / "metrics.csv", metrics);
  io::write_atomically(begin.folder / "forces.csv", forces);
}

Begin begin_run(const RunOptions& options) {
  if (options.resume) return begin_again(options);
  return options.from_stage ? begin_from_stage(options) : begin_anew(options);
}

}  // namespace palpate::app
