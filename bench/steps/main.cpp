// palpate bench step: whole steps of many scenes. A program of its own, because its scenes belong to the
// benchmarks.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fnmatch.h>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "exit_codes.hpp"
#include "interrupt.hpp"
#include "io/atomic_file.hpp"
#include "measure/report.hpp"
#include "messages.hpp"
#include "numbers.hpp"
#include "option_values.hpp"
#include "scene/json_text.hpp"
#include "steps/catalogue.hpp"
#include "steps/scene_row.hpp"
#include "steps/table.hpp"
#include "stopwatch.hpp"
#include "timing.hpp"
#include "usage.hpp"

namespace palpate::bench {
namespace {

namespace fs = std::filesystem;

constexpr const char* examples = R"(Examples:
  palpate bench step --quick                      small scenes, few steps: a few minutes; to results/bench-step
  palpate bench step --rough ../shared/data/rough --skull ../shared/data/reference/skull_headsq
  palpate bench step --only 'beam-*' --only slabs-10-1GPa --steps 5
  palpate bench step --only eye --preconditioner jacobi --json

Writes DIR/step-scenes.json after each scene. Work is the time of the solver in products with the matrix of the scene: the least
time of many, taken between the steps. One thread unless --threads says otherwise, in processor time. A scene that fails has a row
that says why, and the benchmark then ends with 1. Ctrl-C ends it after the scene; the file keeps those before. './dev bench step'
finds all scenes itself; those of CTs are there once './dev run scenes/eye-ct.json' and the like have made them.)";

struct Options : StepEffort {
  StepPlaces places;
  fs::path out = fs::path("results") / "bench-step";
  std::vector<std::string> only;
  bool list = false;
  bool json = false;
};

void add_scene_options(CLI::App& app, Options& options) {
  app.add_option("--only", options.only, "scenes of this name, or pattern with * and ?; may be repeated")
      ->type_name("NAME")
      ->allow_extra_args(false);
  app::add_value(app, "--most-tets", "N", "leave out scenes of more tets",
                 [&](const std::string& flag, const std::string& text) {
                   options.most_tets =
                       static_cast<std::size_t>(app::parse_integer(flag, text, 1, std::int64_t{1} << 40));
                 });
  app::add_value(app, "--scenes", "DIR", "folder with stacking.json, eye.json, skull.json; default: scenes",
                 [&](const std::string&, const std::string& text) { options.places.scenes = text; });
  app::add_value(app, "--rough", "DIR", "folder with other scene files; default: without them",
                 [&](const std::string&, const std::string& text) { options.places.rough = text; });
  app::add_value(app, "--skull", "DIR", "folder with the meshes of the head; default: without it",
                 [&](const std::string&, const std::string& text) { options.places.skull = text; });
  app.add_flag("--list", options.list, "print the names of the scenes, and measure none");
}

void add_options(CLI::App& app, Options& options) {
  add_scene_options(app, options);
  app.add_flag("--quick", options.quick, fmt::format("few steps, and scenes of at most {} tets", quick_tets));
  app::add_value(app, "--steps", "N", "steps of each scene; default: the scene's own number",
                 [&](const std::string& flag, const std::string& text) {
                   options.steps = static_cast<int>(app::parse_integer(flag, text, 1, 1000000));
                 });
  app::add_value(app, "--preconditioner", "NAME",
                 fmt::format("instead of each scene's: {}", fmt::join(preconditioner_names, ", ")),
                 [&](const std::string& flag, const std::string& text) {
                   options.preconditioner =
                       static_cast<Preconditioner>(app::parse_choice(flag, text, preconditioner_names));
                 });
  app::add_value(app, "--tolerance", "X", "instead of each scene's",
                 [&](const std::string& flag, const std::string& text) {
                   options.tolerance = app::parse_number(flag, text, scene_format::above(0.0));
                 });
  app::add_value(app, "--reference", "X",
                 "run each scene again with this tolerance, and compare the last positions",
                 [&](const std::string& flag, const std::string& text) {
                   options.reference = app::parse_number(flag, text, scene_format::above(0.0));
                 });
  app::add_threads(app, options.threads);
  app::add_value(app, "--out", "DIR", "folder of the results; default: results/bench-step",
                 [&](const std::string&, const std::string& text) { options.out = text; });
  app::add_json(app, options.json, "print step-scenes.json");
}

/// Keeps the scenes that are asked for by name.
void keep_wanted(StepCatalogue& catalogue, const Options& options) {
  for (const std::string& pattern : options.only) {
    const auto fits = [&](const auto& scene) { return fnmatch(pattern.c_str(), scene.name.c_str(), 0) == 0; };
    if (std::ranges::any_of(catalogue.scenes, fits)) continue;
    const auto absent = std::ranges::find_if(catalogue.absent, fits);
    if (absent != catalogue.absent.end())
      throw app::BadInput("--only", pattern, absent->reason, "a scene that is there");
    throw app::BadInput("--only", "", "'" + pattern + "'", "a scene's name (--list prints them)");
  }
  const auto unwanted = [&](const auto& scene) {
    return !options.only.empty() && std::ranges::none_of(options.only, [&](const std::string& pattern) {
      return fnmatch(pattern.c_str(), scene.name.c_str(), 0) == 0;
    });
  };
  std::erase_if(catalogue.scenes, unwanted);
  std::erase_if(catalogue.absent, unwanted);
}

Json head(const Options& options) {
  Json head = measure::report_of("step-scenes", options.steps   ? "other steps"
                                                : options.quick ? "quick"
                                                                : "full");
  head.erase("sections");
  head["references"] = machine_references();
  head["threads"] = options.threads;
  head["rows"] = Json::array();
  head["left_out"] = Json::array();
  return head;
}

void record_load(Json& report) {
  std::array<double, 1> load{};
  if (getloadavg(load.data(), 1) == 1) report["load"] = std::max(load[0], report.value("load", 0.0));
}

/// Measures scene after scene; the file is rewritten after each.
Json measure_scenes(const StepCatalogue& catalogue, const Options& options) {
  Json report = head(options);
  for (const AbsentScene& absent : catalogue.absent)
    report["left_out"].push_back({{"name", absent.name}, {"reason", absent.reason}});
  const fs::path file = options.out / "step-scenes.json";
  io::create_folder(options.out);
  const app::InterruptFlag interrupt;
  Stopwatch watch;
  for (std::size_t i = 0; i < catalogue.scenes.size() && !interrupt.requested(); ++i) {
    const StepScene& scene = catalogue.scenes[i];
    const bool too_large = scene.tets > options.most_tets;
    const Json row = too_large ? Json() : scene_row(scene, options);
    if (row.is_null()) {
      report["left_out"].push_back(
          {{"name", scene.name}, {"reason", "too many tets (--most-tets, --quick)"}});
    } else {
      report["rows"].push_back(row);
    }
    report["complete"] = i + 1 == catalogue.scenes.size();
    record_load(report);
    io::write_atomically(file, format_json(report) + "\n");
    app::say_progress(
        fmt::format("{} of {}: {}, {:.1f} s", i + 1, catalogue.scenes.size(), scene.name, watch.lap()));
  }
  return report;
}

int exit_code(const Json& report) {
  std::vector<std::string> failed;
  for (const Json& row : report.at("rows"))
    if (!row.at("error").is_null()) failed.push_back(row.at("name").get<std::string>());
  if (!failed.empty()) {
    throw std::runtime_error(
        fmt::format("{} failed: {}", app::counted(failed.size(), "scene"), fmt::join(failed, ", ")));
  }
  if (!report.at("complete").get<bool>())
    throw std::runtime_error(
        fmt::format("interrupted; {} measured", app::counted(report.at("rows").size(), "scene")));
  return app::exit_done;
}

int list_scenes(const StepCatalogue& catalogue) {
  std::string text;
  for (const StepScene& scene : catalogue.scenes) text += scene.name + "\n";
  for (const AbsentScene& absent : catalogue.absent)
    text += fmt::format("{}: {}\n", absent.name, absent.reason);
  app::print_out(text);
  return app::exit_done;
}

int work(int argc, const char* const* argv) {
  CLI::App command("Whole steps of many scenes: solves, iterations, work and how they end.",
                   "palpate bench step");
  command.footer(examples);
  Options options;
  add_options(command, options);
  if (app::parse_or_explain(command, argc, argv)) return app::exit_done;
  if (options.quick) options.most_tets = std::min(options.most_tets, quick_tets);
  StepCatalogue catalogue = app::as_input([&] { return step_catalogue(options.places); });
  keep_wanted(catalogue, options);
  if (options.list) return list_scenes(catalogue);
  const Json report = measure_scenes(catalogue, options);
  app::print_out(options.json ? format_json(report) + "\n" : steps_table(report));
  return exit_code(report);
}

}  // namespace
}  // namespace palpate::bench

int main(int argc, char** argv) {
  return palpate::app::as_exit_code([&] { return palpate::bench::work(argc, argv); });
}
