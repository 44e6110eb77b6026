#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <palpate/material.hpp>
#include <palpate/mesh.hpp>
#include <palpate/model.hpp>

#include "scene/scene.hpp"

namespace palpate {

/// Reads the tet mesh of a file; throws Error naming the file. Callers pass it, so that scenes need no VTK.
using MeshReader = std::function<TetMesh(const std::filesystem::path&)>;
/// Reads `components` numbers for each tet of a file, from the array of this name (io::read_cell_data()).
using CellReader =
    std::function<std::vector<double>(const std::filesystem::path&, const std::string&, std::size_t)>;

/// Makes or reads the mesh of each body, places it, and finds its fixed, attached, loaded and grabbed points.
/// Bodies are in the order of the scene, their rest positions are world positions; a rigid body that names no
/// material gets the default, and the materials of regions follow those of the bodies. Throws Error naming
/// the scene and key path if a selection selects no point, an index is out of range, a point is attached
/// twice or to a body without a motion, and whatever the reader or Bodies::add() throws. O(points x
/// selections + n log n).
/// \param read_cells  needed where fibres have a field, or a region a label
Model load_model(const Scene& scene, const MeshReader& read_mesh, const CellReader& read_cells = {});

/// A point of a mesh after the transform: scaled, then rotated, then translated.
Vec3 transformed(const Transform& transform, const Vec3& point);

}  // namespace palpate
