#pragma once

#include <palpate/mesh.hpp>

#include "anatomy/stuffing.hpp"

namespace palpate::anatomy {

/// Moves the points on the surface of a mesh onto the surface of a shape that is near to it, along the
/// gradient: for shapes with parts too thin or channels too narrow for the lattice, which are first meshed
/// with these parts widened. A point stops earlier where a tet at it would get a dihedral angle below
/// `least_angle` (degrees). Inner points move where that is better for their tets. O(points x tets at a
/// point).
void fit(TetMesh& mesh, const Distance& shape, double least_angle);

/// Meshes `shape`: stuff() with `wider`, which the lattice resolves better, then fit() with 10 degrees.
TetMesh stuff_fitted(const Distance& shape, const Distance& wider, const StuffingOptions& options);

}  // namespace palpate::anatomy
