#pragma once

#include <limits>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"
#include "simd/outline_sides.hpp"

namespace palpate {

/// The shortest sideways exit of a straight line from a body.
struct LineExit {
  double distance = 0.0;  ///< m
  Vec3 direction;     ///< unit, across the line: after moving by the distance along it, the line only touches
  Index beyond = -1;  ///< triangle on the other side of the silhouette there
  /// The line passes beside the triangles that were searched, beyond a silhouette over which it can leave.
  /// Not known of a line of the same body, for which silhouettes at its own edge do not count.
  bool has_left = false;
};

/// A straight line that is an edge of another body, or of another part of the same one.
struct EdgeLine {
  Vec3 x;               ///< a point of it
  Vec3 d;               ///< unit
  Edge ends;            ///< its points
  Vec3 outward;         ///< sum of the normals of its body's triangles there
  bool is_own = false;  ///< it is of the body whose silhouette is wanted
  double slack = 0.0;   ///< m, see allowance()

  /// Penalty of an exit along `direction`: `slack` where it does not lead the line's own body
  /// away, since that body lies on the other side.
  [[nodiscard]] double allowance(const Vec3& direction) const {
    constexpr double clearly = 0.1;
    return dot(direction, outward) < -clearly * length(outward) ? 0.0 : slack;
  }
};

/// Finds the nearest part of a body's silhouette, as seen along a line that enters or leaves the body: the
/// edges between triangles that face along the line and triangles that face against it. The triangles that
/// are connected with the one that the line crosses, with the same orientation, are searched in the order of
/// their distance from the line. An exit that the line's own body can follow is preferred, unless it is much
/// longer: where faces lie flush, the nearest silhouette is the common edge. Keeps its memory between
/// searches; one for each thread.
class SilhouetteSearch {
 public:
  SilhouetteSearch() {
    heap_.reserve(256);
    reached_.reserve(256);
  }

  /// The nearest silhouette, with allowances, if below `limit`; else a result without a direction. At most
  /// 256 triangles are searched.
  /// \param triangle  crossed by the line
  ///
  /// O(triangles nearer than the result, squared).
  LineExit nearest(const Bodies& bodies, std::span<const Vec3> positions, Index triangle,
                   const EdgeLine& line, double limit);

 private:
  struct Reached {
    double distance;
    Index triangle;
    Index from;  ///< the triangle from which it was reached
  };
  struct Best {
    LineExit exit;
    double bound = 0.0;                                        ///< its distance and allowance
    double nearest = std::numeric_limits<double>::infinity();  ///< distance of the nearest outline
  };
  void consider(const Bodies& bodies, std::span<const Vec3> positions, const EdgeLine& line,
                const Reached& here, Best& best);
  void consider_outline(std::span<const Vec3> positions, const EdgeLine& line, std::size_t side, Index third,
                        Index beyond, Best& best) const;
  void find_sides(const Bodies& bodies, std::span<const Vec3> positions, const EdgeLine& line,
                  Index triangle);
  [[nodiscard]] Vec3 outward_over(std::span<const Vec3> positions, const EdgeLine& line, std::size_t side,
                                  Index third) const;
  [[nodiscard]] bool has_reached(Index triangle) const;

  bool ahead_ = false;         ///< triangles face along the line
  std::vector<Reached> heap_;  ///< the nearest first
  std::vector<Index> reached_;
  simd::OutlineSides sides_;
};

}  // namespace palpate
