#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/chunks_in_time.hpp"
#include "contact/cluster_motions.hpp"
#include "contact/cluster_pairs.hpp"
#include "contact/contact_table.hpp"
#include "contact/deadline.hpp"
#include "contact/lost_contacts.hpp"
#include "contact/near_columns.hpp"
#include "contact/near_edges.hpp"
#include "contact/pair_filter.hpp"
#include "contact/surface_clusters.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// Work of a search with a deadline, in pairs of clusters.
struct EdgeWork {
  std::size_t all = 0;
  std::size_t late = 0;               ///< left out
  std::vector<IndexPair> late_pairs;  ///< their bodies
};

/// Finds the surface edges that meet the surface of a body although neither end is in contact with it:
/// exactly those, by the predicate of crossings. The body is another one, or with self-collision the edge's
/// own; then an edge and a triangle that share a point do not count, nor do folds (layers.hpp).
///
/// What is near is stored at two levels, each with a margin for later detections. Two bodies have a list of
/// the pairs of their surface clusters, valid until the bodies have moved relative to each other by its
/// margin. Each pair of clusters has a list of edges with their near triangles, valid until the two clusters
/// have. A pair of this list at some distance is tested again only when the clusters may have closed it; a
/// pair whose edge is in contact, only when a point of the clusters has lost a contact. The
/// relative motion between two detections is bounded by the boxes of the displacements of points, so a common
/// motion counts as none. Lists affect the time, never the result.
///
/// A search with a deadline leaves out pairs of clusters after it, chunk by chunk. The next search begins
/// with them.
class EdgeQuery {
 public:
  /// \param keeps_lists  whether lists of earlier searches are used; without, all are made in each search
  EdgeQuery(const Bodies& bodies, bool keeps_lists);

  /// O(surface points + bodies log bodies + pairs of near clusters + edges of clusters that are listed or
  /// tested); parallel.
  /// \param contacts  of the same positions
  void find(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
            const PairFilter& may_touch, const ContactTable& contacts, const Deadline& deadline);
  /// The edges and triangles that meet, sorted by (edge, triangle).
  [[nodiscard]] std::span<const EdgeTriangle> found() const { return found_; }
  /// The work of the last find(); zero without a deadline.
  [[nodiscard]] const EdgeWork& work() const { return work_; }

 private:
  struct Frame;
  class Tests;
  /// The relative motion of two bodies, and what a list of their clusters is valid for.
  struct Validity {
    double usual = 0.0;  ///< relative motion per detection: the last, or half of the one before, m
    double moved = 0.0;  ///< bound of the relative motion since it was listed, m
    double room = -1.0;  ///< relative motion for which the list is complete, m; negative: there is none
    void move(double by) {
      constexpr double rounding = 1.0 + 1e-12;
      usual = std::max(by, 0.5 * usual);
      moved = rounding * (moved + by);
    }
    [[nodiscard]] bool is_valid() const { return moved <= room; }
  };
  struct NearPair {
    IndexPair bodies;
    Validity validity;
    ClusterGroups groups;  ///< sorted by clusters
    // With a deadline:
    std::size_t first = 0;   ///< group with which the search begins
    bool has_found = false;  ///< in the last search
    bool is_late = false;    ///< not all of it was tested in this search
    int waited = 0;          ///< searches since all of it was tested
  };
  /// A group to list or to test.
  struct Task {
    std::size_t pair;
    std::size_t group;
    bool is_listed;  ///< its list is valid
  };
  [[nodiscard]] double margin_of_list(double usual, double most) const;
  void pair_bodies(const Frame& frame);
  void pair_clusters(const Frame& frame);
  void take_clusters(NearPair& pair, std::span<const ClusterPairs::Found> facing);
  void free_lost(const Frame& frame);
  void choose_tasks(const Frame& frame);
  void choose(std::size_t number, const std::pair<std::size_t, std::size_t>& places,
              std::vector<Task>& tasks);
  void list_groups(const Frame& frame);
  void list(const Task& task, FacingClusters& facing, std::vector<NearEdge>& found);
  void list_some(const Frame& frame, std::span<const std::size_t> tasks, std::size_t first);
  void take_lists(const parallel::Threads& threads, std::span<const std::size_t> tasks);
  void drop_unused();
  void test_groups(const Frame& frame);
  [[nodiscard]] static bool is_folded(const Frame& frame, const EdgeTriangle& pair);
  [[nodiscard]] double most_room(const NearPair& pair) const;

  void order_pairs();
  void leave_out_tasks();
  void end_pairs(const Bodies& bodies);

  bool keeps_lists_;
  SurfaceClusters surface_;
  EdgeBlocks blocks_;
  ClusterPairs clusters_;
  std::vector<double> reach_;  ///< (n_bodies) rim_reach(), m
  ClusterMotions motions_;
  LostContacts lost_;
  std::vector<std::pair<double, Index>> body_order_;  ///< sorted by lower x
  /// Whose boxes meet and that may touch, the lower body first, sorted. A body may be paired with itself.
  std::vector<NearPair> pairs_;
  std::vector<NearPair> next_;          ///< scratch
  std::vector<IndexPair> body_pairs_;   ///< those of pairs_
  std::vector<FacingBodies> unlisted_;  ///< pairs without a valid list
  ClusterGroups groups_;                ///< scratch
  std::vector<std::size_t> order_;      ///< (n_pairs) of the search
  std::vector<std::size_t> begin_;      ///< (n_pairs + 1) of their groups, in that order
  NearEdges near_;                      ///< of all groups
  NearEdges kept_;                      ///< scratch
  std::size_t unused_ = 0;              ///< items of near_
  std::size_t longest_list_ = 0;        ///< room for the list of each chunk
  bool is_timed_ = false;               ///< there is a deadline
  std::vector<Task> tasks_;             ///< in the order of the search
  std::vector<std::size_t> to_list_;    ///< numbers of tasks
  ChunksInTime listing_;
  ChunksInTime testing_;
  EdgeWork work_;
  parallel::ChunkedList<Task> task_lists_;
  parallel::ChunkedList<NearEdge> near_lists_;
  parallel::ChunkedList<EdgeTriangle> lists_;
  std::vector<EdgeTriangle> found_;
};

}  // namespace palpate
