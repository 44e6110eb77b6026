#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include <palpate/mesh.hpp>

#include "scene_input.hpp"

/// The statistics of meshes (the paper's Table 1 and more), as JSON and as text.
namespace palpate::app {

nlohmann::ordered_json statistics_json(const MeshStatistics& statistics);

/// What reading the file and checking the mesh met: "format", "dropped", "reoriented_tets",
/// "unreferenced_points". `file` may be null (a generated body).
nlohmann::ordered_json notes_json(const MeshRecord* file, const MeshNotes& notes);

/// One line for each statistic, each ending in a line end.
std::string statistics_text(const MeshStatistics& statistics, std::string_view length_unit);

/// What is worth telling about a body, "71 line and 860 triangle cells left out, 2 points unreferenced";
/// empty if nothing is.
std::string notes_text(const MeshRecord* file, const MeshNotes& notes);

}  // namespace palpate::app
