#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <palpate/relax.hpp>

#include "exit_codes.hpp"
#include "io/atomic_file.hpp"
#include "io/machine.hpp"
#include "measure/paper.hpp"
#include "messages.hpp"
#include "numbers.hpp"
#include "option_values.hpp"
#include "scene/json_text.hpp"
#include "scene_input.hpp"
#include "stopwatch.hpp"
#include "subcommands.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 8> item_ids{"table-1", "figure-6",  "figure-7",   "sorting",
                                                   "z-curve", "cell-size", "structures", "table-2"};

constexpr const char* examples = R"(Examples:
  palpate bench paper --quick                  the paper's results, measured anew; to results/bench-paper
  palpate bench paper --full --out report

Writes report.json: for each item of the paper what it found, our figures, and whether they agree. All ways
measure the same positions in turns, and a way that finds other contacts is an error. './dev bench paper' makes
report.html and pictures of it.)";

struct PaperOptions {
  fs::path scenes = "scenes";
  fs::path out = fs::path("results") / "bench-paper";
  bool quick = false;
  bool full = false;
  bool json = false;
  std::optional<std::string> only;
};

/// An item of the report, and how it is measured.
struct Item {
  std::string_view id;
  std::function<measure::Section()> measure;
};

/// 1, 2, 4 … threads, up to all of the machine.
std::vector<int> thread_counts() {
  const int most = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  std::vector<int> counts;
  for (int n = 1; n <= most; n *= 2) counts.push_back(n);
  if (counts.back() != most) counts.push_back(most);
  return counts;
}

measure::PaperEffort effort_of(const PaperOptions& options) {
  measure::PaperEffort effort{.threads = thread_counts()};
  if (options.full) {
    effort.stacking_steps = 1000;
    effort.organ_steps = 200;
    effort.rounds = 3;
    effort.error_steps = 300;
  }
  return effort;
}

/// Of a unit of length as scenes name it; scenes of the paper are in m or mm.
double meters(const Units& units) {
  return units.length == "mm" ? 1e-3 : units.length == "cm" ? 1e-2 : 1.0;
}

std::vector<measure::PaperScene> read_scenes(const fs::path& folder) {
  std::vector<measure::PaperScene> scenes;
  for (const char* name : {"stacking", "eye", "skull"}) {
    SceneInput input = read_scene_input(folder / (std::string(name) + ".json"));
    const Scene& scene = input.scene;
    if (scene.relax) relax(input.model, scene.settings, *scene.relax);
    scenes.push_back({name, std::move(input.model), scene.settings, meters(scene.units)});
  }
  return scenes;
}

Json machine_json() {
  const io::Machine machine = io::describe_machine();
  return {{"cpu", machine.cpu},
          {"cores", machine.cores},
          {"compiler", machine.compiler},
          {"build_type", machine.build_type},
          {"commit", machine.commit}};
}

int paper(const PaperOptions& options) {
  const std::vector<measure::PaperScene> scenes = read_scenes(options.scenes);
  const measure::PaperEffort effort = effort_of(options);
  std::vector<Item> items{{"table-1", [&] { return measure::scene_statistics(scenes); }},
                          {"figure-6", [&] { return measure::stacking_timings(scenes[0], effort); }},
                          {"figure-7", [&] { return measure::eye_timings(scenes[1], effort); }},
                          {"sorting", [&] { return measure::sort_timings(effort); }},
                          {"z-curve", [&] { return measure::order_timings(scenes, effort); }},
                          {"cell-size", [&] { return measure::cell_sizes(scenes, effort); }},
                          {"structures", [&] { return measure::structures(scenes, effort); }},
                          {"table-2", [&] { return measure::approximate_errors(scenes, effort); }}};
  if (options.only) std::erase_if(items, [&](const Item& item) { return item.id != *options.only; });
  Json report{{"kind", "paper"}, {"machine", machine_json()}, {"effort", options.full ? "full" : "quick"}};
  report["sections"] = Json::array();
  Stopwatch watch;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const measure::Section section = items[i].measure();
    report["sections"].push_back(to_json(section));
    say_progress(fmt::format("{} of {}: {}: {}, {} s", i + 1, items.size(), section.title,
                             measure::verdict_names[static_cast<std::size_t>(section.verdict)],
                             short_text(watch.lap())));
  }
  const std::string text = format_json(report) + "\n";
  io::create_folder(options.out);
  io::write_atomically(options.out / "report.json", text);
  if (options.json) print_out(text);
  if (!options.json) print_out(fmt::format("report        {}\n", (options.out / "report.json").string()));
  return exit_done;
}

}  // namespace

std::vector<Subcommand> add_bench(CLI::App& command) {
  CLI::App* bench = command.add_subcommand("bench", "measure, and compare with the paper");
  bench->footer(examples);
  bench->require_subcommand(1);
  CLI::App* app = bench->add_subcommand("paper", "the paper's results, measured anew");
  auto options = std::make_shared<PaperOptions>();
  auto* quick = app->add_flag("--quick", options->quick, "a few minutes on two cores (default)");
  app->add_flag("--full", options->full, "more frames and rounds: half an hour")->excludes(quick);
  add_value(*app, "--out", "DIR", "folder of the report; default: results/bench-paper",
            [options](const std::string&, const std::string& text) { options->out = text; });
  add_value(*app, "--scenes", "DIR", "folder with stacking.json, eye.json and skull.json; default: scenes",
            [options](const std::string&, const std::string& text) { options->scenes = text; });
  add_value(
      *app, "--only", "ITEM",
      "measure one item: table-1, figure-6, figure-7, sorting, z-curve, cell-size, structures or table-2",
      [options](const std::string& flag, const std::string& text) {
        options->only = std::string(item_ids[parse_choice(flag, text, item_ids)]);
      });
  add_json(*app, options->json, "print report.json");
  return {{app, [options] { return paper(*options); }}};
}

}  // namespace palpate::app
