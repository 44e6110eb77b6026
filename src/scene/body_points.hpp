#pragma once

#include <cstddef>
#include <span>

#include <palpate/model.hpp>

#include "scene/scene.hpp"

namespace palpate {

/// Fills in the data of a model on the points of one body: fixed, prescribed, attached, loaded and grabbed
/// points, and velocities at the start. All bodies and their materials must be in the model.
/// \param motions  (n_bodies) index of the motion of each body, or -1
///
/// Throws Error as load_model() does.
void fill_points(const Scene& scene, std::size_t body, std::span<const Index> motions, Model& model);

}  // namespace palpate
