#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include <palpate/mesh.hpp>

#include "mesh_parts.hpp"
#include "scene_input.hpp"

/// The statistics of meshes (the paper's Table 1 and more), as JSON and as text.
namespace palpate::app {

nlohmann::ordered_json statistics_json(const MeshStatistics& statistics);

/// The connected pieces of a mesh for JSON: "pieces", "nonmanifold_edges", "nonmanifold_points".
nlohmann::ordered_json parts_json(const MeshParts& parts);

/// What was found while reading the file and checking the mesh: "format", "dropped", "converted",
/// "reoriented_tets", "unreferenced_points". `file` may be null (a generated body).
nlohmann::ordered_json notes_json(const MeshRecord* file, const MeshNotes& notes);

/// One line for each statistic, each ending in a line end.
std::string statistics_text(const MeshStatistics& statistics, std::string_view length_unit);

/// The connected pieces for people: "3, the largest with 97 % of the volume; 2 edges and 1 point where it is
/// no manifold".
std::string parts_text(const MeshParts& parts);

/// Remarks on a body, such as "cells left out: 71 line; 2 points in no tet"; empty if there are none.
std::string notes_text(const MeshRecord* file, const MeshNotes& notes);

}  // namespace palpate::app
