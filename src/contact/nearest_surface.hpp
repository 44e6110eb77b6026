#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"
#include "mesh/faces.hpp"

namespace palpate {

/// A point of a body's surface, relative to a point inside the body.
struct SurfacePoint {
  Vec3 position;
  Vec3 outward;  ///< unit vector from the given point to it; the triangle's normal where both are the same
  double distance = 0.0;
  Index tet = -1;            ///< with the face that contains the point; -1: not known
  std::size_t opposite = 4;  ///< corner of the tet opposite this face; 4: not known
};

/// Outward unit normal of a face of a tet; zero where it has no area.
Vec3 face_normal(const Bodies& bodies, std::span<const Vec3> positions, Index tet, std::size_t opposite);

/// Nearest point of a segment.
Vec3 nearest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b);

/// Nearest point of a triangle: the projection onto its plane if that is inside, otherwise a point on the
/// nearest edge.
Vec3 nearest_on_triangle(const Vec3& p, const std::array<Vec3, 3>& triangle);
/// The same on its sides.
Vec3 nearest_on_rim(const Vec3& p, const std::array<Vec3, 3>& triangle);
/// \param normal  cross product of the sides from the first corner
inline Vec3 nearest_on_triangle(const Vec3& p, const std::array<Vec3, 3>& t, const Vec3& normal) {
  const bool inside = squared_length(normal) > 0.0 && dot(cross(t[1] - t[0], p - t[0]), normal) >= 0.0 &&
                      dot(cross(t[2] - t[1], p - t[1]), normal) >= 0.0 &&
                      dot(cross(t[0] - t[2], p - t[2]), normal) >= 0.0;
  if (!inside) return nearest_on_rim(p, t);
  return p + (dot(t[0] - p, normal) / squared_length(normal)) * normal;
}

/// Whether a triangle with this normal has a point nearer than `radius`; its plane must be within `radius`.
/// Agrees with nearest_on_triangle() up to rounding, but needs neither a division nor a root.
bool is_nearer(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& normal, double radius);

/// Finds surface points of a body near a given point. Walks from tet to tet, starting at the tet that
/// contains the point, through all faces that are near enough. Keeps its memory between searches; use one
/// object for each thread.
///
/// If the tets of a body do not overlap, the nearest point found is the nearest of its whole surface, because
/// the straight path to it stays in the body. If they do (tissue folded onto itself), it is the nearest exit
/// of the layer that contains the point, and not the surface of another layer nearby. In self-contact, the
/// tets and triangles at the searching point itself (`without`, otherwise -1) are left out.
class ExitSearch {
 public:
  /// Reserves memory for a search near a surface, so that later steps allocate none.
  ExitSearch() {
    reached_.reserve(512);
    table_.reserve(2048);
  }

  /// The nearest surface point within `radius`; of several, the one found first; if there is none, `outward`
  /// is zero and `distance` is `radius`. Ends at the first one within `enough`. O(tets nearer than the
  /// result).
  SurfacePoint nearest(const Bodies& bodies, std::span<const Vec3> positions, Index tet, const Vec3& p,
                       Index without, double radius, double enough);

  /// The nearest point of those surface faces for which wanted(normal) holds, within `radius`. Its `outward`
  /// is the unit normal of the face; zero if there is no such face. `normal` has any length. O(tets nearer
  /// than the result).
  template <class Wanted>
  SurfacePoint nearest_of(const Bodies& bodies, std::span<const Vec3> positions, Index tet, const Vec3& p,
                          double radius, Wanted&& wanted) {
    SurfacePoint best{p, {}, radius};
    walk(
        bodies, positions, tet, p, -1, [&] { return best.distance; }, wanted,
        [&](Index here, std::size_t opposite, const Vec3& q, double distance) {
          best = {q, face_normal(bodies, positions, here, opposite), distance};
        });
    return best;
  }

  /// Distance of p, a point in `tet`, to the nearest side: a surface triangle whose normal is neither close
  /// to `direction` (cosine above 0.75) nor against it (below -0.3). `radius` if none is nearer. O(tets
  /// nearer than the result).
  /// \param band  > 0: sides fade in. A side whose cosine is nearer to a limit than this counts as farther
  ///     away, by up to the radius at the limit. So the distance is a continuous function of `direction`
  double distance_to_side(const Bodies& bodies, std::span<const Vec3> positions, Index tet, const Vec3& p,
                          const Vec3& direction, double radius, double band = 0.0);

  /// Whether distance_to_side() would still find none within `radius` after each corner has moved by up to
  /// `moved` and `direction` has changed by up to `rotated`. False if this is not certain. O(tets within the
  /// radius).
  [[nodiscard]] bool stays_clear(const Bodies& bodies, std::span<const Vec3> positions, Index tet,
                                 const Vec3& p, const Vec3& direction, double radius, double moved,
                                 double rotated);

  /// The tet that contains x, found from p, a point in `tet`, also where the straight line between them
  /// leaves the body; -1 if no path within the distance of p around x leads to it. O(tets on the line, or
  /// within this distance).
  [[nodiscard]] Index tet_of(const Bodies& bodies, std::span<const Vec3> positions, Index tet, const Vec3& p,
                             const Vec3& x);

  /// Calls found(tet, opposite, nearest point, distance) for each surface face within `radius` of p that the
  /// walk reaches. O(tets within the radius).
  template <class Found>
  void for_each_face(const Bodies& bodies, std::span<const Vec3> positions, Index tet, const Vec3& p,
                     Index without, double radius, Found&& found) {
    walk(
        bodies, positions, tet, p, without, [&] { return radius; }, [](const Vec3&) { return true; }, found);
  }

 private:
  /// Uses only surface faces for which wanted(normal) holds; the length of the normal is twice the area.
  template <class Radius, class Wanted, class Found>
  void walk(const Bodies& bodies, std::span<const Vec3> positions, Index tet, const Vec3& p, Index without,
            Radius&& radius, Wanted&& wanted, Found&& found);
  void start(Index tet);
  [[nodiscard]] bool has_reached(Index tet) const {
    return table_.empty() ? std::find(reached_.begin(), reached_.end(), tet) != reached_.end()
                          : is_in_table(tet);
  }
  [[nodiscard]] bool is_in_table(Index tet) const;
  void add(Index tet);
  void put_in_table(Index tet);
  void grow();

  std::vector<Index> reached_;
  std::vector<Index>
      table_;  ///< hash table (open addressing) of the reached tets, used once they are many; -1: free
};

template <class Radius, class Wanted, class Found>
void ExitSearch::walk(const Bodies& bodies, std::span<const Vec3> positions, Index tet, const Vec3& p,
                      Index without, Radius&& radius, Wanted&& wanted, Found&& found) {
  const auto left_out = [&](const auto& corners) {
    return without >= 0 && std::find(corners.begin(), corners.end(), without) != corners.end();
  };
  start(tet);
  for (std::size_t next = 0; next < reached_.size() && radius() > 0.0; ++next) {
    const Index here = reached_[next];
    const Tet& corners = at(bodies.tets(), here);
    const std::array<Index, 4>& neighbors = at(bodies.tet_neighbors(), here);
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      const Index neighbor = neighbors[opposite];
      if (neighbor >= 0 && has_reached(neighbor)) continue;
      const auto& [i, j, k] = outward_face[opposite];
      const Vec3& a = at(positions, corners[i]);
      const Vec3& b = at(positions, corners[j]);
      const Vec3& c = at(positions, corners[k]);
      const Vec3 normal = cross(b - a, c - a);
      const double to_plane = dot(a - p, normal);  // distance to the plane: a cheap lower bound
      const bool flat = normal == Vec3{};
      if (to_plane * to_plane >= radius() * radius() * squared_length(normal) && !flat) continue;
      if (neighbor >= 0) {
        if (!left_out(at(bodies.tets(), neighbor)) && is_nearer(p, a, b, c, normal, radius())) add(neighbor);
        continue;
      }
      // A face without area: its edges belong to its neighbours too.
      if (flat || left_out(std::array{corners[i], corners[j], corners[k]}) || !wanted(normal)) continue;
      const Vec3 q = nearest_on_triangle(p, {a, b, c});
      const double distance = length(q - p);
      if (distance < radius()) found(here, opposite, q, distance);
    }
  }
}

/// The end of a straight walk in a body.
struct ExitAhead {
  Index tet = -1;            ///< tet in which it ends, or from which it leaves the body; -1: the walk is lost
  std::size_t opposite = 4;  ///< corner opposite the face through which it leaves; 4: it ends inside
  double distance = 0.0;     ///< m
  [[nodiscard]] bool leaves() const { return opposite < 4; }
};
/// Follows the straight line from p, a point in `tet`, along the unit vector `direction`, over the length
/// `most` or until it leaves the body. O(tets on the line).
ExitAhead exit_ahead(const Bodies& bodies, std::span<const Vec3> positions, Index tet, const Vec3& p,
                     const Vec3& direction, double most);
/// Distance to the surface along the straight line from p, a point in `tet`, in the unit direction
/// `direction`: an upper bound of the distance to the nearest surface point. Infinite if the walk is lost.
/// O(tets on the line).
double surface_ahead(const Bodies& bodies, std::span<const Vec3> positions, Index tet, const Vec3& p,
                     const Vec3& direction);

/// Nearest surface point of a whole body, without the triangles at the point `without`. The distance is
/// infinite if there is none. O(triangles of the body).
SurfacePoint nearest_surface_point(const Bodies& bodies, std::span<const Vec3> positions, Index body,
                                   const Vec3& p, Index without = -1);

}  // namespace palpate
