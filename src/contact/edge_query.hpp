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
/// Near edges and triangles of two bodies are listed once (EdgeSearch), with a margin for later detections.
/// The list is valid until the relative motion of the bodies exceeds the margin. An edge and a triangle of
/// the list at some distance are tested again only when their clusters may have closed it. The relative
/// motion of two clusters between detections is bounded by the boxes of the displacements of their points, so
/// a common motion counts as none. Lists affect the time, never the result.
class EdgeQuery {
 public:
  explicit EdgeQuery(const Bodies& bodies);

  /// O(surface points + bodies log bodies + near pairs), and EdgeSearch::find() for pairs of bodies with a
  /// new list; parallel.
  /// \param contacts  of the same positions
  void find(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
            const PairFilter& may_touch, const ContactTable& contacts);
  /// The edges and triangles that meet, sorted by (edge, triangle).
  [[nodiscard]] std::span<const EdgeTriangle> found() const { return found_; }

 private:
  struct Frame;
  class Batch;
  /// A body at a detection.
  struct Motion {
    Box box;     ///< of its points
    Box motion;  ///< of their displacements since the last detection
  };
  /// The near edges and triangles of two clusters: `size` entries of the list.
  struct Group {
    EdgeSearch::Pair clusters;
    std::size_t begin;
    std::size_t size;
    double moved;  ///< bound of the relative motion since it was listed, m
  };
  struct NearPair {
    EdgeSearch::Pair bodies;
    double usual = 0.0;  ///< relative motion per detection: the last, or half of the one before, m
    double moved = 0.0;  ///< bound of the relative motion since it was listed, m
    double room = -1.0;  ///< relative motion for which the list is complete, m
    // Whether a margin pays: it makes the list longer, so the list must serve for more detections.
    std::size_t served = 0;  ///< detections since it was listed
    std::size_t bare = 0;    ///< length of the last list without a margin
    int left_bare = 1;       ///< lists to make without a margin before it is tried again
    int patience = 8;        ///< the value of left_bare after the last try
    std::vector<Group> groups;
    std::vector<EdgeTriangle> near;
    std::vector<float> apart;  ///< (n_near) motion of the group up to which they cannot meet, m
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
  std::vector<std::pair<double, Index>> body_order_;  ///< sorted by lower x
  std::vector<NearPair> pairs_;  ///< whose boxes meet and that may touch, the lower body first, sorted
  std::vector<NearPair> next_;   ///< scratch
  std::vector<EdgeSearch::Pair> body_pairs_;  ///< pairs whose boxes meet; then those to list again
  std::vector<double> grown_;                 ///< (n_bodies)
  std::vector<std::size_t> begin_;            ///< (n_pairs + 1) of their groups, one after the other
  parallel::ChunkedList<EdgeTriangle> lists_;
  std::vector<EdgeTriangle> found_;
};

}  // namespace palpate
