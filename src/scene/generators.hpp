#pragma once

#include <array>
#include <cstdint>

#include <palpate/mesh.hpp>

#include "scene/scene.hpp"

namespace palpate {

/// Largest number of layers of a ball: 335 million tets, which indices can still number.
inline constexpr int most_ball_resolution = 256;

/// A box centred at the origin: cells[0] x cells[1] x cells[2] cells, each cut into 5 tets (a middle one and
/// four corners), mirrored in cells with odd i + j + k so that faces match. Points are numbered x fastest,
/// then y, then z; all tets have positive volume. `size` in length units. Throws Error if a number of
/// cells is not positive, a size is not positive and finite, or the indices do not fit. O(cells).
TetMesh make_box(const std::array<int, 3>& cells, const Vec3& size);

/// A ball centred at the origin: the 20 tets between the centre and the faces of a regular icosahedron (with
/// a corner at each pole), each cut into resolution^3 tets whose points lie on `resolution` spheres of equal
/// spacing.
///
/// Point 0 is the centre; the points follow by layer, 10 k^2 + 2 in layer k; those of the last layer are on
/// the sphere up to rounding. 20 resolution^3 tets of positive volume. Dihedral angles stay above 35 degrees
/// at every resolution, because each of the 20 parts is one smooth map of a regular lattice. Lattice tets by
/// the edgewise subdivision of Edelsbrunner and Grayson (2000), section 3. Throws Error if an argument is not
/// positive and finite, or the resolution is above 256. O(resolution^3 log resolution).
TetMesh make_ball(double radius, int resolution);

/// Options of make_stacking_scene(); the defaults are the paper's stacking scene.
struct StackingOptions {
  int count = 20;                       ///< membranes, 1 to 100000; the lowest one is an obstacle
  std::array<int, 3> cells{10, 10, 1};  ///< cells of a membrane
  Vec3 size{0.2, 0.2, 0.01};            ///< m
  double gap = 0.001;                   ///< m, height between membranes at the start, >= 0
  double max_shift = 0.003;             ///< m, bound of the random shift along x and y
  double max_rotation = 2.0;            ///< degrees, bound of the random rotation about z
  std::uint32_t seed = 1;               ///< seed of the shifts and rotations
};

/// A stack of membranes above an obstacle, at the start of a fall onto each other. Each is shifted and
/// rotated a little, by a hash of (seed, index), so that rims and grid points do not coincide. The lowest
/// membrane rests on z = 0 and is neither shifted nor rotated. Throws Error if an option is out of range.
Scene make_stacking_scene(const StackingOptions& options = {});

}  // namespace palpate
