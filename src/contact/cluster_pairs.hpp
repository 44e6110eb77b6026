#pragma once

#include <span>
#include <utility>
#include <vector>

#include <palpate/mesh.hpp>

#include "contact/surface_clusters.hpp"
#include "geometry/box.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// Two bodies, or two clusters.
using IndexPair = std::pair<Index, Index>;

/// Two bodies whose clusters are wanted, or twice the same body.
struct FacingBodies {
  IndexPair bodies;
  Box common;           ///< the common part of both boxes, each grown by the margin
  double margin = 0.0;  ///< m
  Index number = 0;     ///< given by the caller, for Found
};

/// Finds the surface clusters of two bodies whose boxes are within a margin of each other: those near the
/// other body by a sweep along the longest axis of the common part of both bodies' boxes. For a body and
/// itself, these are all such clusters of it, each cluster and itself included.
class ClusterPairs {
 public:
  /// Clusters of the two bodies of a pair.
  struct Found {
    IndexPair clusters;  ///< of one of the bodies, and of the other
    Index number;        ///< of the pair of bodies
  };

  explicit ClusterPairs(const SurfaceClusters& surface) : surface_(surface) {}

  /// Ordered by pair; those with the same first cluster follow each other. Valid until the next call.
  /// O(clusters of the bodies + n log n + pairs that meet along the axis), n clusters near the other body;
  /// parallel.
  /// \param boxes  (n_clusters)
  std::span<Found> find(const parallel::Threads& threads, std::span<const Box> boxes,
                        std::span<const FacingBodies> pairs);

 private:
  /// A cluster near the other body of a pair.
  struct Active {
    double lower;  ///< of its box along the axis, m
    double upper;  ///< the same, grown by the margin, m
    Index cluster;
    Index pair;
  };
  void choose_clusters(std::span<const Box> boxes, const FacingBodies& pair, Index number);
  void sweep(std::size_t begin, std::size_t end, std::span<const Box> boxes,
             std::span<const FacingBodies> pairs, std::vector<Found>& found) const;

  const SurfaceClusters& surface_;
  std::vector<Active> active_;  ///< sorted by pair, then by their lower ends
  parallel::ChunkedList<Found> lists_;
  std::vector<Found> found_;
};

}  // namespace palpate
