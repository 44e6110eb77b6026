#pragma once

#include <palpate/model.hpp>

#include "scene/load.hpp"
#include "scene/scene.hpp"

namespace palpate {

/// Gives the tets whose material has Fibres::field the directions that the mesh file has for them, scaled and
/// turned as the body is; zero leaves the direction of the material. The bodies and their regions are in the
/// model already. Throws Error naming the scene, the key and the file. O(tets).
void add_fibre_fields(const Scene& scene, const CellReader& read_cells, Model& model);

/// Sets fibre directions of bodies with SceneBody::fibre_ends to those of fibres_between(). Throws Error
/// naming the scene and the key.
void add_fibre_ends(const Scene& scene, Model& model);

}  // namespace palpate
