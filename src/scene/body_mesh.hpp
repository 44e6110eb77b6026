#pragma once

#include <cstddef>

#include <palpate/mesh.hpp>

#include "scene/load.hpp"
#include "scene/scene.hpp"

namespace palpate {

/// The mesh of body `body` of a scene, from its file or generator, before it is placed. Throws Error naming
/// the scene and the key, with the message of the file's reader.
TetMesh body_mesh(const Scene& scene, std::size_t body, const MeshReader& read_mesh);

}  // namespace palpate
