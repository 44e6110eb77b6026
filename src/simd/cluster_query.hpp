#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "simd/cluster.hpp"
#include "simd/fixed_points.hpp"

/// The vectorised phases of the clustered query (docs/query.md).
namespace palpate::simd {

/// The box of a cluster. Points in the box count, except those with a name in [lower.name, upper.name]. With
/// `skips_marked`, points with a marked name do not count either.
struct ClusterBox {
  FixedPoint lower;
  FixedPoint upper;
  std::int32_t skips_marked;  ///< 0: no; -1: yes
};

/// Whether points of the cluster's own body count. They include the corners of its tets.
inline bool includes_own(const ClusterBox& box) {
  return box.upper.name < box.lower.name;
}

/// Longest side of a box.
inline float extent_of(const ClusterBox& box) {
  return static_cast<float>(
      std::max({box.upper.x - box.lower.x, box.upper.y - box.lower.y, box.upper.z - box.lower.z}));
}

/// Grows a box on all sides; coordinates stay >= 0.
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

/// Points [begin, end) in the order of cells.
struct PointRange {
  std::uint32_t begin;
  std::uint32_t end;
};

/// Work of a block of clusters, and its results. The caller cuts blocks so that no array overflows.
struct ClusterBlock {
  static constexpr std::size_t most_clusters = 32;
  static constexpr std::size_t most_rows = 1024;
  static constexpr std::size_t most_points = 4096;
  static constexpr std::size_t padding = 16;  ///< kernels may write this many entries beyond the reported end

  /// A point and the cluster's tets, as bits: the tets that may contain the point, and in the upper 16 bits
  /// those that certainly do. Tets with the point as a corner are left out.
  struct Hit {
    std::int32_t entry;     ///< index of the tested point
    std::uint32_t cluster;  ///< index of the cluster in the block
    std::uint32_t primitives;
  };

  /// Number of pairs of a candidate and a primitive of its cluster after the filter.
  [[nodiscard]] std::size_t pairs() const {
    std::size_t sum = 0;
    for (std::size_t c = 0; c < clusters; ++c)
      sum += std::size_t{first_candidate[c + 1] - first_candidate[c]} * cluster[c]->size;
    return sum;
  }

  std::size_t clusters = 0;
  std::array<const Cluster*, most_clusters> cluster;
  const std::uint16_t* at_point = nullptr;  ///< Clusters::at_point; used only where includes_own()
  alignas(64) std::array<std::array<FixedPoint, Cluster::most_points>, most_clusters> corners;
  std::array<ClusterBox, most_clusters> box;
  std::uint32_t strays = 0;  ///< bit c: rows of cluster c may hold points of cells outside its box
  std::array<std::uint32_t, most_clusters + 1>
      first_row{};  ///< rows of cluster c are [first_row[c], first_row[c + 1])
  std::array<PointRange, most_rows> rows;
  std::array<std::uint32_t, most_clusters + 1> first_candidate{};
  const std::int32_t* candidates;                             ///< at most most_points
  std::array<std::int32_t, most_points + padding> candidate;  ///< memory for them
  std::size_t hits = 0;
  std::array<Hit, most_points + 1> hit;
};

/// The kernels of the query; each does one phase.
struct ClusterKernels {
  /// Fetches the corners of each cluster of the block and their box (all but the names).
  /// \param points       all points, by index
  /// \param point_lists  Clusters::points; see Cluster::first_point
  void (*load)(std::span<const FixedPoint> points, std::span<const std::int32_t> point_lists,
               ClusterBlock& block);
  /// Lists those points of the rows that lie in the box of their cluster. The box must be rounded out to
  /// coarse coordinates.
  void (*filter)(const PointRows& points, ClusterBlock& block);
  /// Tests each candidate against all tets of its cluster, and lists the candidates that may be in one. Pairs
  /// that are dropped are outside by exact arithmetic; pairs marked as certain are inside.
  void (*test)(const FixedPoint* points, ClusterBlock& block);
  /// As `test`, but allows for motion: lists the tets that may contain a candidate after all points have
  /// moved by up to `margin` in each coordinate. The boxes must contain all positions that points can reach.
  void (*near)(const FixedPoint* points, std::int32_t margin, ClusterBlock& block);
  /// Fetches the corners of each cluster of the block, without their box.
  void (*gather)(std::span<const FixedPoint> points, std::span<const std::int32_t> point_lists,
                 ClusterBlock& block);
  /// Whether all tets of the block certainly have a positive volume.
  bool (*upright)(const ClusterBlock& block);
};

/// The kernels for the best SIMD target of this processor.
ClusterKernels cluster_kernels();
namespace scalar {
/// The kernels above in plain C++.
ClusterKernels cluster_kernels();
}  // namespace scalar

/// Bound of the error of the volumes that `test` compares with zero, for all tets of a cluster
/// (docs/query.md).
/// \param extent  longest side of the cluster's box
inline float volume_bound(float extent) {
  constexpr float u = 0x1p-24F;
  constexpr float slack = 1.001F;  // allows for the rounding of the bound itself
  const float coordinate = 0.51F + u * extent;
  const float edge = 2.0F * coordinate + 1.01F * u * extent;
  const float normal = 4.0F * extent * edge + 2.0F * edge * edge + 4.1F * u * extent * extent;
  return slack *
         (3.1F * normal * (extent + 1.1F) + (12.1F * coordinate + 54.0F * u * extent) * extent * extent);
}

/// By how much `near` moves the planes of a tet outwards, for a unit 1-norm of the normal, if points move by
/// up to `margin`. It covers the motion of two points and the rounding of their coordinates.
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
