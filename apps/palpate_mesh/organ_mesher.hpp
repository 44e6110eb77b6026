#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include <palpate/mesh.hpp>
#include <palpate/types.hpp>

namespace palpate::app {

/// A shape to mesh: where a smooth field is positive. All lengths in one unit.
struct ImplicitOrgan {
  std::function<double(const Vec3&)> field;  ///< > 0 inside; may throw, and the mesher passes that on
  Vec3 lower;                                ///< box around all of the inside
  Vec3 upper;
  /// Points on the surface from which the surface is followed: some for each component, and behind each thin
  /// neck.
  std::vector<Vec3> seeds;
};

/// How fine a mesh is to be.
struct MeshingCriteria {
  double facet_size = 1.0;      ///< bound of the radius of a ball round a surface triangle, length
  double facet_distance = 0.0;  ///< bound from the middle of a surface triangle to the surface, length
  double cell_size = 1.0;       ///< bound of the radius of the circumsphere of a tet, length
  std::size_t max_points = 0;   ///< of the mesh; 0: no bound
};

/// Meshes the shape by Delaunay refinement, then perturbs points and changes the connectivity where tets are
/// slivers (CGAL Mesh_3: Jamin, Alliez, Yvinec and Boissonnat 2015).
///
/// The same input gives the same mesh, points and tets sorted. Empty where there is no point inside or no
/// seed. Throws Error where `max_points` is reached, and passes on what the field throws. Seconds for 10 000
/// tets.
TetMesh mesh_organ(const ImplicitOrgan& organ, const MeshingCriteria& criteria);

}  // namespace palpate::app
