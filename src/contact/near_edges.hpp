#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "contact/surface_clusters.hpp"
#include "geometry/box.hpp"
#include "simd/near_triangles.hpp"

namespace palpate {

/// An edge of one of two clusters, and the triangles of the other one that are near it and share no point
/// with it.
struct NearEdge {
  std::uint8_t side;       ///< 0: an edge of the first cluster, 1: of the second
  std::uint8_t place;      ///< index among the edges of its cluster
  std::uint16_t near;      ///< bits of triangles within the margin
  std::uint16_t touching;  ///< bits of those that may touch it; an exact test decides
  float apart;             ///< lower bound of the distance from each near one, m; 0 if one may touch
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

/// The surfaces of two clusters at the positions of a detection: tests edges of each against triangles of the
/// other by distances in float. An edge and a triangle that meet are always near and touching, except if they
/// share a point. The clusters may be of one body; a cluster may face itself.
class FacingClusters {
 public:
  struct Frame {
    const SurfaceClusters& surface;
    const EdgeBlocks& blocks;
    std::span<const Vec3> positions;
    std::span<const Box> boxes;  ///< (n_clusters) of the positions
    double unit = 1.0;           ///< of lengths in float, m: a power of two, no box above 2^30 of it
  };
  explicit FacingClusters(const Frame& frame) : frame_(frame) {}

  /// Reads the points of two clusters; those of the first one only if it is another one than before.
  void face(Index first, Index second);

  /// Appends the edges with triangles within `margin` (m), those of the first cluster first. O(edges of the
  /// clusters), less where few are in the common part of their boxes.
  void list(double margin, std::vector<NearEdge>& found);

  /// Tests an edge and its near triangles again: sets touching and apart, once finish() is called. Until
  /// then, the edge stays where it is.
  void test_again(NearEdge& edge);
  void finish() { test_pairs(); }

 private:
  static constexpr std::size_t lanes = Cluster::most_primitives;
  void read_points(std::size_t side);
  void find_common_points();
  bool find_common_part(double margin);
  std::uint32_t place_triangles(std::size_t side);
  std::uint32_t place_edges(std::size_t side, std::size_t block);
  void choose_triangles(std::size_t side, std::size_t block, std::uint32_t facing);
  void list_side(std::size_t side, std::vector<NearEdge>& found);
  void add_pairs(NearEdge& edge, std::uint32_t triangles);
  void test_pairs();

  const Frame& frame_;
  std::array<Index, 2> clusters_{-1, -1};
  Vec3 origin_;  ///< the middle of the first cluster
  std::array<simd::LocalPoints, 2> points_;
  bool of_one_body_ = false;
  /// [side][point of its cluster] bits of the other cluster's triangles with that corner, if of one body.
  std::array<std::array<std::uint16_t, Cluster::most_points>, 2> at_point_{};
  float rounding_ = 0.0F;     ///< bound of the errors of distances, in units
  float margin_ = 0.0F;       ///< in units
  simd::FloatBox of_facing_;  ///< of the triangles there, grown by the margin
  simd::FloatBox around_;     ///< where the two surfaces can be within the margin
  simd::BoxLanes triangles_;
  simd::BoxLanes segments_;
  std::array<std::uint16_t, lanes> wanted_{};  ///< triangles to test with each edge of a block
  // Pairs to test, all with edges of one side:
  std::size_t waiting_ = 0;
  simd::SegmentTrianglePairs pairs_;
  std::array<NearEdge*, lanes> edge_of_pair_{};
  std::array<std::uint16_t, lanes> triangle_of_pair_{};  ///< its bit
};

}  // namespace palpate
