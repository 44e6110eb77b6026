#pragma once

#include <cstddef>

#include <palpate/mesh.hpp>

#include "scene/load.hpp"
#include "scene/scene.hpp"

namespace palpate {

/// The mesh of body `body` of a scene as its file or generator gives it, not yet placed. Throws Error that
/// names the scene and the key, and for a file what its reader found wrong in it.
TetMesh body_mesh(const Scene& scene, std::size_t body, const MeshReader& read_mesh);

}  // namespace palpate
