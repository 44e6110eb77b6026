#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "simd/cluster.hpp"
#include "simd/fixed_points.hpp"

/// The phases of the clustered query that work on many numbers at a time (docs/query.md).
namespace palpate::simd {

/// The box of a cluster. Points in it count unless their name is in [lower.name, upper.name], or is marked
/// where `skips_marked` has all bits.
struct ClusterBox {
  FixedPoint lower;
  FixedPoint upper;
  std::int32_t skips_marked;  ///< 0 or -1
};

/// Whether points of the cluster's own body count: the corners of its tets are among them then.
inline bool includes_own(const ClusterBox& box) {
  return box.upper.name < box.lower.name;
}

/// Its longest side.
inline float extent_of(const ClusterBox& box) {
  return static_cast<float>(
      std::max({box.upper.x - box.lower.x, box.upper.y - box.lower.y, box.upper.z - box.lower.z}));
}

/// Grows a box on all sides; numbers stay >= 0.
inline void widen(ClusterBox& box, std::int32_t margin) {
  FixedPoint& l = box.lower;
  l = {std::max(0, l.x - margin), std::max(0, l.y - margin), std::max(0, l.z - margin), l.name};
  FixedPoint& u = box.upper;
  u = {u.x + margin, u.y + margin, u.z + margin, u.name};
}

/// Grows a box to whole coarse coordinates.
inline void round_out(ClusterBox& box, int coarse_shift) {
  const std::int32_t rest = (std::int32_t{1} << coarse_shift) - 1;
  FixedPoint& l = box.lower;
  l = {l.x & ~rest, l.y & ~rest, l.z & ~rest, l.name};
  FixedPoint& u = box.upper;
  u = {u.x | rest, u.y | rest, u.z | rest, u.name};
}

/// Points [begin, end) of those in order.
struct PointRange {
  std::uint32_t begin;
  std::uint32_t end;
};

/// What clusters of a block have to do, and what they find: work is cut so that nothing overflows.
struct ClusterBlock {
  static constexpr std::size_t most_clusters = 32;
  static constexpr std::size_t most_rows = 1024;
  static constexpr std::size_t most_points = 4096;
  static constexpr std::size_t padding = 16;  ///< kernels may write that far beyond what they report

  /// A point, and the cluster's tets in bits: those that may contain it, and << 16 those that surely do. None
  /// that the point is a corner of.
  struct Hit {
    std::int32_t entry;     ///< what was tested: index of a point, or entry of L of an edge
    std::uint32_t cluster;  ///< in the block
    std::uint32_t primitives;
  };

  /// Pairs of a candidate and a primitive of its cluster, once filtered.
  [[nodiscard]] std::size_t pairs() const {
    std::size_t sum = 0;
    for (std::size_t c = 0; c < clusters; ++c)
      sum += std::size_t{first_candidate[c + 1] - first_candidate[c]} * cluster[c]->size;
    return sum;
  }

  std::size_t clusters = 0;
  std::array<const Cluster*, most_clusters> cluster;
  const std::uint16_t* at_point = nullptr;  ///< Clusters::at_point, for clusters that take_own()
  alignas(64) std::array<std::array<FixedPoint, Cluster::most_points>, most_clusters> corners;
  std::array<ClusterBox, most_clusters> box;
  std::uint32_t strays = 0;  ///< bit c: rows of cluster c may hold points beyond the cells of its box
  std::array<std::uint32_t, most_clusters + 1> first_row{};  ///< rows of cluster c: up to first_row[c + 1]
  std::array<PointRange, most_rows> rows;
  std::array<std::uint32_t, most_clusters + 1> first_candidate{};
  const std::int32_t* candidates;                             ///< what may hit; at most most_points
  std::array<std::int32_t, most_points + padding> candidate;  ///< room for them
  std::size_t hits = 0;
  std::array<Hit, most_points + 1> hit;
};

/// The kernels of the query, one for each phase.
struct ClusterKernels {
  /// Fetches the corners of each cluster of the block and their box (all but the names).
  /// \param points       all points, by index
  /// \param point_lists  of which a cluster has a part, see Cluster
  void (*load)(std::span<const FixedPoint> points, std::span<const std::int32_t> point_lists,
               ClusterBlock& block);
  /// Lists the points of the rows that lie in the box of their cluster, which is rounded out.
  void (*filter)(const PointRows& points, ClusterBlock& block);
  /// Tests each candidate against all tets of its cluster, and lists those that may be in one. What it leaves
  /// out is outside by exact arithmetic, and what it is sure of is inside.
  void (*test)(const FixedPoint* points, ClusterBlock& block);
  /// As test, of the tets that a candidate may be in once all points have moved by up to `margin` in each
  /// coordinate: what it leaves out stays outside. The boxes hold all places that points move to.
  void (*near)(const FixedPoint* points, std::int32_t margin, ClusterBlock& block);
  /// Fetches the corners of each cluster of the block, without their box.
  void (*gather)(std::span<const FixedPoint> points, std::span<const std::int32_t> point_lists,
                 ClusterBlock& block);
  /// Whether all tets of the block surely have a positive volume.
  bool (*upright)(const ClusterBlock& block);
};

/// With the best SIMD target of this processor.
ClusterKernels cluster_kernels();
namespace scalar {
/// Their twins in plain C++.
ClusterKernels cluster_kernels();
}  // namespace scalar

/// Bound of the error of the volumes that `test` compares with zero, for all tets of a cluster
/// (docs/query.md). \param extent  longest side of the cluster's box
inline float volume_bound(float extent) {
  constexpr float u = 0x1p-24F;
  constexpr float slack = 1.001F;  // for the rounding of the bound itself
  const float coordinate = 0.51F + u * extent;
  const float edge = 2.0F * coordinate + 1.01F * u * extent;
  const float normal = 4.0F * extent * edge + 2.0F * edge * edge + 4.1F * u * extent * extent;
  return slack *
         (3.1F * normal * (extent + 1.1F) + (12.1F * coordinate + 54.0F * u * extent) * extent * extent);
}

/// How far `near` moves the planes of a tet outwards, by the sum of their normals' components, when points
/// move by up to `margin`: two points, and the rounding of their numbers.
inline float reach_of(std::int32_t margin) {
  return 2.0F * static_cast<float>(margin + 2);
}

/// Bound of the error of the volumes that `near` compares with zero (docs/query.md).
inline float near_bound(float extent, std::int32_t margin) {
  constexpr float u = 0x1p-24F;
  const float edge = 1.02F + 3.01F * u * extent;
  const float normal = 4.0F * extent * edge + 2.0F * edge * edge + 4.1F * u * extent * extent;
  const float moved = 3.1F * reach_of(margin) * normal + 40.0F * u * extent * extent * (extent + 8.0F);
  return volume_bound(extent) + 1.001F * moved;
}

}  // namespace palpate::simd
