#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/cell_crossings.hpp"
#include "contact/cluster_queue.hpp"
#include "contact/crossing_query.hpp"
#include "contact/triangle_tree.hpp"
#include "grid/compact.hpp"
#include "mesh/clusters.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// Edge-triangle query for the compact grid (docs/query.md). The border edges of a contact form a star around
/// its point. Each star searches a tree of boxes over the triangles of the penetrated body. A float filter
/// with an error bound precedes the exact predicate, so the result is that of CellCrossings. Where the
/// lattice has no fixed positions, CellCrossings finds it.
class ClusteredCrossings final : public CrossingQuery {
 public:
  ClusteredCrossings(const Bodies& bodies, const DetectionSettings& settings)
      : clusters_(make_triangle_clusters(bodies)),
        tree_(bodies, clusters_),
        queue_(clusters_.clusters.size()),
        in_cells_(CompactGrid(settings.order, settings.sort)) {}

  void find(const Frame& frame, const BorderEdgeView& border, const std::optional<WorkLimit>& limit) override;

  [[nodiscard]] std::span<const EdgeInTriangle> found() const override {
    return is_in_cells_ ? in_cells_.found() : found_;
  }
  /// Its candidates are pairs of an edge and a triangle of the penetrated body: the box of the edge's star
  /// meets the box of the triangle.
  [[nodiscard]] QueryTally tally() const override {
    return is_in_cells_ ? in_cells_.tally() : total(tallies_);
  }
  [[nodiscard]] std::size_t bytes() const override { return tree_.bytes() + in_cells_.bytes(); }
  [[nodiscard]] ClusterQueue* queue() override { return &queue_; }

 private:
  class Work;
  struct Problem;

  void search(const Problem& problem);
  void choose_within(const Problem& problem, const WorkLimit& limit);
  void answer();
  void map_triangles(const Bodies& bodies);
  [[nodiscard]] Index number_of(const Cluster& cluster) const;

  Clusters clusters_;  ///< of the surface triangles
  TriangleTree tree_;
  ClusterQueue queue_;
  std::vector<std::uint8_t> penetrated_;  ///< (n_bodies)
  parallel::ChunkedList<EdgeInTriangle> lists_;
  std::vector<EdgeInTriangle> found_;
  std::vector<QueryTally> tallies_;
  // With a limit:
  QueueRun<Index> run_;               ///< chooses clusters
  std::vector<Index> cluster_of_;     ///< (n_triangles)
  std::vector<std::size_t> costs_;    ///< (n_clusters) tests that each needs
  std::vector<std::uint8_t> wanted_;  ///< (n_clusters) 0: left out; empty without a limit
  CellCrossings<CompactGrid> in_cells_;
  bool is_in_cells_ = false;
};

}  // namespace palpate
