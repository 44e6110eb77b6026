#pragma once

#include <array>
#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/allowance.hpp"
#include "contact/cluster_queue.hpp"
#include "contact/crossing_parameters.hpp"
#include "contact/query_tally.hpp"
#include "grid/compact.hpp"
#include "grid/fixed_positions.hpp"
#include "mesh/clusters.hpp"
#include "parallel/parallel.hpp"
#include "simd/crossing_query.hpp"

namespace palpate {

/// Edge-triangle query for the compact grid (docs/query.md). Border edges are put into a grid by the cells of
/// their midpoints. Clusters of triangles search in the cells around their boxes, up to half the longest edge
/// away. A float filter with an error bound precedes the exact predicate, so the result is that of
/// CrossingQuery.
class ClusteredCrossings {
 public:
  explicit ClusteredCrossings(const Bodies& bodies)
      : clusters_(make_triangle_clusters(bodies)), queue_(clusters_.clusters.size()) {}

  /// Limits the next find() to an allowance, with the most important clusters first. Call close() of the
  /// queue afterwards. Null: no limit.
  void limit(Allowance* allowance, const std::optional<InterestRegion>& region) {
    allowance_ = allowance;
    region_ = region;
  }
  [[nodiscard]] ClusterQueue& queue() { return queue_; }
  [[nodiscard]] const ClusterQueue& queue() const { return queue_; }

  /// Finds the crossings of all border edges except long ones, whose indices it appends to `left`.
  /// \param fixed  the positions, in `lattice`
  void find(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
            const Contacts& contacts, std::span<const BorderEdge> border_edges, const Lattice& lattice,
            const FixedPositions& fixed, std::vector<Index>& left);

  /// The crossings found, in arbitrary order, but the same for every thread count.
  [[nodiscard]] std::span<const EdgeInTriangle> found() const { return found_; }
  /// Counts of the last find(). Its candidates are pairs of an edge and a triangle of the penetrated body:
  /// the box of the edge meets the box of the triangle's cluster.
  [[nodiscard]] QueryTally tally() const { return total(tallies_); }
  [[nodiscard]] std::size_t bytes() const {
    return grid_.bytes() + 7 * row_[0].capacity() * sizeof(std::int32_t);
  }

 private:
  class Work;
  struct Problem;

  void place_edges(const parallel::Threads& threads, const Problem& problem, std::vector<Index>& left);
  void put_in_order(const parallel::Threads& threads, const Problem& problem);
  void mark_penetrated(const Problem& problem);
  void find_within(const parallel::Threads& threads, const Problem& problem);
  void choose_clusters();
  [[nodiscard]] simd::EdgeRows rows() const;

  Clusters clusters_;
  ClusterQueue queue_;
  QueueRun<EdgeInTriangle> run_;
  Allowance* allowance_ = nullptr;
  std::optional<InterestRegion> region_;
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
};

}  // namespace palpate
