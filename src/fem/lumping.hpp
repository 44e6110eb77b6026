#pragma once

#include <span>
#include <vector>

#include <palpate/material.hpp>
#include <palpate/mesh.hpp>

/// Properties of points and bodies from the materials of their tets. Materials are checked by the caller.
namespace palpate::fem {

/// Volume of a tet at rest, m^3: a sixth of the determinant of its edges as columns, as in Elements.
[[nodiscard]] double tet_volume_rest(const Bodies& bodies, Index tet);

/// Lumped masses (n_points), kg: a quarter of each tet of every body, obstacles included; zero for points
/// without a tet. O(n_tets).
[[nodiscard]] std::vector<double> lumped_masses(const Bodies& bodies, const Materials& materials);

/// Mass damping of each point, 1/s (n_points): the mean over its tets by mass. If all tets have the body's
/// value, it is that bit for bit. `masses` are those of lumped_masses(). O(n_tets).
[[nodiscard]] std::vector<double> mass_dampings(const Bodies& bodies, const Materials& materials,
                                                std::span<const double> masses);

/// The material of each body, with the instantaneous Young's modulus averaged over its tets by volume: the
/// stiffness for contacts. O(n_tets).
[[nodiscard]] std::vector<Material> mean_materials(const Bodies& bodies, const Materials& materials);

}  // namespace palpate::fem
