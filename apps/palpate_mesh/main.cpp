#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include <palpate/version.hpp>

#include "exit_codes.hpp"
#include "interrupt.hpp"
#include "mesh_inputs.hpp"
#include "mesh_options.hpp"
#include "mesh_output.hpp"
#include "messages.hpp"
#include "numbers.hpp"
#include "organ_source.hpp"
#include "status_line.hpp"
#include "stopwatch.hpp"
#include "usage.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

/// The folder for the results; one that was not named must not be there yet.
fs::path output_folder(const MeshOptions& options) {
  if (options.out) return *options.out;
  fs::path folder = input_name(options) + "-bodies";
  std::error_code ignored;
  if (fs::exists(folder, ignored)) {
    throw BadInput(folder.string(), "", "a folder of that name already",
                   "--out FOLDER, whose files may be replaced");
  }
  return folder;
}

std::vector<MeshedOrgan> mesh_with_progress(const std::vector<Organ>& organs, MeshOptions& options) {
  constexpr double default_tets = 10000.0;
  Fineness& fineness = options.fineness;
  if (fineness.size <= 0.0 && fineness.tets <= 0.0 && fineness.tets_each <= 0.0) fineness.tets = default_tets;
  const InterruptFlag interrupt;
  StatusLine status(options.quiet);
  std::size_t meshings = 0;
  std::string doing;
  const auto line = [&](std::size_t width) { return doing.substr(0, width); };
  const auto starts = [&](std::size_t organ, double size) {
    ++meshings;
    doing = fmt::format("meshing {} ({} of {}), size {} mm, mesh number {}", organs[organ].name, organ + 1,
                        organs.size(), short_text(size), meshings);
    status.update(line);
  };
  const auto check = [&] {
    status.update(line);
    if (interrupt.requested()) throw std::runtime_error("interrupted; nothing was written");
  };
  return mesh_organs(organs, fineness, starts, check);
}

void report(const MeshOptions& options, const fs::path& folder, const std::vector<OrganReport>& reports,
            const std::vector<std::string>& warnings, double seconds) {
  const std::string scene = (folder / "scene.json").string();
  if (options.json) {
    nlohmann::ordered_json json{{"scene", utf8_text(scene)},
                                {"space", options.ras ? "RAS" : "LPS"},
                                {"unit", "mm"},
                                {"seconds", seconds},
                                {"warnings", warnings},
                                {"organs", nlohmann::ordered_json::array()}};
    for (const OrganReport& organ : reports) json["organs"].push_back(report_json(organ));
    constexpr int indent = 2;
    print_out(json.dump(indent) + "\n");
  } else {
    Index tets = 0;
    for (const OrganReport& organ : reports) tets += organ.statistics.tets;
    print_out(report_text(reports) +
              fmt::format("{}: {}, {}, {} s\n", scene,
                          reports.size() == 1 ? "1 body" : fmt::format("{} bodies", reports.size()),
                          counted(static_cast<std::size_t>(tets), "tet"), short_text(seconds)));
  }
  for (const std::string& warning : warnings) say_warning(warning);
  for (const OrganReport& organ : reports) {
    for (const std::string& warning : organ.warnings) say_warning(organ.name + ": " + warning);
  }
}

int work(int argc, const char* const* argv) {
  CLI::App command(std::string(mesh_description), "palpate mesh");
  command.set_version_flag("--version", [] { return "palpate mesh " PALPATE_VERSION; });
  MeshOptions options;
  add_mesh_options(command, options);
  if (parse_or_explain(command, argc, argv)) return exit_done;
  check_mesh_options(options);
  const fs::path folder = output_folder(options);

  Stopwatch watch;
  const OrganList list = as_input([&] { return read_organs(options); });
  std::vector<MeshedOrgan> meshed = mesh_with_progress(list.organs, options);
  const auto reports = write_bodies(folder, options, list.organs, std::move(meshed));
  report(options, folder, reports, list.warnings, watch.lap());
  return exit_done;
}

}  // namespace
}  // namespace palpate::app

int main(int argc, char** argv) {
  return palpate::app::as_exit_code([&] { return palpate::app::work(argc, argv); });
}
