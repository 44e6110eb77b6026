// palpate bench speed: measures our goals of speed. A program of its own, because the command contains no
// Eigen solvers and no TBB.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <initializer_list>
#include <optional>
#include <stdexcept>
#include <string>

#include "exit_codes.hpp"
#include "interrupt.hpp"
#include "io/atomic_file.hpp"
#include "measure/report.hpp"
#include "messages.hpp"
#include "option_values.hpp"
#include "scene/json_text.hpp"
#include "speed/callgrind.hpp"
#include "speed/part.hpp"
#include "speed/rows.hpp"
#include "timing.hpp"
#include "usage.hpp"

namespace palpate::bench {
namespace {

namespace fs = std::filesystem;

constexpr const char* examples = R"(Examples:
  palpate bench speed                                   all tables, half an hour; to results/bench-speed
  palpate bench speed --only query --most-tets 200000   contacts beside Embree, without large scenes
  palpate bench speed --only step --skull ../shared/data/reference/skull_headsq --json
  palpate bench speed --only instructions               counts of valgrind: the same on a busy machine

Each part writes DIR/PART.json. Ctrl-C ends the benchmark after the current case. A ratio is how many times as long
the other side takes, unless its bound is '≤'; 'must' and 'aim' are what we set out to reach. All find the same or
reach the same error: else the benchmark ends with 1. Without --skull (hq_skull.mesh, hq_lower.mesh, hq_upper.mesh,
hq_soft.mesh) and --raptors (raptorTetra_8418.vtu, raptorTetra_19409.vtu) the rows of these are left out. './dev
bench speed' finds scenes, skull and raptors itself; './dev bench instructions' compares with the counts kept.)";

constexpr std::array<std::string_view, 8> part_names{"query",    "handling", "threads", "movers",
                                                     "dynamics", "step",     "tissue",  "instructions"};
constexpr std::array part_makers{query_part,    handling_part, threads_part, movers_part,
                                 dynamics_part, step_part,     tissue_part,  instructions_part};

struct Options : SpeedEffort {
  fs::path out = fs::path("results") / "bench-speed";
  std::optional<std::size_t> only;
  bool json = false;
};

void add_options(CLI::App& app, Options& options) {
  app::add_value(app, "--only", "PART", fmt::format("measure one part: {}", fmt::join(part_names, ", ")),
                 [&](const std::string& flag, const std::string& text) {
                   options.only = app::parse_choice(flag, text, part_names);
                 });
  app::add_value(app, "--out", "DIR", "folder of the results; default: results/bench-speed",
                 [&](const std::string&, const std::string& text) { options.out = text; });
  app::add_value(app, "--frames", "N",
                 "frames that a figure is the median of; default: each part has its own number",
                 [&](const std::string& flag, const std::string& text) {
                   options.frames = static_cast<int>(app::parse_integer(flag, text, 1, 10000));
                 });
  app::add_value(app, "--most-tets", "N", "leave out scenes of more tets; instructions: count on fewer",
                 [&](const std::string& flag, const std::string& text) {
                   options.most_tets =
                       static_cast<double>(app::parse_integer(flag, text, 1, std::int64_t{1} << 40));
                 });
  app::add_value(app, "--scenes", "DIR", "folder with stacking.json, eye.json, skull.json; default: scenes",
                 [&](const std::string&, const std::string& text) { options.scenes = text; });
  app::add_value(app, "--skull", "DIR", "folder with the meshes of a skull; default: without it",
                 [&](const std::string&, const std::string& text) { options.skull = text; });
  app::add_value(app, "--raptors", "DIR", "folder with the meshes of two raptors; default: without them",
                 [&](const std::string&, const std::string& text) { options.raptors = text; });
  app::add_json(app, options.json, "print tables and counts as JSON");
}

bool is_chosen(const Options& options, std::string_view part) {
  return !options.only || part_names[*options.only] == part;
}

/// Throws Error for missing files, which would otherwise be noticed after half an hour.
void check(const Options& options) {
  const auto check_folder = [](const char* flag, const fs::path& folder, const char* of,
                               std::initializer_list<const char*> files) {
    if (folder.empty()) return;
    for (const char* file : files) {
      if (fs::exists(folder / file)) continue;
      throw app::BadInput(flag, "", fmt::format("no '{}'", (folder / file).string()),
                          fmt::format("a folder with the meshes of {}", of));
    }
  };
  check_folder("--skull", options.skull, "a skull",
               {"hq_skull.mesh", "hq_lower.mesh", "hq_upper.mesh", "hq_soft.mesh"});
  check_folder("--raptors", options.raptors, "two raptors",
               {"raptorTetra_8418.vtu", "raptorTetra_19409.vtu"});
  const fs::path scene = options.scenes / "stacking.json";
  if (is_chosen(options, "step") && !fs::exists(scene)) {
    throw app::BadInput("--scenes", "", fmt::format("no '{}'", scene.string()),
                        "a folder with stacking.json");
  }
  const std::string reason = why_not_counted();
  if (reason.empty() || !is_chosen(options, "instructions")) return;
  if (options.only) {
    throw app::BadInput("--only", "", fmt::format("instructions, but {}", reason),
                        "a build and a machine with valgrind");
  }
  app::print_note("instructions are left out: " + reason);
}

/// The common first part of all files.
Json head() {
  Json head = measure::report_of("speed", "");
  head.erase("effort");
  head.erase("complete");
  head.erase("sections");
  head["references"] = machine_references();
  return head;
}

std::string text_of(const Json& report) {
  const Json& machine = report.at("machine");
  const Json& references = report.at("references");
  std::string text = fmt::format(
      "{}, {} cores, one used unless said; {}, {}; commit {}\n"
      "memcpy of 64 MiB {:.1f} GB/s, std::sort of 1e6 floats {:.1f} ms, 20 million dependent multiply-adds "
      "{:.1f} ms (on the machine of SOFA's times: 22.4 to 23.7 GB/s, 68 ms, 70 ms)\n\n",
      machine.at("cpu").get<std::string>(), machine.at("cores").get<int>(),
      machine.at("compiler").get<std::string>(), machine.at("build_type").get<std::string>(),
      machine.at("commit").get<std::string>(), references.at("memcpy_GB_per_s").get<double>(),
      references.at("sort_ms").get<double>(), references.at("multiply_add_ms").get<double>());
  text += table_text(report.at("rows"));
  for (const Json& kernel : report.at("instructions")) {
    const Json& parallel = kernel.at("parallel");
    text += fmt::format("{:<26} {:>10.1f} instructions a {}, {:.0f} % in parallel loops; with",
                        kernel.at("name").get<std::string>(), kernel.at("per_unit").get<double>(),
                        kernel.at("unit").get<std::string>(), 100.0 * parallel.at("share").get<double>());
    for (const auto& [threads, faster] : parallel.at("speed_up").items())
      text += fmt::format(" {}: {:.2f}×", threads, faster.get<double>());
    text += " threads\n";
  }
  return text;
}

/// The parts that are wanted, with the scenes that are.
std::vector<Part> wanted_parts(const Options& options) {
  std::vector<Part> parts;
  for (std::size_t p = 0; p < part_names.size(); ++p) {
    if (!is_chosen(options, part_names[p])) continue;
    if (part_names[p] == "instructions" && !why_not_counted().empty()) continue;
    Part part = part_makers[p](options);
    std::erase_if(part.cases, [&](const Case& c) { return c.tets > options.most_tets; });
    if (options.only && part.cases.empty()) {
      throw app::BadInput("--most-tets", "", fmt::format("'{}'", options.most_tets),
                          fmt::format("at least 10000, for a scene of '{}'", part.name));
    }
    parts.push_back(std::move(part));
  }
  return parts;
}

/// Measures the parts; returns what is printed.
Json measure_parts(const Options& options) {
  const app::InterruptFlag interrupt;
  const std::vector<Part> parts = wanted_parts(options);
  const Json begin = head();
  Json report = begin;
  report["rows"] = Json::array();
  report["instructions"] = Json::array();
  io::create_folder(options.out);
  for (const Part& part : parts) {
    const fs::path file = options.out / (std::string(part.name) + ".json");
    const Json result = run_part(part, begin, file, [&](const std::string& line) {
      app::say_progress(line);
      if (interrupt.requested())
        throw std::runtime_error(fmt::format("interrupted; {} has the cases that are done", file.string()));
    });
    for (const Json& row : result.at("table")) report["rows"].push_back(row);
    if (part.name == "instructions") report["instructions"] = result.at("cases");
    report["load"] = std::max(report.at("load").get<double>(), result.at("load").get<double>());
  }
  return report;
}

int work(int argc, const char* const* argv) {
  CLI::App command("What we set out to reach, measured: detection, dynamics, whole steps.",
                   "palpate bench speed");
  command.footer(examples);
  Options options;
  add_options(command, options);
  if (app::parse_or_explain(command, argc, argv)) return app::exit_done;
  check(options);
  const Json report = measure_parts(options);
  app::print_out(options.json ? format_json(report) + "\n" : text_of(report));
  return app::exit_done;
}

}  // namespace
}  // namespace palpate::bench

int main(int argc, char** argv) {
  return palpate::app::as_exit_code([&] { return palpate::bench::work(argc, argv); });
}
