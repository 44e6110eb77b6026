#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/types.hpp>

namespace palpate {

/// A tet mesh from a file or generator: one body, not yet checked.
struct TetMesh {
  std::vector<Vec3> points;  ///< (n_points x 3)
  std::vector<Tet> tets;     ///< (n_tets x 4), 0-based indices into points
};

/// Allowed but remarkable properties of a mesh, found by check_mesh().
struct MeshNotes {
  Index reoriented_tets = 0;      ///< tets of negative volume; two of their corners were swapped
  Index unreferenced_points = 0;  ///< points in no tet; kept, so that indices are the same as in the file
};

/// Checks a mesh and swaps two corners of tets of negative volume, so that det[b-a, c-a, d-a] > 0 for each.
///
/// Throws Error (naming `source` and the 0-based tet or point) on: no points or no tets, an index out of
/// range, a point repeated in a tet, a coordinate that is not from -1e100 to 1e100, a tet of exactly zero
/// volume (exact arithmetic), tets that are all smaller than 1e-150 along each axis. The mesh is unchanged if
/// it throws. O(n).
MeshNotes check_mesh(TetMesh& mesh, std::string_view source);

/// One body's part of the index space of Bodies.
struct Body {
  std::string name;  ///< used in messages
  Range points;      ///< its indices among all points
  Range edges;       ///< its indices among all edges
  Range triangles;   ///< its indices among all surface triangles
  Range tets;        ///< its indices among all tets
};

/// Compressed rows: the values of row i are values[begin[i] .. begin[i+1]).
struct Rows {
  std::vector<Index> begin{0};  ///< (n_rows + 1)
  std::vector<Index> values;    ///< of all rows, one after the other
  /// The values of a row; valid while the object is unchanged. O(1).
  [[nodiscard]] std::span<const Index> operator[](Index row) const {
    const auto first = static_cast<std::size_t>(begin[static_cast<std::size_t>(row)]);
    const auto last = static_cast<std::size_t>(begin[static_cast<std::size_t>(row) + 1]);
    return {values.data() + first, last - first};
  }
};

/// The tet meshes of many bodies in one index space, with the topology that contact handling needs.
///
/// Nothing changes after add(): deformed positions are stored elsewhere, as an (n_points x 3) array in the
/// same order. Indices are global (over all bodies); the parts of body b are the ranges of bodies()[b].
class Bodies {
 public:
  /// Appends a body after check_mesh(); returns its index. Throws Error and changes nothing if the mesh is
  /// refused, also if more than two tets share a face, or two on the same side of it. O(n log n).
  Index add(std::string name, TetMesh mesh);

  /// Replaces the rest positions (n_points x 3) of the same meshes. Throws Error, and changes nothing, on
  /// a different number of points and if a tet would be flat or inverted. O(n).
  void set_points_rest(std::span<const Vec3> points);

  /// (n_bodies) name and index ranges of each body, in the order of add().
  [[nodiscard]] std::span<const Body> bodies() const { return bodies_; }
  /// Number of bodies.
  [[nodiscard]] Index body_count() const { return static_cast<Index>(bodies_.size()); }
  /// Notes of check_mesh() for each body, (n_bodies).
  [[nodiscard]] std::span<const MeshNotes> notes() const { return notes_; }

  [[nodiscard]] std::span<const Vec3> points_rest() const { return points_rest_; }  ///< (n_points x 3)
  [[nodiscard]] std::span<const Tet> tets() const { return tets_; }  ///< (n_tets x 4), positive volume
  [[nodiscard]] std::span<const Edge> edges() const {
    return edges_;
  }  ///< (n_edges x 2), unique, low point first
  /// (n_triangles x 3): faces of one tet only, counter-clockwise seen from outside.
  [[nodiscard]] std::span<const Triangle> triangles() const { return triangles_; }
  /// (n_tets x 4): the tet across the face opposite corner i, or -1 at the surface.
  [[nodiscard]] std::span<const std::array<Index, 4>> tet_neighbors() const { return tet_neighbors_; }
  [[nodiscard]] std::span<const Index> body_of_point() const { return body_of_point_; }  ///< (n_points)
  /// (n_triangles): the tet that a triangle is a face of.
  [[nodiscard]] std::span<const Index> triangle_tets() const { return triangle_tets_; }
  /// (n_triangles x 3): the edge opposite corner i.
  [[nodiscard]] std::span<const std::array<Index, 3>> triangle_edges() const { return triangle_edges_; }
  /// (n_triangles x 3): the triangle across the edge opposite corner i; -1 where more than two meet there.
  [[nodiscard]] std::span<const std::array<Index, 3>> triangle_neighbors() const {
    return triangle_neighbors_;
  }
  /// (n_edges x 2): the two triangles of an edge at the surface (the first two if there are more); -1, -1 for
  /// an edge inside a body.
  [[nodiscard]] std::span<const std::array<Index, 2>> edge_triangles() const { return edge_triangles_; }
  /// The triangle that is the face opposite corner `opposite` of a tet; the face is at the surface. O(1).
  [[nodiscard]] Index triangle_of_face(Index tet, std::size_t opposite) const {
    Index triangle = first_triangles_[static_cast<std::size_t>(tet)];
    for (std::size_t i = 0; i < opposite; ++i)
      triangle += tet_neighbors_[static_cast<std::size_t>(tet)][i] < 0 ? 1 : 0;
    return triangle;
  }
  /// Body of a tet, triangle or edge: that of its first point.
  [[nodiscard]] Index body_of(const auto& corners) const {
    return body_of_point_[static_cast<std::size_t>(corners[0])];
  }
  [[nodiscard]] const Rows& point_edges() const { return point_edges_; }  ///< edges at each point, ascending
  [[nodiscard]] const Rows& point_tets() const { return point_tets_; }    ///< tets at each point, ascending
  /// The point at the other end of an edge.
  [[nodiscard]] Index other_end(Index edge, Index point) const {
    const Edge& e = edges_[static_cast<std::size_t>(edge)];
    return e[0] == point ? e[1] : e[0];
  }

 private:
  std::vector<Body> bodies_;
  std::vector<MeshNotes> notes_;
  std::vector<Vec3> points_rest_;
  std::vector<Tet> tets_;
  std::vector<Edge> edges_;
  std::vector<Triangle> triangles_;
  std::vector<std::array<Index, 4>> tet_neighbors_;
  std::vector<Index> first_triangles_;  ///< (n_tets): triangles are in the order of their tets
  std::vector<Index> triangle_tets_;
  std::vector<std::array<Index, 3>> triangle_edges_;
  std::vector<std::array<Index, 3>> triangle_neighbors_;
  std::vector<std::array<Index, 2>> edge_triangles_;
  std::vector<Index> body_of_point_;
  Rows point_edges_;
  Rows point_tets_;
};

/// Smallest, mean and largest of a set of numbers.
struct Spread {
  double min = 0.0;   ///< smallest
  double mean = 0.0;  ///< arithmetic mean
  double max = 0.0;   ///< largest
};

/// The paper's Table 1, and further statistics of a mesh.
struct MeshStatistics {
  Index points = 0;       ///< number of points
  Index edges = 0;        ///< number of edges
  Index triangles = 0;    ///< number of surface triangles
  Index tets = 0;         ///< number of tets
  Spread edge_length;     ///< of all edges, m
  Spread dihedral_angle;  ///< degrees, over all six angles of all tets
  double volume = 0.0;    ///< sum over all tets, m^3
  Vec3 lower;             ///< lower corner of the bounding box of the points that tets use, m
  Vec3 upper;             ///< upper corner of that box, m
};

/// Statistics at given positions (n_points x 3) of one body, or of all bodies together (body = -1). O(n).
MeshStatistics mesh_statistics(const Bodies& bodies, std::span<const Vec3> positions, Index body = -1);

}  // namespace palpate
