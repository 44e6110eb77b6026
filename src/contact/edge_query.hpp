#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/contact_table.hpp"
#include "contact/pair_filter.hpp"
#include "geometry/box.hpp"
#include "mesh/clusters.hpp"
#include "mesh/surface_sides.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// A surface edge and a surface triangle of another body that it meets.
struct EdgeHit {
  Index edge;
  Index triangle;
};

/// Finds the surface edges that meet the surface of another body although neither end is in contact with it:
/// exactly those, by the predicate of crossings. Clusters of surface triangles, each with the edges that it
/// owns, are paired where their boxes meet (a sweep along x), then edges and triangles by their boxes.
class EdgeQuery {
 public:
  EdgeQuery(const Bodies& bodies, const SurfaceSides& sides);

  /// O(surface triangles near other bodies + pairs of clusters whose boxes meet along x), parallel.
  /// \param contacts  of the same positions
  void find(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
            const PairFilter& may_touch, const ContactTable& contacts);
  /// Sorted by (edge, triangle).
  [[nodiscard]] std::span<const EdgeHit> found() const { return found_; }

 private:
  using Pair = std::pair<Index, Index>;
  /// Rounded outwards.
  struct FloatBox {
    FloatBox() = default;
    explicit FloatBox(const Box& box);
    std::array<float, 3> lower;
    std::array<float, 3> upper;
  };
  /// Of the triangles of a cluster, a lane each; those beyond the last are met by nothing.
  struct TriangleBoxes {
    std::array<std::array<float, Cluster::most_primitives>, 3> lower;
    std::array<std::array<float, Cluster::most_primitives>, 3> upper;
    void put(const FloatBox& box, std::size_t lane);
    [[nodiscard]] std::uint32_t meeting(const FloatBox& box) const;
  };
  struct Frame;
  void find_boxes(const Frame& frame);
  void pair_bodies(const Frame& frame);
  void choose_clusters(const Frame& frame);
  void pair_clusters(const Frame& frame);
  void test(const Frame& frame, Index cluster_of_edges, Index cluster_of_triangles,
            std::vector<EdgeHit>& found) const;

  Clusters clusters_;
  Rows edges_;                                 ///< (n_clusters) that each owns
  std::vector<Box> boxes_;                     ///< (n_clusters)
  std::vector<Box> body_boxes_;                ///< (n_bodies)
  std::vector<TriangleBoxes> triangle_boxes_;  ///< (n_clusters) of active ones
  std::vector<FloatBox> edge_boxes_;           ///< (n_surface_edges) of active ones, as edges_ has them
  std::vector<std::pair<double, Index>> body_order_;  ///< by their lower x
  std::vector<Pair> body_pairs_;                  ///< whose boxes meet and that may touch, both ways, sorted
  std::vector<std::pair<double, Index>> active_;  ///< clusters near another body, by their lower x
  parallel::ChunkedList<Pair> pair_lists_;
  std::vector<Pair> pairs_;  ///< of clusters
  parallel::ChunkedList<EdgeHit> hit_lists_;
  std::vector<EdgeHit> found_;
};

}  // namespace palpate
