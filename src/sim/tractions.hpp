#pragma once

#include <span>

#include <palpate/forces.hpp>
#include <palpate/mesh.hpp>

#include "sim/step_forces.hpp"

namespace palpate {

/// The forces of contacts as loads on surface triangles at these positions (n_points x 3); see
/// SurfaceTractions. A force at a position x below the nearest point q of a triangle, with barycentric
/// weights b and the centroid c of the corners x_i, becomes the corner forces
///   b_i f + t x (x_i - c),  sum_i (|x_i - c|^2 I - (x_i - c) (x_i - c)^T) t = (x - q) x f:
/// the least couple that keeps the torque. Among faces at similar distances, one that faces along the
/// contact's direction is used. O(contacts + points + triangles).
[[nodiscard]] SurfaceTractions tractions_of(std::span<const ActedContact> contacts, const Bodies& bodies,
                                            std::span<const Vec3> positions);

}  // namespace palpate
