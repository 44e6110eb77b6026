#pragma once

#include <functional>

#include <palpate/mesh.hpp>
#include <palpate/types.hpp>

namespace palpate::anatomy {

/// A shape: negative inside, positive outside, continuous; near its surface approximately the distance to it.
using Distance = std::function<double(const Vec3&)>;

/// Region and resolution of a mesh.
struct StuffingOptions {
  Vec3 lower;  ///< of a box that contains the shape
  Vec3 upper;  ///< of it
  double cell =
      1.0;  ///< edge length of a lattice cell, > 0; inner tets have edges of 1 and 0.87 times this length
};

/// A tet mesh of a shape: isosurface stuffing (Labelle & Shewchuk, SIGGRAPH 2007), without grading.
///
/// A body-centred cubic lattice is laid over the box; lattice points near the surface are moved onto it, and
/// tets that the surface still cuts are split by stencils. Points on the surface are zeros of the shape to
/// 1e-9 of a cell. All dihedral angles are between 10.7 and 164.8 degrees (their table 2, for the warping
/// thresholds here), the surface is closed, whatever the shape is, and two of its triangles meet at each edge
/// (tets that touch others in an edge only are dropped). Where the shape is thinner than about a cell, parts
/// of it may be lost; of several parts only the one with the most tets is kept.
///
/// Deviation: a cut is the zero that bisection finds on a lattice edge whose ends differ, not that of an
/// interpolation. Throws Error if the options are out of range or nothing of the shape is found. O(lattice
/// points + cuts).
TetMesh stuff(const Distance& shape, const StuffingOptions& options);

}  // namespace palpate::anatomy
