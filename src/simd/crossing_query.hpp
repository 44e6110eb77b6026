#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <palpate/detection.hpp>

#include "simd/fixed_points.hpp"

/// The vectorised phases of the edge-triangle query (docs/query.md): a tree of boxes over the surface
/// triangles, and the test of a star of edges against the triangles that the tree finds.
namespace palpate::simd {

struct FixedBox {
  FixedPoint lower;
  FixedPoint upper;
};

/// A node of the tree: the boxes of up to 16 children. Places without a child have upper ends of -1.
struct BoxGroup {
  static constexpr std::size_t most = 16;
  using Row = std::array<std::int32_t, most>;
  alignas(64) std::array<Row, 3> lower;
  alignas(64) std::array<Row, 3> upper;
};

/// The triangles of a leaf. Entry e of the tree is place e % 64 of leaf e / 64.
struct alignas(64) LeafTriangles {
  static constexpr std::int32_t stride = 64;  ///< numbers in a leaf
  std::array<BoxGroup::Row, 3> corner;        ///< places of points; unused ones repeat the first
  BoxGroup::Row triangle;                     ///< -1 in unused places
};
/// The place of a point among the numbers of all fixed points.
constexpr std::int32_t place_of_point(std::int32_t point) {
  return point * static_cast<std::int32_t>(sizeof(FixedPoint) / sizeof(std::int32_t));
}
static_assert(sizeof(LeafTriangles) == LeafTriangles::stride * sizeof(std::int32_t));

/// Edges with a common point, at which they begin.
struct EdgeStar {
  static constexpr std::size_t most = 16;
  FixedPoint point;
  FixedBox box;        ///< of the edges
  std::int32_t reach;  ///< the longest distance from the point to another end along an axis
  std::size_t size = 0;
  std::array<std::int32_t, most> other;  ///< point at the other end of each edge
  alignas(64) std::array<std::array<float, 4>, most> along;
};

/// What test_star() finds: edges with some entries, one for each lane, of which at least one may be met.
struct StarHits {
  static constexpr std::size_t most_entries = 256;
  struct Hit {
    std::uint32_t place;  ///< first entry * EdgeStar::most + edge of the star
    std::uint32_t lanes;  ///< bits of the entries that the edge may meet
  };
  std::size_t size;
  std::size_t lanes;  ///< of a hit
  float bound;
  std::array<Hit, most_entries * EdgeStar::most> hit;
  /// For each hit and lane: if this is above the bound, the edge meets the triangle for sure.
  alignas(64) std::array<float, most_entries * EdgeStar::most> least;
};

/// The kernels of the query; each does one phase.
struct CrossingKernels {
  /// Places beyond the end of lists that kernels may write.
  static constexpr std::size_t padding = 16;

  /// Computes the boxes of some leaves and of their parent.
  /// \param extents  of each leaf: the longest side of a triangle's box
  void (*fit_leaves)(const FixedPoint* points, std::span<const LeafTriangles> triangles, BoxGroup* leaves,
                     std::int32_t* extents, BoxGroup& parent);
  /// Computes a node from its children.
  void (*fit_parent)(std::span<const BoxGroup> children, BoxGroup& parent);
  /// Lists the children of some nodes whose boxes meet a box; returns their number.
  /// \param first_child  of each node of the level: number of the child in its first place
  std::size_t (*list_children)(const BoxGroup* level, const std::int32_t* first_child,
                               std::span<const std::int32_t> nodes, const FixedBox& box,
                               std::int32_t* children);
  /// Makes a star of the first border edges, as many as have one contact and fit in, but its point.
  void (*gather_star)(const FixedPoint* points, std::span<const BorderEdge> edges, EdgeStar& star);
  /// Tests the edges of a star against the triangles of some entries. Pairs that it drops do not meet by
  /// exact arithmetic.
  /// \param entries  1 to StarHits::most_entries; places beyond their end are written
  /// \param reach    bound of the distances along an axis between the star's point and the other ends of its
  ///                 edges and the corners of the triangles
  void (*test_star)(const FixedPoint* points, const LeafTriangles* triangles, std::span<std::int32_t> entries,
                    const EdgeStar& star, float reach, StarHits& hits);
};

/// The kernels for the best SIMD target of this processor.
CrossingKernels crossing_kernels();

/// Error bound of the volumes that test_star() compares with zero (docs/query.md).
float crossing_bound(float reach);

}  // namespace palpate::simd
