#pragma once

#include <cstdint>
#include <vector>

#include <palpate/material.hpp>
#include <palpate/mesh.hpp>

namespace palpate {

/// How far a body sags under its own weight (9.81 m/s^2 along -z): the root mean square displacement of its
/// mass, m. It is computed for small displacements, as if the body were much stiffer, so it is proportional
/// to 1 / young_modulus.
///
/// \param fixed  (n_points) 1: does not move
///
/// Needs one step of a simulation.
double sag_under_own_weight(const Bodies& bodies, const Material& material,
                            const std::vector<std::uint8_t>& fixed);

}  // namespace palpate
