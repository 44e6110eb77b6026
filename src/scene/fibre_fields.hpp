#pragma once

#include <palpate/model.hpp>

#include "scene/load.hpp"
#include "scene/scene.hpp"

namespace palpate {

/// Sets fibre directions of tets whose material has Fibres::field to those in the mesh file, scaled and
/// rotated like the body. A zero vector keeps the direction of the material. The bodies and their regions
/// must be in the model. Throws Error naming the scene, the key and the file. O(tets).
void add_fibre_fields(const Scene& scene, const VectorReader& read_vectors, Model& model);

/// Sets fibre directions of bodies with SceneBody::fibre_ends to those of fibres_between(). Throws Error
/// naming the scene and the key.
void add_fibre_ends(const Scene& scene, Model& model);

}  // namespace palpate
