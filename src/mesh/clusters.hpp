#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "simd/cluster.hpp"

namespace palpate {

/// Clusters of all tets, or of all surface triangles; each belongs to one body.
struct Clusters {
  std::vector<Cluster> clusters;  ///< ordered by body; within a body, neighbours follow each other
  std::vector<Index> primitives;  ///< (n_tets or n_triangles): those of each cluster, ascending within it
  std::vector<Index> points;      ///< the points of each cluster, ascending within it
  std::vector<std::uint16_t> at_point;  ///< beside points: bits of the primitives with that corner
  [[nodiscard]] std::span<const Index> primitives_of(const Cluster& cluster) const {
    return std::span(primitives).subspan(static_cast<std::size_t>(cluster.first), cluster.size);
  }
  [[nodiscard]] std::span<const Index> points_of(const Cluster& cluster) const {
    return std::span(points).subspan(static_cast<std::size_t>(cluster.first_point), cluster.points);
  }
};

/// A cluster's box is at most this many times as long as the box of its largest primitive.
inline constexpr double most_cluster_extent = 4.0;

/// Cuts each body into clusters at its rest positions. Each of its connected parts (by common
/// points; those below 16 tets are one part) is halved across its longest side, again and again, until 16
/// tets with at most 32 points and a small extent (most_cluster_extent) are left. Cuts leave multiples of 16
/// tets, so that few clusters are not full. The same bodies give the same clusters. O(tets log tets).
Clusters make_tet_clusters(const Bodies& bodies);
/// Clusters of the surface triangles, made like those of the tets.
Clusters make_triangle_clusters(const Bodies& bodies);

}  // namespace palpate
