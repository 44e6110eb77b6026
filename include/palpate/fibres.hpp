#pragma once

#include <span>
#include <vector>

#include <palpate/mesh.hpp>
#include <palpate/types.hpp>

namespace palpate {

/// Directions of fibres along a body from some of its points to others, like those of a muscle between its
/// attachments, also around a bend. They are the normalised gradient of the harmonic function that is 0 at
/// the points `from` and 1 at the points `to`, without flux through the rest of the surface (linear tets on
/// the shape at rest). In a tet without a gradient (all corners at one end) the direction is the mean of its
/// neighbours'. The sign of a direction has no effect.
///
/// \param from, to  indices of points in the body, at least one each; in any order, repetitions allowed
/// \return  (n_tets of the body) unit vectors, the part of Model::fibre_of_tet for this body
/// Throws Error if the body does not exist, an end is empty or has an index out of range, a point is at
/// both ends, or a connected piece of the body does not have both ends. Conjugate gradients to 1e-14 in one
/// thread, the same bits everywhere: O(n^(4/3)) for n points.
[[nodiscard]] std::vector<Vec3> fibres_between(const Bodies& bodies, Index body, std::span<const Index> from,
                                               std::span<const Index> to);

}  // namespace palpate
