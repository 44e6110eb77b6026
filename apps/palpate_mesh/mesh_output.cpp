#include "mesh_output.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <set>
#include <utility>

#include "io/vtu_writer.hpp"
#include "mesh_inputs.hpp"
#include "mesh_scene.hpp"
#include "numbers.hpp"

namespace palpate::app {
namespace {

std::vector<std::string> warnings_of(const OrganReport& report, bool gap) {
  constexpr double lost = 0.05;
  constexpr double thin = 5.0;  // degrees
  std::vector<std::string> warnings;
  const double wanted = gap ? report.meshed.shape_volume : report.input_volume;
  const double fraction = report.statistics.volume / wanted;
  if (report.meshed.mesh_components < report.meshed.shape_components) {
    warnings.push_back(fmt::format("{} of {} parts are in the mesh: use a smaller size",
                                   report.meshed.mesh_components, report.meshed.shape_components));
  }
  if (!report.meshed.manifold)
    warnings.emplace_back("parts of it touch in edges or points, where its surface is no manifold");
  if (fraction < 1.0 - lost || fraction > 1.0 + lost) {
    warnings.push_back(fmt::format("the mesh has {:.1f} % of the volume{}: use a smaller size than {} mm",
                                   100.0 * fraction, gap ? " that the gap leaves" : "",
                                   short_text(report.meshed.size)));
  }
  if (report.statistics.dihedral_angle.min < thin) {
    warnings.push_back(fmt::format("flat tets, {:.1f} degrees", report.statistics.dihedral_angle.min));
  }
  return warnings;
}

}  // namespace

std::vector<OrganReport> write_bodies(SceneFolder& folder, const MeshOptions& options,
                                      const std::vector<Organ>& organs, std::vector<MeshedOrgan> meshed,
                                      std::vector<std::string>& warnings) {
  Scene scene = first_scene(input_name(options));
  std::vector<OrganReport> reports;
  std::set<std::string> used;
  for (std::size_t o = 0; o < organs.size(); ++o) {
    OrganReport report{
        organs[o].name, mesh_file_name(organs[o].name, used), {}, organs[o].input_volume, {}, {}};
    const TetMesh mesh = std::exchange(meshed[o].mesh, {});
    io::write_vtu(
        folder.place(report.file),
        {.points = mesh.points, .tets = mesh.tets, .point_arrays = {}, .tet_arrays = {}, .time = {}});
    Bodies bodies;
    bodies.add(report.name, mesh);
    report.statistics = mesh_statistics(bodies, bodies.points_rest());
    report.meshed = std::move(meshed[o]);
    report.warnings = organs[o].remarks;
    std::ranges::move(warnings_of(report, options.shaping.gap > 0.0), std::back_inserter(report.warnings));
    const bool rigid = std::ranges::count(options.rigid, report.name) > 0;
    scene.bodies.push_back(first_body(report.name, report.file, rigid, organs[o].color));
    reports.push_back(std::move(report));
  }
  add_warning_of_others(folder.commit(write_scene(scene)), warnings);
  return reports;
}

nlohmann::ordered_json report_json(const OrganReport& report) {
  return {{"name", utf8_text(report.name)},
          {"file", report.file},
          {"points", report.statistics.points},
          {"edges", report.statistics.edges},
          {"triangles", report.statistics.triangles},
          {"tets", report.statistics.tets},
          {"min_dihedral_angle", report.statistics.dihedral_angle.min},
          {"volume", report.statistics.volume},
          {"input_volume", report.input_volume},
          {"shape_volume", report.meshed.shape_volume},
          {"parts", report.meshed.mesh_components},
          {"shape_parts", report.meshed.shape_components},
          {"lower", to_json(report.statistics.lower)},
          {"upper", to_json(report.statistics.upper)},
          {"size", report.meshed.size},
          {"meshings", report.meshed.meshings},
          {"seconds", report.meshed.seconds},
          {"warnings", report.warnings}};
}

std::string report_text(const std::vector<OrganReport>& reports) {
  constexpr std::size_t longest = 32;
  std::size_t width = 5;
  for (const OrganReport& report : reports) width = std::max(width, std::min(longest, report.name.size()));
  std::string text = fmt::format("{:<{}}  {:>7}  {:>9}  {:>11}  {:>11}  {:>5}  {:>8}\n", "organ", width,
                                 "tets", "min angle", "volume cm^3", "% of labels", "parts", "size mm");
  for (const OrganReport& report : reports) {
    text += fmt::format("{:<{}}  {:>7}  {:>9.1f}  {:>11.4g}  {:>11.1f}  {:>5}  {:>8.3g}\n",
                        shortened(report.name, width), width, report.statistics.tets,
                        report.statistics.dihedral_angle.min, 1e-3 * report.statistics.volume,
                        100.0 * report.statistics.volume / report.input_volume, report.meshed.mesh_components,
                        report.meshed.size);
  }
  return text;
}

}  // namespace palpate::app
