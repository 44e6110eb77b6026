#pragma once

#include <array>
#include <span>

#include <palpate/detection.hpp>

#include "contact/contact_table.hpp"
#include "contact/nearest_surface.hpp"
#include "contact/rim_falloff.hpp"
#include "contact/silhouette.hpp"
#include "contact/surface_normals.hpp"

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

/// A position on a surface edge beside a rim of the body, and its exit.
struct Inset {
  /// Distance from the end at the rim, as a fraction of the edge.
  static constexpr double beside = 0.25;
  double parameter = 0.0;  ///< of the position, 0 at the edge's first point
  Index triangle = -1;     ///< through which it leaves
  Vec3 exit;               ///< nearest point of the triangle
  double depth = 0.0;      ///< m
  Vec3 direction;          ///< unit normal of the surface at the exit, interpolated
  /// 0 to 1: the rim falloff, times factors that are zero if the direction is not like that of the contact or
  /// if the edge's own body cannot move along it.
  double scale = 0.0;
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
  /// Finds the exit of an inset of a surface edge that leads from the point of contact `c` to a rim. It is
  /// through the nearest face. Returns false if there is none within reach, if its scale is zero, or if the
  /// inset is not inside. O(tets along the edge + tets nearer than the reach).
  /// \param width  distance from a side at which the falloff of the inset ends, m
  bool find_inset(const Frame& frame, Index c, Index edge, double width, const RimFalloff& rims,
                  const SurfaceNormals& normals, Inset& found);
  /// Rim falloff of a contact, and of one that leaves at a crossing of its edge with a triangle; with sides
  /// that fade in. O(tets within reach).
  [[nodiscard]] double scale_of(const Frame& frame, std::size_t contact, const RimFalloff& rims) {
    const Contacts& contacts = frame.table.contacts();
    return rims.fading_scale(frame.bodies, frame.positions, at(frame.positions, contacts.point[contact]),
                             contacts.tet[contact], contacts.direction[contact], frame.reach, faces_);
  }
  [[nodiscard]] double scale_at(const Frame& frame, Index triangle, const Vec3& crossing,
                                const RimFalloff& rims, const SurfaceNormals& normals) {
    return rims.fading_scale(
        frame.bodies, frame.positions, crossing, at(frame.bodies.triangle_tets(), triangle),
        normals.at_point_now(frame.positions, triangle, crossing, SurfaceNormals::far), frame.reach, faces_);
  }

 private:
  bool find_border(const Frame& frame, Index c, const EdgeLine& line, RimEdge& found);
  bool find_link(const Frame& frame, const EdgeLine& line, RimEdge& found);

  SilhouetteSearch silhouettes_;
  ExitSearch faces_;
};

}  // namespace palpate
