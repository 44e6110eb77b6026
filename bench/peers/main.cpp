// palpate bench peers: the contacts of the library beside those of other libraries. A program of its own,
// because it contains CGAL's box_intersection_d, which is GPL.
#include <CLI/CLI.hpp>
#include <array>
#include <csignal>
#include <filesystem>
#include <fmt/format.h>
#include <optional>
#include <system_error>
#include <unistd.h>

#include "exit_codes.hpp"
#include "interrupt.hpp"
#include "io/atomic_file.hpp"
#include "measure/report.hpp"
#include "messages.hpp"
#include "option_values.hpp"
#include "peers/sections.hpp"
#include "scene/json_text.hpp"
#include "usage.hpp"

namespace palpate::bench {
namespace {

namespace fs = std::filesystem;

constexpr const char* examples = R"(Examples:
  palpate bench peers                            a few minutes; to results/bench-peers
  palpate bench peers --full --python build/peers-python/bin/python

Peers that come as Python packages (bench/peers/requirements.txt) take part where --python names a Python that has
them; './dev bench' makes one. A peer that finds other contacts than its question allows ends the benchmark with 1.)";

constexpr std::array<std::string_view, 2> task_names{"points", "edges"};

struct Options {
  fs::path out = fs::path("results") / "bench-peers";
  fs::path python;
  bool quick = false;
  bool full = false;
  bool json = false;
  double most_tets = 1e300;
  std::optional<std::size_t> only;
};

void add_options(CLI::App& app, Options& options) {
  auto* quick = app.add_flag("--quick", options.quick, "a few minutes on two cores (default)");
  app.add_flag("--full", options.full, "more frames, up to a million tets, all shares of movers")
      ->excludes(quick);
  app::add_value(app, "--out", "DIR", "folder of the report; default: results/bench-peers",
                 [&](const std::string&, const std::string& text) { options.out = text; });
  app::add_value(app, "--python", "FILE", "a Python with ipctk and pbatoolkit",
                 [&](const std::string&, const std::string& text) { options.python = text; });
  app::add_value(app, "--only", "TASK", "points or edges",
                 [&](const std::string& flag, const std::string& text) {
                   options.only = app::parse_choice(flag, text, task_names);
                 });
  app::add_value(app, "--most-tets", "N", "leave out scenes of more tets",
                 [&](const std::string& flag, const std::string& text) {
                   options.most_tets =
                       static_cast<double>(app::parse_integer(flag, text, 1, std::int64_t{1} << 40));
                 });
  app::add_json(app, options.json, "print report.json");
}

void check_python(const fs::path& python) {
  std::error_code ignored;
  if (python.empty() || (fs::is_regular_file(python, ignored) && ::access(python.c_str(), X_OK) == 0)) return;
  throw app::BadInput("--python", "", "'" + python.string() + "'", "the path of a Python that can be run");
}

int measure_peers(const Options& options) {
  check_python(options.python);
  PeersEffort effort = options.full ? full_effort() : quick_effort();
  // The pile has 82240.
  std::erase_if(effort.heats, [&](const Heat& heat) {
    return (heat.cells == 0 ? 82240.0 : 100.0 * heat.cells * heat.cells) > options.most_tets;
  });
  if (effort.heats.empty())
    throw app::BadInput("--most-tets", "", fmt::format("{}", options.most_tets),
                        "at least 10000, for one scene");
  const PythonPeers python{options.python, PALPATE_PYTHON_PEERS};
  std::vector<Absentee> absent;
  const app::InterruptFlag interrupt;
  const auto interrupted = [&] { return interrupt.requested(); };
  std::vector<measure::Item> items;
  for (const Task task : {Task::points_in_tets, Task::edges_on_triangles}) {
    if (options.only && *options.only != static_cast<std::size_t>(task)) continue;
    items.push_back({task_names[static_cast<std::size_t>(task)], [&, task] {
                       return contest_section(task, effort, python, absent, app::say_progress, interrupted);
                     }});
  }
  items.push_back({"peers", [&] { return peers_section(absent); }});
  nlohmann::ordered_json report = measure::report_of("peers", options.full ? "full" : "quick");
  const fs::path file = options.out / "report.json";
  measure::measure_items(report, items, file, app::say_progress, interrupted);
  app::print_out(options.json ? format_json(report) + "\n"
                              : fmt::format("report        {}\n", file.string()));
  return app::exit_done;
}

int work(int argc, const char* const* argv) {
  CLI::App command("Palpate's contacts beside those of other libraries.", "palpate bench peers");
  command.footer(examples);
  Options options;
  add_options(command, options);
  if (app::parse_or_explain(command, argc, argv)) return app::exit_done;
  return measure_peers(options);
}

}  // namespace
}  // namespace palpate::bench

int main(int argc, char** argv) {
  return palpate::app::as_exit_code([&] { return palpate::bench::work(argc, argv); });
}
