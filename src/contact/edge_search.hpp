#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <palpate/mesh.hpp>

#include "contact/surface_clusters.hpp"
#include "geometry/box.hpp"
#include "mesh/clusters.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// A surface edge and a surface triangle of another body.
struct EdgeTriangle {
  Index edge;
  Index triangle;
};

/// Finds the surface edges and triangles of different bodies that are near each other. Clusters of surface
/// triangles, each with its own edges, are paired where their boxes meet (a sweep along x), then edges and
/// triangles by their boxes.
class EdgeSearch {
 public:
  using Pair = std::pair<Index, Index>;  ///< of bodies, or of clusters
  /// Two clusters, and how many edges and triangles of them are near each other.
  struct Group {
    Pair clusters;
    std::size_t size;
  };

  explicit EdgeSearch(const Bodies& bodies);

  /// Finds all edges and triangles of these pairs of bodies whose boxes meet, each grown by the value of its
  /// body in `grown` (n_bodies, m), and possibly more: found() and groups(), in the same order. O(surface
  /// triangles near the other body + pairs of clusters whose boxes meet along x), parallel.
  /// \param boxes  (n_clusters) at the same positions
  /// \param pairs  sorted, the lower body first in each
  void find(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
            std::span<const Box> boxes, std::span<const Pair> pairs, std::span<const double> grown);
  [[nodiscard]] std::span<const EdgeTriangle> found() const { return found_; }
  [[nodiscard]] std::span<const Group> groups() const { return groups_; }

  [[nodiscard]] const Clusters& clusters() const { return surface_.clusters; }

 private:
  /// A box in float, rounded outwards.
  struct FloatBox {
    FloatBox() = default;
    explicit FloatBox(const Box& box);
    std::array<float, 3> lower;
    std::array<float, 3> upper;
  };
  /// Boxes of the triangles of a cluster, one per lane; unused lanes meet nothing.
  struct TriangleBoxes {
    std::array<std::array<float, Cluster::most_primitives>, 3> lower;
    std::array<std::array<float, Cluster::most_primitives>, 3> upper;
    void put(const FloatBox& box, std::size_t lane);
    [[nodiscard]] std::uint32_t meeting(const FloatBox& box) const;
  };
  struct Frame;
  void find_boxes(const Frame& frame);
  void choose_clusters(const Frame& frame);
  void pair_clusters(const Frame& frame);
  void list(Index cluster_of_edges, Index cluster_of_triangles, std::vector<EdgeTriangle>& found) const;
  [[nodiscard]] bool is_pair(Index body, Index other) const;

  SurfaceClusters surface_;
  std::vector<Pair> symmetric_pairs_;             ///< the pairs of bodies, each in both orders, sorted
  std::vector<Box> boxes_;                        ///< (n_clusters) of bodies in a pair, grown
  std::vector<Box> body_boxes_;                   ///< (n_bodies) the same
  std::vector<TriangleBoxes> triangle_boxes_;     ///< (n_clusters) of active ones
  std::vector<FloatBox> edge_boxes_;              ///< (n_surface_edges) of active ones, cluster by cluster
  std::vector<std::pair<double, Index>> active_;  ///< clusters near another body, sorted by lower x
  parallel::ChunkedList<Pair> pair_lists_;
  std::vector<Pair> pairs_;  ///< of clusters
  parallel::ChunkedList<EdgeTriangle> lists_;
  std::size_t most_of_chunk_ = 0;  ///< room of each
  std::vector<EdgeTriangle> found_;
  std::vector<Group> groups_;
};

}  // namespace palpate
