#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include <palpate/mesh.hpp>
#include <palpate/types.hpp>

namespace palpate::app {

/// A point where two labels meet.
struct InterfaceSeed {
  Vec3 point;
  std::array<int, 2> labels{0, 1};  ///< ascending
};

/// A ball round a point of a line that edges of the mesh follow.
struct LineBall {
  Vec3 center;
  double radius = 0.0;
};

/// A region of space to mesh, with a label at each position. All lengths have the same unit.
struct LabelledDomain {
  std::function<int(const Vec3&)> label;  ///< 0 outside. May throw; the mesher passes the exception on
  Vec3 lower;                             ///< corner of a box around all positions with a label
  Vec3 upper;
  /// Points from which the refinement of interfaces starts: some for each component, and behind each thin
  /// neck.
  std::vector<InterfaceSeed> seeds;
  /// Points of the mesh on lines where three labels meet. Each ball holds no other centre. No other point of
  /// the mesh is in a ball, so consecutive balls that overlap become an edge.
  std::vector<LineBall> lines;
};

/// A length as a function of position.
using SizeField = std::function<double(const Vec3&)>;

/// The resolution of a mesh.
struct MeshingCriteria {
  SizeField facet_size;        ///< upper bound of the circumradius of triangles of interfaces
  SizeField facet_distance;    ///< upper bound of the distance between the centre of such a triangle and the
                               ///< interface
  SizeField cell_size;         ///< upper bound of the circumradius of tets
  std::size_t max_points = 0;  ///< maximum number of points of the mesh, > 0
  bool manifold = true;  ///< whether to make the surface a manifold, where possible; with one label only
  /// Called with the number of tets before tets are improved, which takes longest. If it returns false, the
  /// mesh is returned without that. Absent: all are improved.
  std::function<bool(std::size_t)> wanted;
  /// Called often while the mesh is made; may throw to stop. Absent: nothing is called.
  std::function<void()> check;
};

/// Tets with labels: interfaces between labels are common faces of two tets.
struct LabelledMesh {
  TetMesh mesh;                    ///< points and tets sorted
  std::vector<int> labels;         ///< (n_tets), > 0
  std::vector<Index> line_points;  ///< points on the lines of the domain, ascending
  bool manifold = true;            ///< the surface was asked to be a manifold, and is one
};

/// Meshes the domain by Delaunay refinement, then perturbs points and changes the connectivity where tets are
/// slivers (CGAL Mesh_3: Jamin, Alliez, Yvinec and Boissonnat 2015). Where the surface does not become a
/// manifold with `max_points`, as where two parts touch in an edge, it need not.
///
/// The same input gives the same mesh. Empty where there is no point inside or no seed; none where
/// `max_points` do not do. Throws Error if CGAL fails, and passes on what the functions throw. Seconds for
/// 10 000 tets.
std::optional<LabelledMesh> mesh_domain(const LabelledDomain& domain, const MeshingCriteria& criteria);

}  // namespace palpate::app
