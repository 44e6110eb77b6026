#pragma once

#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "contact/cluster_queue.hpp"
#include "contact/list_plan.hpp"
#include "contact/near_lists.hpp"
#include "contact/pair_filter.hpp"
#include "contact/pair_taker.hpp"
#include "contact/point_in_tet.hpp"
#include "contact/query_tally.hpp"
#include "contact/work_limit.hpp"
#include "grid/fixed_positions.hpp"
#include "grid/point_grid.hpp"
#include "mesh/clusters.hpp"
#include "parallel/parallel.hpp"
#include "simd/cluster_query.hpp"

namespace palpate {

/// Point-in-volume query for the compact grid (docs/query.md): looks up the points around clusters of tets,
/// and tests each point against all tets of a cluster at once, in float with an error bound. The exact
/// predicate decides the rest, so the result equals that of PointsInTets.
class ClusterQuery {
 public:
  explicit ClusterQuery(const Bodies& bodies, const simd::ClusterKernels& kernels = simd::cluster_kernels())
      : clusters_(make_tet_clusters(bodies)),
        kernels_(kernels),
        queue_(clusters_.clusters.size()),
        lists_(bodies, clusters_.clusters.size()) {}

  /// For coherence: allows the next find() to use near lists of earlier frames. Returns whether find() needs
  /// the grid; if not, the grid may be that of an earlier frame. Without this call, find() queries all
  /// clusters in the grid.
  /// \param fixed        the positions of the next find()
  /// \param new_lattice  whether the lattice differs from that of the last call
  bool begin_frame(const parallel::Threads& threads, const Bodies& bodies, const FixedPositions& fixed,
                   bool new_lattice);

  /// The state that begin_frame() uses: the plan, and the positions for which lists were made (empty if there
  /// are no lists).
  [[nodiscard]] const ListPlan& plan() const { return plan_; }
  [[nodiscard]] std::span<const simd::FixedPoint> listed_points() const {
    return plan_.has_lists() ? lists_.reference() : std::span<const simd::FixedPoint>{};
  }
  /// Restores this state; `grid` and `fixed` hold the positions.
  void recall(const ListPlan::Numbers& plan, const parallel::Threads& threads, const Bodies& bodies,
              const PairFilter& may_touch, const PointGrid& grid, const FixedPositions& fixed);

  /// \param grid   contains the points of `fixed`
  /// \param fixed  marks the points of immovable bodies
  void find(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
            const PairFilter& may_touch, const PointGrid& grid, const FixedPositions& fixed);

  /// As find(), but within a limit, with the most important clusters first. It finds a subset of the pairs of
  /// find(). Call close() of the queue afterwards.
  void find_within(const WorkLimit& limit, const parallel::Threads& threads, const Bodies& bodies,
                   std::span<const Vec3> positions, const PairFilter& may_touch, const PointGrid& grid,
                   const FixedPositions& fixed);
  [[nodiscard]] ClusterQueue& queue() { return queue_; }
  [[nodiscard]] const ClusterQueue& queue() const { return queue_; }

  /// The points in tets, in arbitrary order, but the same for every thread count.
  [[nodiscard]] std::span<const PointInTet> found() const { return found_; }
  /// Counts of the last query. Its candidates are pairs of a point and a tet: the point is in the box of the
  /// tet's cluster, or on its near list. Corners of the tet count.
  [[nodiscard]] QueryTally tally() const { return total(tallies_); }
  [[nodiscard]] const Clusters& clusters() const { return clusters_; }
  [[nodiscard]] const NearLists& lists() const { return lists_; }
  [[nodiscard]] FrameMode last_mode() const { return last_mode_; }

 private:
  void find_upright_bodies(const parallel::Threads& threads, const PairFilter& may_touch,
                           const FixedPositions& fixed);
  void ask_clusters(const parallel::Threads& threads, const PairContext& pairs, const LookupContext& context,
                    std::span<const Cluster> clusters);
  void ask_lists(const parallel::Threads& threads, const PairContext& pairs, const FixedPositions& fixed);

  Clusters clusters_;
  simd::ClusterKernels kernels_;
  ClusterQueue queue_;
  NearLists lists_;
  ListPlan plan_;
  FrameMode mode_ = FrameMode::all;       ///< how the next find() queries
  FrameMode last_mode_ = FrameMode::all;  ///< how the last find() queried
  QueueRun<PointInTet> run_;
  parallel::ChunkedList<PointInTet> found_in_chunks_;
  std::vector<PointInTet> found_;
  std::vector<QueryTally> tallies_;
  std::vector<std::uint8_t> upright_chunks_;
  /// (n_bodies) 1: the body has self-collision and all its tets certainly have positive volume, so it has no
  /// folds.
  std::vector<std::uint8_t> upright_;
};

}  // namespace palpate
