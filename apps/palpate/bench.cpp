#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/relax.hpp>

#include "exit_codes.hpp"
#include "interrupt.hpp"
#include "io/atomic_file.hpp"
#include "measure/paper.hpp"
#include "measure/report.hpp"
#include "measure/scaling.hpp"
#include "messages.hpp"
#include "option_values.hpp"
#include "scene/json_text.hpp"
#include "scene_input.hpp"
#include "subcommands.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 8> paper_items{"table-1", "figure-6",  "figure-7",   "sorting",
                                                      "z-curve", "cell-size", "structures", "table-2"};
constexpr std::array<std::string_view, 3> scaling_items{"growth", "threads", "step-growth"};

constexpr const char* bench_examples = R"(Examples:
  palpate bench paper --quick                  the paper's results on this machine; writes results/bench-paper
  palpate bench peers                          the same contacts by other libraries; writes results/bench-peers
  palpate bench scaling --full                 up to ten million tets; writes results/bench-scaling
  palpate bench speed --only query             our goals of speed; writes results/bench-speed
  palpate bench step --quick                   whole steps of many scenes; writes results/bench-step

All but 'speed' and 'step' write report.json. All methods get the same positions, alternately. A method that finds other
contacts ends the benchmark with an error. './dev bench --quick' runs the first three and makes one report.html with
pictures. Ctrl-C ends 'paper' and 'scaling' after the current item, the others after the current scene; the files have
what is finished.)";

struct ReportOptions {
  fs::path out;
  bool quick = false;
  bool full = false;
  bool json = false;
  std::optional<std::string> only{};
};
struct PaperOptions : ReportOptions {
  PaperOptions() : ReportOptions{.out = fs::path("results") / "bench-paper"} {}
  fs::path scenes = "scenes";
};
struct ScalingOptions : ReportOptions {
  ScalingOptions() : ReportOptions{.out = fs::path("results") / "bench-scaling"} {}
  double most_tets = 1e300;
};

measure::PaperEffort effort_of(const PaperOptions& options) {
  measure::PaperEffort effort{.threads = measure::thread_counts()};
  if (options.full) {
    effort.stacking_steps = 1000;
    effort.organ_steps = 200;
    effort.rounds = 3;
    effort.error_steps = 300;
  }
  return effort;
}

std::vector<measure::PaperScene> read_scenes(const fs::path& folder) {
  std::vector<measure::PaperScene> scenes;
  for (const char* name : {"stacking", "eye", "skull"}) {
    SceneInput input = read_scene_input({.file = folder / (std::string(name) + ".json"), .changes = {}});
    const Scene& scene = input.scene;
    if (scene.relax) relax(input.model, scene.settings, *scene.relax);
    scenes.push_back(
        {name, std::move(input.model), scene.settings, to_si(1.0, scene.units, dimension::length)});
  }
  return scenes;
}

/// Measures the items, or the one that is wanted, and writes report.json.
int report(std::string_view kind, const ReportOptions& options, std::vector<measure::Item> items) {
  if (options.only) std::erase_if(items, [&](const measure::Item& item) { return item.id != *options.only; });
  Json report = measure::report_of(kind, options.full ? "full" : "quick");
  const fs::path file = options.out / "report.json";
  const InterruptFlag interrupt;
  measure::measure_items(report, items, file, say_progress, [&] { return interrupt.requested(); });
  print_out(options.json ? format_json(report) + "\n" : fmt::format("report        {}\n", file.string()));
  return exit_done;
}

int paper(const PaperOptions& options) {
  const std::vector<measure::PaperScene> scenes = read_scenes(options.scenes);
  const measure::PaperEffort effort = effort_of(options);
  return report("paper", options,
                {{"table-1", [&] { return measure::scene_statistics(scenes); }},
                 {"figure-6", [&] { return measure::stacking_timings(scenes[0], effort); }},
                 {"figure-7", [&] { return measure::eye_timings(scenes[1], effort); }},
                 {"sorting", [&] { return measure::sort_timings(effort); }},
                 {"z-curve", [&] { return measure::order_timings(scenes, effort); }},
                 {"cell-size", [&] { return measure::cell_sizes(scenes, effort); }},
                 {"structures", [&] { return measure::structures(scenes, effort); }},
                 {"table-2", [&] { return measure::approximate_errors(scenes, effort); }}});
}

int scaling(const ScalingOptions& options) {
  const measure::ScalingEffort effort = options.full ? measure::full_scaling() : measure::quick_scaling();
  // The sweep over sizes starts with the same smallest size for all items.
  if (options.most_tets < effort.tets.front()) {
    throw BadInput("--most-tets", "", fmt::format("'{}'", options.most_tets),
                   fmt::format("at least {}, for one size", effort.tets.front()));
  }
  return report("scaling", options,
                {{"growth", [&] { return measure::growth(effort, options.most_tets); }},
                 {"threads", [&] { return measure::thread_scaling(effort, options.most_tets); }},
                 {"step-growth", [&] { return measure::step_growth(effort, options.most_tets); }}});
}

/// Adds the options that both subcommands have.
void add_report_options(CLI::App& app, ReportOptions& options, std::span<const std::string_view> items) {
  auto* quick = app.add_flag("--quick", options.quick, "a few minutes on two cores (default)");
  app.add_flag("--full", options.full, "more frames, rounds or sizes: half an hour")->excludes(quick);
  add_value(app, "--out", "DIR", "folder of the report; default: " + options.out.string(),
            [&options](const std::string&, const std::string& text) { options.out = text; });
  add_value(app, "--only", "ITEM", fmt::format("measure one item: {}", fmt::join(items, ", ")),
            [&options, items](const std::string& flag, const std::string& text) {
              options.only = std::string(items[parse_choice(flag, text, items)]);
            });
  add_json(app, options.json, "print report.json");
}

}  // namespace

std::vector<Subcommand> add_bench(CLI::App& command) {
  CLI::App* bench =
      command.add_subcommand("bench", "measure, and compare with the paper and other libraries");
  bench->footer(bench_examples);
  bench->require_subcommand(1);
  bench->add_subcommand("peers", "the same contacts by Embree, CGAL, Bullet, VTK and others");
  bench->add_subcommand("speed", "our goals of speed: detection, dynamics, whole steps");
  bench->add_subcommand("step", "whole steps of many scenes: solves, iterations, work, how they end");
  CLI::App* of_paper = bench->add_subcommand("paper", "the paper's results on this machine");
  auto paper_options = std::make_shared<PaperOptions>();
  add_report_options(*of_paper, *paper_options, paper_items);
  add_value(*of_paper, "--scenes", "DIR",
            "folder with stacking.json, eye.json and skull.json; default: scenes",
            [paper_options](const std::string&, const std::string& text) { paper_options->scenes = text; });
  CLI::App* of_scaling = bench->add_subcommand("scaling", "time and memory against size and threads");
  auto scaling_options = std::make_shared<ScalingOptions>();
  add_report_options(*of_scaling, *scaling_options, scaling_items);
  add_value(*of_scaling, "--most-tets", "N", "leave out scenes of more tets",
            [scaling_options](const std::string& flag, const std::string& text) {
              scaling_options->most_tets =
                  static_cast<double>(parse_integer(flag, text, 1, std::int64_t{1} << 40));
            });
  return {{of_paper, [paper_options] { return paper(*paper_options); }},
          {of_scaling, [scaling_options] { return scaling(*scaling_options); }}};
}

}  // namespace palpate::app
