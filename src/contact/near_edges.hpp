#pragma once

#include <array>
#include <bit>
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
  /// \param wanted  wanted(side, place): whether to test an edge
  template <class Wanted>
  void list(double margin, Wanted&& wanted, std::vector<NearEdge>& found) {
    if (!find_common_part(margin)) return;
    const std::size_t sides = clusters_[0] == clusters_[1] ? 1 : 2;
    for (std::size_t side = 0; side < sides; ++side) {
      const std::uint32_t facing = place_triangles(side);
      const std::size_t blocks = facing == 0 ? 0 : frame_.blocks.of(clusters_[side]).size();
      for (std::size_t block = 0; block < blocks; ++block) {
        for (std::uint32_t left = place_edges(side, block, of_facing_); left != 0; left &= left - 1) {
          const auto lane = static_cast<std::size_t>(std::countr_zero(left));
          if (wanted(side, lanes * block + lane)) test(side, block, lane, facing, found);
        }
      }
    }
  }

  /// Tests an edge and its near triangles again; sets touching and apart.
  void test_again(NearEdge& edge);

 private:
  static constexpr std::size_t lanes = Cluster::most_primitives;
  static constexpr std::size_t none = ~std::size_t{0};
  void read_points(std::size_t side);
  void find_common_points();
  bool find_common_part(double margin);
  std::uint32_t place_triangles(std::size_t side);
  std::uint32_t place_edges(std::size_t side, std::size_t block, const simd::FloatBox& box);
  void test(std::size_t side, std::size_t block, std::size_t lane, std::uint32_t facing,
            std::vector<NearEdge>& found) const;
  [[nodiscard]] NearEdge edge_of(std::size_t side, std::size_t block, std::size_t lane,
                                 const simd::NearTriangles& near) const;

  const Frame& frame_;
  std::array<Index, 2> clusters_{-1, -1};
  Vec3 origin_;  ///< the middle of the first cluster
  std::array<simd::LocalPoints, 2> points_;
  bool of_one_body_ = false;
  /// [side][point of its cluster] bits of the other cluster's triangles with that corner, if of one body.
  std::array<std::array<std::uint16_t, Cluster::most_points>, 2> at_point_{};
  float rounding_ = 0.0F;      ///< bound of the errors of distances, in units
  float margin_ = 0.0F;        ///< in units
  simd::FloatBox of_facing_;   ///< of the triangles there, grown by the margin
  simd::FloatBox around_;      ///< where the two surfaces can be within the margin
  std::size_t placed_ = none;  ///< side whose edges face the triangles in the lanes
  std::size_t placed_block_ = none;
  simd::TriangleLanes triangles_;
  simd::SegmentLanes segments_;
};

}  // namespace palpate
