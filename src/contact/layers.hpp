#pragma once

#include <span>

#include <palpate/mesh.hpp>

/// Self-contact: tells whether two tets are near each other because they are neighbours, or because the body
/// is folded onto itself.
namespace palpate {

/// Whether a point is in a tet of its own body only because tissue there is inverted or flat: a tet without
/// positive volume shares a corner with the tet, and it has the point or one of the point's neighbours as a
/// corner. Elastic forces undo that; a force towards the surface would pull the point through the body.
/// Exact. O(tets at the tet's corners).
bool is_fold(const Bodies& bodies, std::span<const Vec3> positions, Index point, Index tet);

/// Whether two points of an edge, each in a tet of their own body, are in the same layer of it: the tets
/// share a corner, or the edge leads from one to the other without leaving the body. The result does not
/// depend on their order. O(tets that the edge passes), at most 64.
bool same_layer(const Bodies& bodies, std::span<const Vec3> positions, Index point_a, Index tet_a,
                Index point_b, Index tet_b);

}  // namespace palpate
