#pragma once

#include <array>
#include <span>

#include <palpate/detection.hpp>

#include "contact/contact_table.hpp"
#include "contact/nearest_surface.hpp"
#include "contact/silhouette.hpp"

namespace palpate {

/// A surface edge with an end in contact near a rim of the body.
struct RimEdge {
  Index edge = -1;
  std::array<Index, 2> contacts{-1, -1};  ///< contacts of its two ends with the body; -1: the end is outside
  /// Its crossing, if an end is outside: the triangle, and the parameter, 0 at the edge's first point.
  Index triangle = -1;
  double parameter = 0.0;
  Index beyond = -1;   ///< triangle on the other side of the silhouette over which it leaves
  double depth = 0.0;  ///< distance by which the edge must move to leave, m
  Vec3 direction;      ///< unit vector along which it must move
};

/// Finds the exits of edges at rims (docs/edges.md). The plane of a point near a rim is not reliable: where
/// faces lie flush, it is the plane of the side face. There, edges determine the directions in which their
/// own body can move. Keeps its memory between searches; use one object for each thread.
class RimEdgeSearch {
 public:
  /// Input of searches.
  struct Frame {
    const Bodies& bodies;
    std::span<const Vec3> positions;
    const ContactTable& table;
    double reach = 0.0;  ///< m; edges deeper than this are left out
  };

  /// Finds the exit of a surface edge at the point of contact `c`. Returns false if no exit is in a direction
  /// in which the edge's own body can move, or if the edge is not inside. O(tets along the edge + triangles,
  /// or tets, nearer than its depth).
  bool find(const Frame& frame, Index c, Index edge, RimEdge& found);

 private:
  bool find_border(const Frame& frame, Index c, const EdgeLine& line, RimEdge& found);
  bool find_link(const Frame& frame, const EdgeLine& line, RimEdge& found);

  SilhouetteSearch silhouettes_;
  ExitSearch faces_;
};

}  // namespace palpate
