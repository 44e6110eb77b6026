#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/cell_crossings.hpp"
#include "contact/cluster_queue.hpp"
#include "contact/crossing_query.hpp"
#include "grid/compact.hpp"
#include "mesh/clusters.hpp"
#include "parallel/parallel.hpp"
#include "simd/crossing_query.hpp"

namespace palpate {

/// Edge-triangle query for the compact grid (docs/query.md). Border edges are put into a grid by the cells of
/// their midpoints. Clusters of triangles search in the cells around their boxes, up to half the longest edge
/// away. A float filter with an error bound precedes the exact predicate, so the result is that of
/// CellCrossings. Long edges, and all edges where the lattice has no fixed positions, are searched by single
/// triangles.
class ClusteredCrossings final : public CrossingQuery {
 public:
  ClusteredCrossings(const Bodies& bodies, const DetectionSettings& settings)
      : clusters_(make_triangle_clusters(bodies)),
        queue_(clusters_.clusters.size()),
        single_triangles_(CompactGrid(settings.order, settings.sort)) {}

  void find(const Frame& frame, const BorderEdgeView& border, const std::optional<WorkLimit>& limit) override;

  [[nodiscard]] std::span<const EdgeInTriangle> found() const override { return found_; }
  /// Its candidates are pairs of an edge and a triangle of the penetrated body: the box of the edge meets the
  /// box of the triangle's cluster.
  [[nodiscard]] QueryTally tally() const override {
    QueryTally sum = total(tallies_);
    sum += single_triangles_.tally();
    return sum;
  }
  [[nodiscard]] std::size_t bytes() const override {
    return grid_.bytes() + 7 * row_[0].capacity() * sizeof(std::int32_t) + single_triangles_.bytes();
  }
  [[nodiscard]] ClusterQueue* queue() override { return &queue_; }

 private:
  class Work;
  struct Problem;

  void place_edges(const Problem& problem);
  void put_in_order(const Problem& problem);
  void find_short(const Problem& problem);
  void find_within(const Problem& problem, const WorkLimit& limit);
  void choose_clusters();
  [[nodiscard]] simd::EdgeRows rows() const;

  Clusters clusters_;
  ClusterQueue queue_;
  QueueRun<EdgeInTriangle> run_;
  CompactGrid grid_;
  std::vector<Cell> cells_;  ///< (n_border_edges) cell of each midpoint; no_cell for long edges
  std::vector<std::array<std::int32_t, 3>> longest_of_chunk_;
  std::array<std::int32_t, 3> longest_{};  ///< largest extent along each axis of the edges that are not long
  std::array<std::vector<std::int32_t>, 7> row_;  ///< the arrays of EdgeRows
  std::vector<std::uint8_t> penetrated_;          ///< (n_bodies)
  std::vector<Cluster> active_;                   ///< clusters of penetrated bodies
  parallel::ChunkedList<EdgeInTriangle> lists_;
  std::vector<EdgeInTriangle> found_;
  std::vector<QueryTally> tallies_;
  std::vector<Index> long_edges_;
  CellCrossings<CompactGrid> single_triangles_;
};

}  // namespace palpate
