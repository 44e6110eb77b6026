#pragma once

#include <cstdint>

#include "simd/cluster_query.hpp"

/// The vectorised phases of the edge-triangle query (docs/query.md). Blocks are as in the point query, with
/// clusters of triangles and with edges instead of points.
namespace palpate::simd {

/// Edges in the order of the cells of their midpoints, as structure of arrays: ends a and b, and a name. Each
/// array has `row_padding` places beyond its end.
struct EdgeRows {
  struct End {
    const std::int32_t* x;
    const std::int32_t* y;
    const std::int32_t* z;
  };
  End a;
  End b;
  const std::int32_t* body;  ///< the body whose triangles the edge is tested against
};

/// Lists the edges of the rows that are tested against the cluster's body and whose box meets the cluster's.
void filter_edges(const EdgeRows& edges, ClusterBlock& block);

/// Tests each candidate against all triangles of its cluster. Hits are edges with bits of the triangles that
/// they may meet, and << 16 those that they certainly meet. Pairs that it drops do not meet by exact
/// arithmetic.
/// \param longest  bound of the edges' lengths along an axis
void test_edges(const EdgeRows& edges, std::int32_t longest, ClusterBlock& block);

/// Error bounds of the volumes that test_edges() compares with zero (docs/query.md).
struct CrossingBounds {
  float side;    ///< of the volumes of a triangle and an end
  float volume;  ///< of the volumes of the edge and a side of a triangle
};
/// \param extent   longest side of the cluster's box
/// \param longest  bound of the edges' lengths along an axis
CrossingBounds crossing_bounds(float extent, float longest);

}  // namespace palpate::simd
