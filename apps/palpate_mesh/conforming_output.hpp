#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "conforming_mesh.hpp"
#include "scene_folder.hpp"

namespace palpate::app {

/// The report on a conforming mesh.
struct ConformingReport {  // NOLINT(bugprone-exception-escape)
  nlohmann::ordered_json json;
  std::string text;  ///< a table with a line for each tissue
  std::vector<std::string> warnings;
};

/// Writes tissues.vtu (the whole mesh, with the labels of its tets), a .vtu for each body and scene.json
/// to a folder.
ConformingReport write_conforming(SceneFolder& folder, const MeshOptions& options, const NamedMap& map,
                                  const TissuePlan& plan, ConformingMesh made);

}  // namespace palpate::app
