#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "contact/cluster_lookup.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// For each cluster of tets, the points that may enter it while no point of the scene is further than the
/// allowed motion from its reference along any axis (docs/query.md, "Coherence"). The reference is the frame
/// for which the lists were made. A body with a point further away is stale, and so are the clusters near its
/// current points. Lists of other clusters stay valid.
class NearLists {
 public:
  NearLists(const Bodies& bodies, std::size_t clusters);

  /// Makes all lists, for the points in context.fixed.
  void make(const parallel::Threads& threads, const LookupContext& context);

  /// Finds the clusters that are stale now, in the lattice of the reference. O(points + clusters x fast
  /// bodies).
  void update(const parallel::Threads& threads, const Bodies& bodies, const Clusters& clusters,
              const FixedPositions& fixed);
  /// Clusters that are stale by the last update(); none after make().
  [[nodiscard]] std::span<const Cluster> stale() const { return stale_; }
  /// Clusters with a valid list that is not empty; ascending.
  [[nodiscard]] std::span<const std::uint32_t> asked() const { return asked_; }

  [[nodiscard]] std::span<const Index> list(std::size_t cluster) const {
    return std::span(points_).subspan(begin_[cluster], begin_[cluster + 1] - begin_[cluster]);
  }
  /// All lists, one after the other.
  [[nodiscard]] std::span<const Index> points() const { return points_; }
  [[nodiscard]] std::span<const std::uint32_t> begin() const { return begin_; }
  /// A box that contains the cluster and its list while they are valid.
  [[nodiscard]] const simd::ClusterBox& box(std::size_t cluster) const { return boxes_[cluster]; }

  [[nodiscard]] std::span<const simd::FixedPoint> reference() const { return reference_; }
  [[nodiscard]] std::size_t bytes() const;

 private:
  /// Some points of one body: the work of one chunk.
  struct Piece {
    Range points;
    Index body;
  };

  void list_chunk(const LookupContext& context, std::size_t begin, std::size_t end, std::vector<Index>& list);
  void list_asked();
  void mark_stale(std::span<const Cluster> clusters);
  void find_fast_bodies(const parallel::Threads& threads, const Bodies& bodies, const FixedPositions& fixed);

  std::size_t clusters_;
  std::vector<Piece> pieces_;
  std::vector<std::int32_t> motion_of_piece_;
  std::int32_t max_motion_ = 0;  ///< allowed motion of points, in fractions of a cell (fixed-point)
  std::vector<simd::FixedPoint> reference_;  ///< (n_points)
  std::vector<simd::ClusterBox> boxes_;      ///< (n_clusters)
  std::vector<std::uint32_t> begin_;         ///< (n_clusters + 1) into points_
  std::vector<Index> points_;
  parallel::ChunkedList<Index> lists_of_chunks_;
  std::vector<std::uint32_t> listed_;  ///< clusters with a list that is not empty
  std::vector<std::uint32_t> asked_;
  std::vector<Cluster> stale_;
  std::vector<std::uint8_t> is_stale_;  ///< (n_clusters)
  std::vector<std::uint8_t> is_fast_;   ///< (n_bodies)
  /// Boxes around the current points of fast bodies; one box for all of them if there are many.
  std::vector<simd::ClusterBox> fast_;
};

}  // namespace palpate
