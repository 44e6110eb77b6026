#pragma once

#include <cstdint>

#include "simd/cluster_query.hpp"

/// The phases of the edge-triangle query that work on many numbers at a time (docs/query.md). Blocks are
/// those of the point query, with clusters of triangles, and edges in the place of points.
namespace palpate::simd {

/// Edges in the order of the cells of their middles, as arrays of numbers: ends a and b, and a name. Each has
/// `row_padding` places beyond its end.
struct EdgeRows {
  struct End {
    const std::int32_t* x;
    const std::int32_t* y;
    const std::int32_t* z;
  };
  End a;
  End b;
  const std::int32_t* body;  ///< whose triangles the edge is for
};

/// Lists the edges of the rows that are for the body of the cluster and whose box meets that of the cluster.
void filter_edges(const EdgeRows& edges, ClusterBlock& block);

/// Tests each candidate against all triangles of its cluster. Hits are edges that may meet triangles (bits),
/// and << 16 those that surely do. What it leaves out does not meet by exact arithmetic.
/// \param longest  no edge is longer along an axis
void test_edges(const EdgeRows& edges, std::int32_t longest, ClusterBlock& block);

/// Bounds of the errors of what test_edges() compares with zero (docs/query.md).
struct CrossingBounds {
  float side;    ///< of the volumes of a triangle and an end
  float volume;  ///< of the volumes of the edge and a side of a triangle
};
/// \param extent   longest side of the cluster's box
/// \param longest  of the edges, along an axis
CrossingBounds crossing_bounds(float extent, float longest);

}  // namespace palpate::simd
