#pragma once

#include <palpate/mesh.hpp>

#include "anatomy/stuffing.hpp"

namespace palpate::anatomy {

/// Moves the surface points of a mesh along the gradient onto the surface of a shape that is near to it.
/// Some shapes have parts too thin, or channels too narrow, for the lattice: mesh them with these parts
/// widened, then call this. A point stops earlier if a tet at it would get a dihedral angle below
/// `least_angle` (degrees). Inner points move if that improves their tets. O(points x tets at a point).
void fit(TetMesh& mesh, const Distance& shape, double least_angle);

/// Meshes `shape`: stuff() with `wider`, which the lattice resolves better, then fit() with 10 degrees.
TetMesh stuff_fitted(const Distance& shape, const Distance& wider, const StuffingOptions& options);

}  // namespace palpate::anatomy
