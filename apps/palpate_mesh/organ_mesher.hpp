#pragma once

#include <cstddef>
#include <functional>
#include <optional>
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
  std::size_t max_points = 0;   ///< of the mesh, > 0
};

/// What mesh_organ() made.
struct OrganMesh {
  TetMesh mesh;          ///< points and tets sorted
  bool manifold = true;  ///< whether the surface was asked to be one, and is
};

/// Meshes the shape by Delaunay refinement, then perturbs points and changes the connectivity where tets are
/// slivers (CGAL Mesh_3: Jamin, Alliez, Yvinec and Boissonnat 2015). Where the surface does not become a
/// manifold with `max_points`, as where two parts touch in an edge, it need not.
///
/// The same input gives the same mesh. Empty where there is no point inside or no seed; none where
/// `max_points` do not do. Passes on what the field throws. Seconds for 10 000 tets.
std::optional<OrganMesh> mesh_organ(const ImplicitOrgan& organ, const MeshingCriteria& criteria);

}  // namespace palpate::app
