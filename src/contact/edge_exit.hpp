#pragma once

#include <span>

#include <palpate/detection.hpp>
#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"

namespace palpate {

/// Weight of a neighbour's plane, times 1 / (length of the edge)^2; the weight of a crossing at the free end
/// of an edge is the same, so that depth is continuous when the free end enters the body.
inline constexpr double link_weight = 0.1;

/// The exit from a body along a border edge: the weighted planes of its crossings.
///
/// One crossing is the usual case. An edge that leaves, enters and leaves again has several, two of which
/// appear or vanish together where it touches the surface. So exits count by max(0, n . e), entries against
/// them by the same: the two cancel at the touch, and depth is continuous. Exits near the free end count
/// more, times 1 / (1 - parameter): an edge that has just become a border edge leaves there, even if it
/// passed other crossings.
struct EdgeExit {
  EdgeExit() = default;
  /// \param edge       from the point in contact to the free end
  /// \param crossings  of this edge, one or more
  /// \param normals    of the surface at the crossings
  EdgeExit(const Bodies& bodies, std::span<const Vec3> positions, const Vec3& edge,
           std::span<const Crossing> crossings, std::span<const Vec3> normals);

  /// Parameter below which a crossing is at the point itself, up to rounding.
  static constexpr double here = 1e-15;

  /// Sum over the crossings of fraction * (1 / parameter^2 - 1 + link_weight); 1 if at_point.
  double weight = 0.0;
  double depth = 0.0;     ///< weighted sum of distances to the planes
  Vec3 normal;            ///< weighted sum of normals
  double nearest = 1.0;   ///< parameter of the nearest crossing
  double distance = 0.0;  ///< of the nearest crossing from p
  bool at_point = false;  ///< a crossing is at p itself; others are ignored

 private:
  void add_all(const Bodies& bodies, std::span<const Vec3> positions, const Vec3& edge,
               std::span<const Crossing> crossings, std::span<const Vec3> normals);
  void add(const Vec3& edge, const Crossing& crossing, const Vec3& surface_normal, double fraction);
};

}  // namespace palpate
