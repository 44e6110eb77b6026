#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"
#include "mesh/clusters.hpp"

namespace palpate {

/// How thick the bodies are behind their surface triangles, at rest: how far something may enter there and
/// still be nearer to this side than to the other.
///
/// It is the smallest distance to the other side from four places of the triangle, against its normal. Near a
/// sharp edge this is short, so the height of the tet behind the triangle is a lower bound: with flat tets
/// the body is thicker than a tet. The mean edge length of the body is an upper bound. 0 where a triangle has
/// no area.
struct LocalThickness {
  /// O(surface triangles), with walks through a few tets each.
  /// \param surface  clusters of the surface triangles of all bodies
  LocalThickness(const Bodies& bodies, const Clusters& surface);

  std::vector<double> of_triangle;  ///< (n_triangles) m
  std::vector<double> of_cluster;   ///< (n_clusters) minimum of its triangles, m
  std::vector<double> of_point;     ///< (n_points) minimum of the triangles at it, at most mean_edge, m
  std::vector<double> mean_edge;    ///< (n_bodies) mean edge length, m
  std::vector<double> of_body;      ///< (n_bodies) minimum of its triangles, m; infinite without a surface

  /// Minimum of the corners of a tet, m. O(1).
  [[nodiscard]] double of_tet(const Tet& tet) const {
    return std::min({at(of_point, tet[0]), at(of_point, tet[1]), at(of_point, tet[2]), at(of_point, tet[3])});
  }
  /// Minimum of the triangles of a surface edge, m. O(1).
  [[nodiscard]] double of_edge(const Bodies& bodies, Index edge) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Index triangle : at(bodies.edge_triangles(), edge))
      if (triangle >= 0) least = std::min(least, at(of_triangle, triangle));
    return least;
  }
  /// Where a contact of a point or of an edge is, m. O(1).
  [[nodiscard]] double of_contact(const Bodies& bodies, const Contacts& contacts, std::size_t c) const {
    return of_tet(at(bodies.tets(), contacts.tet[c]));
  }
  [[nodiscard]] double of_contact(const EdgeContacts& contacts, std::size_t c) const {
    const auto& [entry, exit] = contacts.triangles[c];
    return std::min(at(of_triangle, entry), at(of_triangle, exit));
  }
};

}  // namespace palpate
