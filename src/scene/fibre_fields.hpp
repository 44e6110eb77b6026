#pragma once

#include <palpate/model.hpp>

#include "scene/load.hpp"
#include "scene/scene.hpp"

namespace palpate {

/// Sets the fibre directions of tets whose material has Fibres::field, from the mesh file, scaled and rotated
/// as the body is. A zero vector leaves the direction of the material. The bodies and their regions must be
/// in the model already. Throws Error naming the scene, the key and the file. O(tets).
void add_fibre_fields(const Scene& scene, const CellReader& read_cells, Model& model);

/// Sets the fibre directions of bodies with SceneBody::fibre_ends, by fibres_between(). Throws Error naming
/// the scene and the key.
void add_fibre_ends(const Scene& scene, Model& model);

}  // namespace palpate
