#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fmt/format.h>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include <palpate/version.hpp>

#include "conforming_output.hpp"
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

/// The folder for the results. Without `--replace` the default folder must not exist yet, and another one
/// must hold no scene, since its user may have changed it.
fs::path output_folder(const MeshOptions& options) {
  fs::path folder = options.out.value_or(input_name(options) + "-bodies");
  std::error_code ignored;
  if (options.replace) return folder;
  if (!options.out && fs::exists(folder, ignored)) {
    throw BadInput(folder.string(), "", "an existing folder",
                   "a new name (--out), or --replace to write over its scene and meshes");
  }
  const fs::path scene = folder / "scene.json";
  if (fs::exists(scene, ignored)) {
    throw BadInput(scene.string(), "", "an existing file",
                   "a new folder (--out), or --replace to write over the scene and its meshes");
  }
  return folder;
}

/// Shows on one line what is being meshed. Stops at an interrupt.
class Progress {
 public:
  explicit Progress(bool quiet) : status_(quiet) {}
  void starts(std::string doing) {
    doing_ = std::move(doing);
    show();
  }
  void check() {
    show();
    if (interrupt_.requested()) throw std::runtime_error("interrupted; nothing was written");
  }

 private:
  void show() {
    status_.update([&](std::size_t width) { return doing_.substr(0, width); });
  }
  InterruptFlag interrupt_;
  StatusLine status_;
  std::string doing_;
};

MeshedOrgans mesh_with_progress(const std::vector<Organ>& organs, MeshOptions& options) {
  constexpr double default_tets = 10000.0;
  Fineness& fineness = options.fineness;
  if (fineness.size <= 0.0 && fineness.tets <= 0.0 && fineness.tets_each <= 0.0) fineness.tets = default_tets;
  Progress progress(options.quiet);
  std::size_t meshings = 0;
  const auto starts = [&](std::size_t organ, double size) {
    progress.starts(fmt::format("meshing {} ({} of {}), size {} mm, mesh number {}", organs[organ].name,
                                organ + 1, organs.size(), short_text(size), ++meshings));
  };
  return mesh_organs(organs, fineness, starts, [&] { progress.check(); });
}

/// The keys that the reports of both kinds of meshes begin with.
nlohmann::ordered_json report_head(const MeshOptions& options, const std::string& scene, double seconds,
                                   const std::vector<std::string>& warnings) {
  return {{"scene", utf8_text(scene)},
          {"space", options.ras ? "RAS" : "LPS"},
          {"unit", "mm"},
          {"seconds", seconds},
          {"warnings", warnings}};
}

void print_json(const nlohmann::ordered_json& json) {
  constexpr int indent = 2;
  print_out(json.dump(indent) + "\n");
}

void report(const MeshOptions& options, const fs::path& folder, const std::vector<OrganReport>& reports,
            const std::vector<std::string>& warnings, double seconds) {
  const std::string scene = (folder / "scene.json").string();
  if (options.json) {
    nlohmann::ordered_json json = report_head(options, scene, seconds, warnings);
    json["organs"] = nlohmann::ordered_json::array();
    for (const OrganReport& organ : reports) json["organs"].push_back(report_json(organ));
    print_json(json);
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

void mesh_each(MeshOptions& options, const fs::path& folder) {
  Stopwatch watch;
  const OrganList list = as_input([&] { return read_organs(options); });
  MeshedOrgans meshed = mesh_with_progress(list.organs, options);
  std::vector<std::string> warnings = list.warnings;
  std::ranges::move(meshed.warnings, std::back_inserter(warnings));
  SceneFolder scene_folder(folder);
  const auto reports = write_bodies(scene_folder, options, list.organs, std::move(meshed.organs), warnings);
  report(options, folder, reports, warnings, watch.lap());
}

void mesh_together(MeshOptions& options, const fs::path& folder) {
  constexpr double default_smoothing = 0.5;  // so that layers of one voxel stay whole
  if (!options.shaping.smoothing_given) options.shaping.smoothing = default_smoothing;
  Stopwatch watch;
  const NamedMap map = as_input([&] { return read_named_map(options); });
  const TissuePlan plan = plan_of(options, map);
  as_input([&] { check_plan(plan, map); });
  Progress progress(options.quiet);
  int meshings = 0;
  const MeshingProgress told{
      .starts =
          [&](double size) {
            progress.starts(fmt::format("meshing, size {} mm, mesh number {}", short_text(size), ++meshings));
          },
      .check = [&] { progress.check(); }};
  ConformingMesh made = as_input([&] { return mesh_conforming(map, plan, options, told); });
  const std::size_t tets = made.mesh.mesh.tets.size();
  SceneFolder scene_folder(folder);
  const ConformingReport made_report = write_conforming(scene_folder, options, map, plan, std::move(made));
  const double seconds = watch.lap();
  std::vector<std::string> warnings = map.warnings;
  for (const auto& more : {label_warnings(map), made_report.warnings})
    warnings.insert(warnings.end(), more.begin(), more.end());
  const std::string scene = (folder / "scene.json").string();
  if (options.json) {
    nlohmann::ordered_json json = report_head(options, scene, seconds, warnings);
    json.update(made_report.json);
    print_json(json);
  } else {
    print_out(made_report.text +
              fmt::format("{}: {}, {} s\n", scene, counted(tets, "tet"), short_text(seconds)));
  }
  for (const std::string& warning : warnings) say_warning(warning);
}

int work(int argc, const char* const* argv) {
  CLI::App command(std::string(mesh_description), "palpate mesh");
  command.set_version_flag("--version", [] { return "palpate mesh " PALPATE_VERSION; });
  MeshOptions options;
  add_mesh_options(command, options);
  if (parse_or_explain(command, argc, argv)) return exit_done;
  check_mesh_options(options);
  const fs::path folder = output_folder(options);

  options.conformity.wanted ? mesh_together(options, folder) : mesh_each(options, folder);
  return exit_done;
}

}  // namespace
}  // namespace palpate::app

int main(int argc, char** argv) {
  return palpate::app::as_exit_code([&] { return palpate::app::work(argc, argv); });
}
