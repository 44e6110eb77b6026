#include "mesh_output.hpp"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <iterator>
#include <set>
#include <utility>

#include "io/atomic_file.hpp"
#include "io/vtu_writer.hpp"
#include "mesh_inputs.hpp"
#include "numbers.hpp"
#include "scene/scene.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

/// A file name that every system takes, other than those that are used.
std::string file_name(const std::string& organ, std::set<std::string>& used) {
  std::string stem = organ;
  std::ranges::replace_if(
      stem, [](unsigned char c) { return std::isalnum(c) == 0 && c != '-' && c != '_'; }, '-');
  std::string name = stem + ".vtu";
  for (int other = 2; !used.insert(name).second; ++other) name = fmt::format("{}-{}.vtu", stem, other);
  return name;
}

std::vector<std::string> warnings_of(const OrganReport& report, bool gap) {
  constexpr double lost = 0.05;
  constexpr double thin = 5.0;  // degrees
  std::vector<std::string> warnings;
  const double wanted = gap ? report.meshed.shape_volume : report.input_volume;
  const double share = report.statistics.volume / wanted;
  if (report.meshed.mesh_components < report.meshed.shape_components) {
    warnings.push_back(fmt::format("{} of {} parts are in the mesh: use a smaller size",
                                   report.meshed.mesh_components, report.meshed.shape_components));
  }
  if (!report.meshed.manifold)
    warnings.emplace_back("parts of it touch in edges or points, where its surface is no manifold");
  if (share < 1.0 - lost || share > 1.0 + lost) {
    warnings.push_back(fmt::format("the mesh has {:.1f} % of the volume: use a smaller size than {} mm",
                                   100.0 * share, short_text(report.meshed.size)));
  }
  if (report.statistics.dihedral_angle.min < thin) {
    warnings.push_back(fmt::format("flat tets, {:.1f} degrees", report.statistics.dihedral_angle.min));
  }
  return warnings;
}

/// Soft tissue between fat and muscle, in Pa and g/mm^3; the user knows better.
const Material tissue{.young_modulus = 20e3,
                      .poisson_ratio = 0.45,
                      .density = 1e-3,
                      .mass_damping = 5.0,
                      .stiffness_damping = 0.02};

SceneBody body_of(const Organ& organ, const std::string& file, const MeshOptions& options) {
  SceneBody body;
  body.name = organ.name;
  body.source = MeshFile{file};
  body.color = organ.color;
  body.obstacle = std::ranges::count(options.rigid, organ.name) > 0;
  if (!body.obstacle) body.material = tissue;
  return body;
}

/// In mm, g and s, so that stresses are in Pa; at rest, about to be given motions and loads.
Scene empty_scene(const std::string& name) {
  Scene scene;
  scene.name = name;
  scene.units = {"mm", "g", "s"};
  scene.settings.gravity = {};
  scene.settings.rest = {.speed = 0.1, .time = 0.1};
  scene.duration = 2.0;
  scene.relax = RelaxSettings{};
  return scene;
}

}  // namespace

std::vector<OrganReport> write_bodies(const fs::path& folder, const MeshOptions& options,
                                      const std::vector<Organ>& organs, std::vector<MeshedOrgan> meshed) {
  io::create_folder(folder);
  Scene scene = empty_scene(input_name(options));
  std::vector<OrganReport> reports;
  std::set<std::string> used;
  for (std::size_t o = 0; o < organs.size(); ++o) {
    OrganReport report{organs[o].name, file_name(organs[o].name, used), {}, organs[o].input_volume, {}, {}};
    const TetMesh mesh = std::exchange(meshed[o].mesh, {});
    io::write_vtu(
        folder / report.file,
        {.points = mesh.points, .tets = mesh.tets, .point_arrays = {}, .tet_arrays = {}, .time = {}});
    Bodies bodies;
    bodies.add(report.name, mesh);
    report.statistics = mesh_statistics(bodies, bodies.points_rest());
    report.meshed = std::move(meshed[o]);
    report.warnings = organs[o].remarks;
    std::ranges::move(warnings_of(report, options.shaping.gap > 0.0), std::back_inserter(report.warnings));
    scene.bodies.push_back(body_of(organs[o], report.file, options));
    reports.push_back(std::move(report));
  }
  io::write_atomically(folder / "scene.json", write_scene(scene));
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
  std::string text = fmt::format("{:<{}}  {:>7}  {:>9}  {:>11}  {:>8}  {:>5}  {:>8}\n", "organ", width,
                                 "tets", "min angle", "volume cm^3", "of input", "parts", "size mm");
  for (const OrganReport& report : reports) {
    text += fmt::format("{:<{}}  {:>7}  {:>9.1f}  {:>11.4g}  {:>7.1f}%  {:>5}  {:>8.3g}\n",
                        shortened(report.name, width), width, report.statistics.tets,
                        report.statistics.dihedral_angle.min, 1e-3 * report.statistics.volume,
                        100.0 * report.statistics.volume / report.input_volume, report.meshed.mesh_components,
                        report.meshed.size);
  }
  return text;
}

}  // namespace palpate::app
