#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "contact/pair_filter.hpp"
#include "contact/surface_clusters.hpp"
#include "geometry/box.hpp"
#include "parallel/parallel.hpp"
#include "simd/cluster_motions.hpp"

namespace palpate {

/// Where surface clusters and bodies are, and bounds on how much nearer two of them came to each other
/// between two detections.
///
/// The displacements of the points of a cluster have a box. Points of two clusters came nearer by no more
/// than the largest difference of two displacements, so a common motion counts as none. Within a body, a
/// common rotation counts as none, too: displacements are t + w x p + r, with t and w of the body, and only
/// the remainders r count, since no vector v + w x v is shorter than v.
class ClusterMotions {
 public:
  ClusterMotions(const SurfaceClusters& surface, const Bodies& bodies);

  /// Follows all clusters to new positions. O(points), parallel.
  /// \param may_touch  tells within which bodies bounds are wanted
  void follow(const parallel::Threads& threads, std::span<const Vec3> positions, const PairFilter& may_touch);

  [[nodiscard]] std::span<const Box> boxes() const { return boxes_; }  ///< (n_clusters)
  [[nodiscard]] const Box& box_of_body(Index body) const { return at(bodies_, body).box; }
  /// The largest side of all boxes of clusters, m.
  [[nodiscard]] double largest_side() const { return largest_side_; }
  /// Bound on how much nearer two bodies came in the last follow(), m; or parts of one body.
  [[nodiscard]] double of_bodies(Index a, Index b) const {
    return nearer(at(bodies_, a).motion, at(bodies_, b).motion, a == b);
  }
  /// Displacements (n_clusters) in the last follow(); within a body, less its common motion. Two clusters
  /// came nearer to each other by no more than the largest distance of two of their displacements.
  [[nodiscard]] const simd::DisplacementBox* of_clusters(bool within_body) const {
    return (within_body ? remainders_ : displacements_).data();
  }

 private:
  /// Boxes, grown by the errors of rounding.
  struct Motion {
    Box displacements;
    Box remainders;  ///< only where bounds within the body are wanted
  };
  struct BodyMotion {
    Range points;
    Box box;
    Motion motion;
    bool is_still = false;  ///< it has not moved
    bool rests = false;     ///< and not before either, so that all that is known of it stays
    bool may_touch_itself = false;
    simd::LinearMotion common{};  ///< t + w x p
    double error = 0.0;           ///< of the common motion, m
  };
  /// Some clusters of one body, followed together.
  struct Piece {
    Range clusters;
    Index body;
    Box box{};
    Motion motion{};
    double largest_side = 0.0;
  };
  [[nodiscard]] static double nearer(const Motion& a, const Motion& b, bool of_one_body) {
    return of_one_body ? largest_distance(a.remainders, b.remainders)
                       : largest_distance(a.displacements, b.displacements);
  }
  [[nodiscard]] simd::LinearMotion common_motion(std::span<const Vec3> positions, Index body) const;
  void begin(std::span<const Vec3> positions, Index number, bool may_touch_itself);
  void follow(std::span<const Vec3> positions, Piece& piece);
  void join_pieces();

  const SurfaceClusters& surface_;
  std::vector<Vec3> last_;  ///< (n_points) at the last follow(); none before the first
  std::vector<Box> boxes_;  ///< (n_clusters)
  std::vector<simd::DisplacementBox> displacements_;  ///< (n_clusters)
  std::vector<simd::DisplacementBox> remainders_;     ///< (n_clusters), of bodies that may touch themselves
  std::vector<BodyMotion> bodies_;
  std::vector<Piece> pieces_;
  double largest_side_ = 0.0;
};

}  // namespace palpate
