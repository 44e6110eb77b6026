#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/chunks_in_time.hpp"
#include "contact/cluster_pairs.hpp"
#include "contact/contact_table.hpp"
#include "contact/deadline.hpp"
#include "contact/near_edges.hpp"
#include "contact/pair_filter.hpp"
#include "contact/surface_clusters.hpp"
#include "geometry/box.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// A surface edge, and a surface triangle that has no common point with it in the mesh.
struct EdgeTriangle {
  Index edge;
  Index triangle;
};

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
/// Where two bodies move little against each other, edges and their near triangles are listed once, with a
/// margin for later detections. The list is valid until the relative motion of the bodies exceeds the margin.
/// An edge of the list at some distance is tested again only when the clusters may have closed it. The
/// relative motion of two clusters between detections is bounded by the boxes of the displacements of their
/// points, so a common motion counts as none. Where bodies move fast, all near edges are tested in each
/// detection, without a list. Lists affect the time, never the result.
///
/// A search with a deadline leaves out clusters after it, chunk by chunk. The next search begins with them.
class EdgeQuery {
 public:
  explicit EdgeQuery(const Bodies& bodies);

  /// O(surface points + bodies log bodies + listed edges + edges in the common parts of the boxes of clusters
  /// without a list); parallel.
  /// \param contacts  of the same positions
  void find(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
            const PairFilter& may_touch, const ContactTable& contacts, const Deadline& deadline);
  /// The edges and triangles that meet, sorted by (edge, triangle).
  [[nodiscard]] std::span<const EdgeTriangle> found() const { return found_; }
  /// The work of the last find(); zero without a deadline.
  [[nodiscard]] const EdgeWork& work() const { return work_; }

 private:
  /// Group::moved after a search that left out the group: NearPair::moved bounds it.
  static constexpr double unknown_motion = -1.0;
  struct Frame;
  /// A body at a detection.
  struct Motion {
    Box box;     ///< of its points
    Box motion;  ///< of their displacements since the last detection
  };
  /// The near edges of two clusters: `size` entries of the list.
  struct Group {
    IndexPair clusters;
    std::size_t begin;
    std::size_t size;
    double moved;  ///< bound of the relative motion since it was listed, m; or unknown_motion
    float apart;   ///< motion up to which no edge must be tested again or may touch, m
  };
  struct NearPair {
    IndexPair bodies;
    double usual = 0.0;  ///< relative motion per detection: the last, or half of the one before, m
    double moved = 0.0;  ///< bound of the relative motion since it was listed, m
    double room = -1.0;  ///< relative motion for which the list is complete, m; not above 0: there is none
    // Whether a margin pays: it makes the list longer, so the list must serve for more detections.
    std::size_t served = 0;  ///< detections since it was listed
    int left_bare = 1;       ///< detections without a list before it is tried again
    int patience = 8;        ///< the value of left_bare after the last try
    // With a deadline:
    bool has_found = false;   ///< in the last search
    bool is_late = false;     ///< not all of it was tested in this search
    bool is_partial = false;  ///< its list lacks clusters
    int waited = 0;           ///< searches since all of it was tested
    std::size_t listed = 0;   ///< pairs of clusters before those that were left out, modulo their number
    std::vector<Group> groups;
    std::vector<NearEdge> near;
  };
  double follow(const parallel::Threads& threads, std::span<const Vec3> positions);
  void pair_bodies(const Frame& frame);
  void list_again(const Frame& frame);
  [[nodiscard]] double room_for(NearPair& pair) const;
  void list(const Frame& frame, const ClusterPairs::Found& pair, FacingClusters& facing,
            std::vector<NearEdge>& found) const;
  void take_lists();
  void test_fresh(const Frame& frame);
  void test_listed(const Frame& frame);
  void test_group(const Frame& frame, NearPair& pair, Group& group, FacingClusters& facing,
                  std::vector<EdgeTriangle>& found) const;
  [[nodiscard]] Index edge_of(const IndexPair& clusters, const NearEdge& near) const;
  [[nodiscard]] const Cluster& faced_by(const IndexPair& clusters, const NearEdge& near) const;
  [[nodiscard]] static bool is_folded(const Frame& frame, const Edge& ends, Index triangle);
  void test_exactly(const Frame& frame, const IndexPair& clusters, const NearEdge& near,
                    std::vector<EdgeTriangle>& found) const;

  void order_pairs();
  void rotate_clusters();
  void leave_out_clusters();
  void leave_out_groups();
  void end_pairs(const Bodies& bodies);

  SurfaceClusters surface_;
  EdgeBlocks blocks_;
  ClusterPairs clusters_;
  std::vector<double> most_room_;  ///< (n_bodies) m
  std::vector<Vec3> last_;         ///< (n_points) at the last detection; none before the first
  std::vector<Box> boxes_;         ///< (n_clusters)
  std::vector<Box> motions_;       ///< (n_clusters) Motion::motion
  std::vector<Motion> bodies_;
  std::vector<std::pair<double, Index>> body_order_;  ///< sorted by lower x
  /// Whose boxes meet and that may touch, the lower body first, sorted. A body may be paired with itself.
  std::vector<NearPair> pairs_;
  std::vector<NearPair> next_;             ///< scratch
  std::vector<IndexPair> body_pairs_;      ///< those of pairs_
  std::vector<std::size_t> begin_;         ///< (n_pairs + 1) of their groups, one after the other
  std::vector<FacingBodies> unlisted_;     ///< pairs without a valid list
  std::span<ClusterPairs::Found> facing_;  ///< their clusters
  std::vector<std::size_t> fresh_begin_;   ///< (n_facing + 1) of their near edges
  bool is_timed_ = false;                  ///< there is a deadline
  std::vector<std::size_t> order_;         ///< (n_pairs) of the search
  ChunksInTime listing_;
  ChunksInTime testing_;
  EdgeWork work_;
  parallel::ChunkedList<NearEdge> near_lists_;
  std::vector<NearEdge> near_;  ///< of all facing clusters
  parallel::ChunkedList<EdgeTriangle> lists_;
  std::vector<EdgeTriangle> found_;
};

}  // namespace palpate
