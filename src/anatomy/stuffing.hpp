#pragma once

#include <functional>

#include <palpate/mesh.hpp>
#include <palpate/types.hpp>

namespace palpate::anatomy {

/// A shape: negative inside, positive outside, continuous; near its surface about the distance to it.
using Distance = std::function<double(const Vec3&)>;

/// Where and how finely a shape is meshed.
struct StuffingOptions {
  Vec3 lower;  ///< of a box that holds the shape
  Vec3 upper;  ///< of it
  double cell =
      1.0;  ///< edge length of a cell of the lattice, > 0; tets inside have edges of it and 0.87 of it
};

/// A tet mesh of a shape: isosurface stuffing (Labelle & Shewchuk, SIGGRAPH 2007), without grading.
///
/// A body-centred cubic lattice is laid over the box; lattice points that are near to the surface move onto
/// it, tets that it still cuts are cut by stencils. Points on the surface are zeros of the shape to 1e-9 of a
/// cell. All dihedral angles are between 10.7 and 164.8 degrees (their table 2, for the warping thresholds
/// here), the surface is closed, whatever the shape is. Where the shape is thinner than about a cell, parts
/// of it may be lost; of several parts only the one with the most tets is kept.
///
/// Deviation: a cut is the zero that bisection finds on a lattice edge whose ends differ, not that of an
/// interpolation. Throws Error where the options are out of range or nothing of the shape is found. O(lattice
/// points + cuts).
TetMesh stuff(const Distance& shape, const StuffingOptions& options);

}  // namespace palpate::anatomy
