#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"

namespace palpate {

/// Surface triangles of bodies at rest that lie flush on another such body: two slabs side by side, which
/// make one floor. No exit leads through them, and their border is no rim of the floor.
class FlushFaces {
 public:
  FlushFaces() = default;
  /// O(triangles and tets of bodies whose boxes overlap, log).
  /// \param still      (n_bodies) 1: rigid, and does not move
  /// \param positions  (n_points x 3), m
  FlushFaces(const Bodies& bodies, std::span<const std::uint8_t> still, std::span<const Vec3> positions);

  /// Whether a triangle lies flush, with all its corners.
  [[nodiscard]] bool covers(Index triangle) const {
    return !triangles_.empty() && at(covered_, triangle) != 0;
  }
  /// Whether a straight exit of a body leads through such a triangle of it. O(flush triangles of the body).
  [[nodiscard]] bool leads_through(const Bodies& bodies, std::span<const Vec3> positions, Index body,
                                   const Vec3& from, const Vec3& direction, double depth) const;

 private:
  std::vector<std::uint8_t> covered_;  ///< (n_triangles)
  std::vector<Index> triangles_;       ///< that are covered, ascending
};

}  // namespace palpate
