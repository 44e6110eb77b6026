#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/contact_table.hpp"
#include "contact/edge_search.hpp"
#include "contact/pair_filter.hpp"
#include "geometry/box.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// Finds the surface edges that meet the surface of another body although neither end is in contact with it:
/// exactly those, by the predicate of crossings.
///
/// What of two bodies is near each other is listed once (EdgeSearch), with room for some detections to come,
/// until they have moved further than that against each other. An edge and a triangle of the list that are
/// some distance apart are tested again once their clusters may have closed it. How far two move against each
/// other from one detection to the next is bounded by the boxes of the displacements of their points: what
/// moves alike does not move. Lists change how long it takes, never what is found.
class EdgeQuery {
 public:
  explicit EdgeQuery(const Bodies& bodies);

  /// O(surface points + bodies log bodies + what is near each other), and EdgeSearch::find() for the pairs of
  /// bodies that moved on; parallel. \param contacts  of the same positions
  void find(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
            const PairFilter& may_touch, const ContactTable& contacts);
  /// Sorted by (edge, triangle).
  [[nodiscard]] std::span<const EdgeTriangle> found() const { return found_; }

 private:
  struct Frame;
  class Batch;
  /// A body at a detection.
  struct Motion {
    Box box;     ///< of its points
    Box motion;  ///< of what these went since the last detection
  };
  /// What of two clusters is near each other: `size` of the list.
  struct Group {
    EdgeSearch::Pair clusters;
    std::size_t begin;
    std::size_t size;
    double moved;  ///< against each other since it was listed, at most, m
  };
  struct NearPair {
    EdgeSearch::Pair bodies;
    double usual = 0.0;  ///< relative motion a detection: the last, or half of the one before, m
    double moved = 0.0;  ///< the same since it was listed, at most, m
    double room = -1.0;  ///< relative motion for which the list is complete, m
    // Whether room pays: the list is longer with it, and must serve for that many more detections.
    std::size_t served = 0;  ///< detections since it was listed
    std::size_t bare = 0;    ///< length of the last list without room
    int left_bare = 1;       ///< lists to be made without before it is tried again
    int patience = 8;        ///< how many that were when it was tried last
    std::vector<Group> groups;
    std::vector<EdgeTriangle> near;
    std::vector<float> apart;  ///< (n_near) motion of the group before which they do not meet, m
  };
  void follow(const Frame& frame);
  void pair_bodies(const Frame& frame);
  void list_again(const Frame& frame);
  [[nodiscard]] double room_for(NearPair& pair) const;
  void add_to_lists();
  void test(NearPair& pair, std::size_t group, Batch& batch) const;

  EdgeSearch search_;
  std::vector<double> most_room_;  ///< (n_bodies) m
  std::vector<Vec3> last_;         ///< (n_points) at the last detection; none before the first
  std::vector<Box> boxes_;         ///< (n_clusters)
  std::vector<Box> motions_;       ///< (n_clusters) Motion::motion
  std::vector<Motion> bodies_;
  std::vector<std::pair<double, Index>> body_order_;  ///< by their lower x
  std::vector<NearPair> pairs_;  ///< whose boxes meet and that may touch, the lower body first, sorted
  std::vector<NearPair> next_;   ///< scratch
  std::vector<EdgeSearch::Pair> body_pairs_;  ///< whose boxes meet; then those to be listed again
  std::vector<double> grown_;                 ///< (n_bodies)
  std::vector<std::size_t> begin_;            ///< (n_pairs + 1) of their groups, one behind the other
  parallel::ChunkedList<EdgeTriangle> lists_;
  std::vector<EdgeTriangle> found_;
};

}  // namespace palpate
