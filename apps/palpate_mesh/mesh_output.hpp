#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mesh_options.hpp"
#include "mesh_plan.hpp"
#include "scene_folder.hpp"

namespace palpate::app {

/// The results for an organ, as in the report.
struct OrganReport {
  std::string name;
  std::string file;  ///< name of its mesh in the folder
  MeshStatistics statistics;
  double input_volume = 0.0;  ///< mm^3
  MeshedOrgan meshed;         ///< its mesh was moved away
  std::vector<std::string> warnings;
};

/// Writes a .vtu for each organ and scene.json to a folder. Adds warnings of the whole.
std::vector<OrganReport> write_bodies(SceneFolder& folder, const MeshOptions& options,
                                      const std::vector<Organ>& organs, std::vector<MeshedOrgan> meshed,
                                      std::vector<std::string>& warnings);

nlohmann::ordered_json report_json(const OrganReport& report);
/// A table with a line for each organ.
std::string report_text(const std::vector<OrganReport>& reports);

}  // namespace palpate::app
