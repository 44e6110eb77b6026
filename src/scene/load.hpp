#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include <palpate/material.hpp>
#include <palpate/mesh.hpp>

#include "scene/scene.hpp"

namespace palpate {

/// Reads the tet mesh of a file; throws Error naming the file. The tools pass theirs, so that scenes need no
/// VTK.
using MeshReader = std::function<TetMesh(const std::filesystem::path&)>;

/// The bodies of a scene, placed, with what belongs to each body or point. Same order as in the scene.
struct LoadedScene {
  Bodies bodies;  ///< rest positions are world positions at the start
  std::vector<Material>
      materials;  ///< of each body (the default where an obstacle names none), then of regions
  std::vector<Index>
      material_of_tet;  ///< (n_tets) into materials, as Materials takes it; empty without regions
  std::vector<std::uint8_t>
      fixed;                   ///< (n_points); 1 where a point does not move: selected, or of an obstacle
  std::vector<bool> obstacle;  ///< (n_bodies)
};

/// Makes or reads the mesh of each body, places it, and finds its fixed points. Throws Error naming the scene
/// and key path where a selection selects no point or an index is out of range, and whatever the reader or
/// Bodies::add() throws. O(points x selections + n log n).
LoadedScene load_bodies(const Scene& scene, const MeshReader& read_mesh);

/// Where a point of a mesh ends up: scaled, then rotated, then translated.
Vec3 transformed(const Transform& transform, const Vec3& point);

}  // namespace palpate
