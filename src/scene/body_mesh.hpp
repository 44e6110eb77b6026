#pragma once

#include <cstddef>

#include <palpate/mesh.hpp>

#include "scene/load.hpp"
#include "scene/scene.hpp"

namespace palpate {

/// The mesh of body `body` of a scene from its file or generator, not yet placed. Throws Error naming the
/// scene and the key, with the message of the reader of a file.
TetMesh body_mesh(const Scene& scene, std::size_t body, const MeshReader& read_mesh);

}  // namespace palpate
