#pragma once

#include <span>
#include <vector>

#include <palpate/material.hpp>
#include <palpate/mesh.hpp>

/// Properties of points and bodies that follow from the materials of their tets. The caller checks the
/// materials.
namespace palpate::fem {

/// Volume of a tet at rest, m^3: a sixth of the determinant of its edges as columns, as in Elements.
[[nodiscard]] double tet_volume_rest(const Bodies& bodies, Index tet);

/// Lumped masses (n_points), kg: a quarter of each tet, for all bodies including obstacles; zero for points
/// without a tet. O(n_tets).
[[nodiscard]] std::vector<double> lumped_masses(const Bodies& bodies, const Materials& materials);

/// Mass damping of each point, 1/s (n_points): the mean over its tets, weighted by mass. If all tets have the
/// body's value, the mean equals it in every bit. `masses` come from lumped_masses(). O(n_tets).
[[nodiscard]] std::vector<double> mass_dampings(const Bodies& bodies, const Materials& materials,
                                                std::span<const double> masses);

/// The material of each body, with the instantaneous Young's modulus and Poisson's ratio averaged over its
/// tets by volume: the stiffness of contacts depends on them. O(n_tets).
[[nodiscard]] std::vector<Material> mean_materials(const Bodies& bodies, const Materials& materials);

}  // namespace palpate::fem
