#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "contact/surface_clusters.hpp"
#include "geometry/box.hpp"
#include "simd/edge_triangle_gaps.hpp"
#include "simd/near_triangles.hpp"

namespace palpate {

/// A surface edge and a surface triangle without a common point in the mesh.
struct EdgeTriangle {
  Index edge;
  Index triangle;
};
/// The same, near each other.
struct NearEdge {
  EdgeTriangle pair;
  float apart;  ///< lower bound of their distance, m; 0 if they may meet
};

/// The edges of each surface cluster, as kernels read them: blocks of up to 16.
class EdgeBlocks {
 public:
  explicit EdgeBlocks(const SurfaceClusters& surface, const Bodies& bodies);
  [[nodiscard]] std::span<const simd::CornerPlaces<2>> of(Index cluster) const {
    const auto begin = static_cast<std::size_t>(at(begin_, cluster));
    return std::span(places_).subspan(begin, static_cast<std::size_t>(at(begin_, cluster + 1)) - begin);
  }

 private:
  std::vector<Index> begin_{0};                ///< (n_clusters + 1) blocks
  std::vector<simd::CornerPlaces<2>> places_;  ///< of the ends; unused lanes: 0
};

/// What clusters and their edges and triangles are at the positions of a detection.
struct SurfaceFrame {
  const Bodies& bodies;
  const SurfaceClusters& surface;
  const EdgeBlocks& blocks;
  std::span<const Vec3> positions;
  std::span<const Box> boxes;  ///< (n_clusters) of the positions
  double unit = 1.0;           ///< of lengths in float, m: a power of two, no box above 2^30 of it
};

/// Pairs of an edge and a triangle whose distances are to be found, as many as a kernel takes at a time.
class WaitingPairs {
 public:
  explicit WaitingPairs(const SurfaceFrame& frame)
      : surfaces_{frame.positions.data(), frame.bodies.edges().data(), frame.bodies.triangles().data()},
        unit_(frame.unit) {}
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool has_room(std::size_t pairs) const {
    return size_ + pairs <= simd::EdgeTrianglePairs::most;
  }
  /// Only where there is room. Returns the pair's number.
  std::size_t add(Index edge, Index triangle) {
    pairs_.edge[size_] = edge;
    pairs_.triangle[size_] = triangle;
    return size_++;
  }
  /// Calls use(number, pair, gap) for each pair, and forgets all. The gap is the bound of NearEdge::apart, m;
  /// negative if the two surely meet.
  template <class Use>
  void test(Use&& use) {
    simd::find_gaps(surfaces_, 1.0 / unit_, size_, pairs_);
    const double unit = (1.0 - 1e-6) * unit_;  // for the rounding to float
    for (std::size_t i = 0; i < size_; ++i) {
      const auto gap = static_cast<float>(unit * static_cast<double>(pairs_.gap[i]));
      use(i, EdgeTriangle{pairs_.edge[i], pairs_.triangle[i]}, gap);
    }
    size_ = 0;
  }

 private:
  simd::EdgesAndTriangles surfaces_;
  double unit_;
  std::size_t size_ = 0;
  simd::EdgeTrianglePairs pairs_;
};

/// The surfaces of two clusters at the positions of a detection: finds the edges of each near triangles of
/// the other by boxes and distances in float. An edge and a triangle that meet are always found, except if
/// they share a point. The clusters may be of one body; a cluster may face itself.
class FacingClusters {
 public:
  explicit FacingClusters(const SurfaceFrame& frame) : frame_(frame), waiting_(frame) {}

  /// Appends the pairs within `margin` (m). O(edges of the clusters), less where few are in the common part
  /// of their boxes.
  void list(Index first, Index second, double margin, std::vector<NearEdge>& found);

 private:
  static constexpr std::size_t lanes = Cluster::most_primitives;
  void face(Index first, Index second);
  void read_points(std::size_t side);
  void find_common_points();
  bool find_common_part();
  std::uint32_t place_triangles(std::size_t side);
  std::uint32_t place_edges(std::size_t side, std::size_t block);
  void choose_triangles(std::size_t side, std::size_t block, std::uint32_t facing);
  void list_side(std::size_t side, std::vector<NearEdge>& found);
  void test_waiting(std::vector<NearEdge>& found);

  const SurfaceFrame& frame_;
  std::array<Index, 2> clusters_{-1, -1};
  Vec3 origin_;  ///< the middle of the first cluster
  std::array<simd::LocalPoints, 2> points_;
  bool of_one_body_ = false;
  /// [side][point of its cluster] bits of the other cluster's triangles with that corner, if of one body.
  std::array<std::array<std::uint16_t, Cluster::most_points>, 2> at_point_{};
  double margin_ = 0.0;       ///< m
  float within_ = 0.0F;       ///< the margin and all errors of places in float, in units
  simd::FloatBox of_facing_;  ///< of the triangles there, grown by the margin
  simd::FloatBox around_;     ///< where the two surfaces can be within the margin
  simd::BoxLanes triangles_;
  simd::BoxLanes segments_;
  std::array<std::uint16_t, lanes> wanted_{};  ///< triangles to test with each edge of a block
  WaitingPairs waiting_;
};

}  // namespace palpate
