#pragma once

#include <span>

#include <palpate/material.hpp>
#include <palpate/mesh.hpp>
#include <palpate/tissue.hpp>

#include "fem/elements.hpp"
#include "parallel/parallel.hpp"

namespace palpate::fem {

/// Strain and stress of each tet of all bodies at these positions (n_points x 3). O(tets), parallel.
/// \param memory  a state whose arrays are used again; its values are lost
[[nodiscard]] TissueState tissue_of_tets(const parallel::Threads& threads, const Bodies& bodies,
                                         const Elements& elements, std::span<const Vec3> positions,
                                         TissueState memory = {});

/// tissue_of_tets() without von Mises stress, pressure, principal values and directions; these arrays are
/// empty. Half the work, and enough for tissue_of_points().
[[nodiscard]] TissueState strain_of_tets(const parallel::Threads& threads, const Bodies& bodies,
                                         const Elements& elements, std::span<const Vec3> positions,
                                         TissueState memory = {});

/// Means at each point of a state of the tets; see Simulation::tissue_at_points(). Tets without a stress
/// (J <= 0) are left out of the mean stress. O(tets), parallel.
[[nodiscard]] TissueState tissue_of_points(const parallel::Threads& threads, const Bodies& bodies,
                                           const Elements& elements, const Materials& materials,
                                           const TissueState& tets, TissueState memory = {});

}  // namespace palpate::fem
