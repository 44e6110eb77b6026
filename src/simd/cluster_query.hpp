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

/// Points in the order of their cells, as arrays of numbers. Each has `row_padding` places beyond its end.
struct PointRows {
  const std::int32_t* x;
  const std::int32_t* y;
  const std::int32_t* z;
  const std::int32_t* name;
};
inline constexpr std::size_t row_padding = 16;

/// The box of a cluster. Points in it count unless their name is in [lower.name, upper.name], or is marked
/// where `skips_marked` has all bits.
struct ClusterBox {
  FixedPoint lower;
  FixedPoint upper;
  std::int32_t skips_marked;  ///< 0 or -1
};

/// Its longest side.
inline float extent_of(const ClusterBox& box) {
  return static_cast<float>(
      std::max({box.upper.x - box.lower.x, box.upper.y - box.lower.y, box.upper.z - box.lower.z}));
}

/// Points [begin, end) of PointRows.
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

  /// A point, and the cluster's tets in bits: those that may contain it, and << 16 those that surely do.
  struct Hit {
    std::int32_t entry;     ///< in PointRows
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
  alignas(64) std::array<std::array<FixedPoint, Cluster::most_points>, most_clusters> corners;
  std::array<ClusterBox, most_clusters> box;
  std::array<std::uint32_t, most_clusters + 1> first_row{};  ///< rows of cluster c: up to first_row[c + 1]
  std::array<PointRange, most_rows> rows;
  std::array<std::uint32_t, most_clusters + 1> first_candidate{};
  std::array<std::int32_t, most_points + padding> candidate;  ///< entries of PointRows
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
  /// Lists the points of the rows that lie in the box of their cluster.
  void (*filter)(const PointRows& points, ClusterBlock& block);
  /// Tests each candidate against all tets of its cluster, and lists those that may be in one. What it leaves
  /// out is outside by exact arithmetic, and what it is sure of is inside.
  void (*test)(const PointRows& points, ClusterBlock& block);
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

}  // namespace palpate::simd
