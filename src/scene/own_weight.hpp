#pragma once

#include <cstdint>
#include <vector>

#include <palpate/material.hpp>
#include <palpate/mesh.hpp>

namespace palpate {

/// How far the point moves most that moves most, m, where the body has come to rest under its own weight
/// (9.81 m/s^2 along -z). It counts small displacements, as if the body were much stiffer: so it goes with 1
/// / young_modulus. \param fixed  (n_points) 1: does not move
double sag_under_own_weight(const Bodies& bodies, const Material& material,
                            const std::vector<std::uint8_t>& fixed);

}  // namespace palpate
