#pragma once

#include <span>
#include <vector>

#include <palpate/mesh.hpp>
#include <palpate/types.hpp>

namespace palpate {

/// Directions of fibres that run along a body from some of its points to others, as those of a muscle from
/// one attachment to the other, also round a bend: the normalised gradient of the harmonic function that is 0
/// at the points `from` and 1 at the points `to`, and flows through no other part of the surface (linear tets
/// on the shape at rest). In a tet where it has none (all corners at one end) the direction is the mean of
/// its neighbours'. Signs do not matter to fibres.
///
/// \param from, to  points of the body in its own numbers, at least one each; again and in any order
/// \return (n_tets of the body) unit vectors, as Model::fibre_of_tet takes them behind those of other bodies
/// Throws Error where the body is none, an end is empty or has a point that the body has not, a point is at
/// both ends, and where a piece of the body (tets that share points) does not have both ends.
/// Conjugate gradients to 1e-14 in one thread, the same bits everywhere: O(n^(4/3)) for n points.
[[nodiscard]] std::vector<Vec3> fibres_between(const Bodies& bodies, Index body, std::span<const Index> from,
                                               std::span<const Index> to);

}  // namespace palpate
