#pragma once

#include <cstddef>
#include <span>

#include <palpate/model.hpp>

#include "scene/scene.hpp"

namespace palpate {

/// Fills in the data of a model on the points of one body: those that are fixed, prescribed, attached, loaded
/// or grabbed, and how fast they are at the start. All bodies and their materials are in the model already.
/// \param motions  (n_bodies) index of the motion of each body, or -1
/// Throws Error as load_model() says.
void fill_points(const Scene& scene, std::size_t body, std::span<const Index> motions, Model& model);

}  // namespace palpate
