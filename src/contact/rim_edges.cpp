#include "contact/rim_edges.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/triangle.hpp"
#include "mesh/faces.hpp"
#include "mesh/outward.hpp"

namespace palpate {
namespace {

/// Before a walk, a point is moved towards the centre of its tet by this fraction of the distance, so that a
/// point on the surface does not walk along it.
constexpr double inwards = 1e-4;

Vec3 moved_inwards(const RimEdgeSearch::Frame& frame, Index contact) {
  const Contacts& contacts = frame.table.contacts();
  const Vec3& p = at(frame.positions, at(contacts.point, contact));
  Vec3 middle;
  for (const Index corner : at(frame.bodies.tets(), at(contacts.tet, contact)))
    middle += 0.25 * at(frame.positions, corner);
  return p + inwards * (middle - p);
}

EdgeLine line_of(const RimEdgeSearch::Frame& frame, Index c, Index edge) {
  const Edge& ends = at(frame.bodies.edges(), edge);
  const Vec3& a = at(frame.positions, ends[0]);
  return {.x = a,
          .d = normalized(at(frame.positions, ends[1]) - a),
          .ends = ends,
          .outward = outward_of_edge(frame.bodies, frame.positions, edge),
          .is_own = frame.bodies.body_of(ends) == at(frame.table.contacts().body, c),
          .slack = frame.reach};
}

/// The exit through the plane of a triangle at which a part of an edge ends that is inside. Without direction
/// if the edge's own body cannot leave there.
LineExit exit_through_face(const RimEdgeSearch::Frame& frame, const EdgeLine& line, Index triangle,
                           double inside) {
  const Vec3 normal = normalized(area_vector(frame.positions, at(frame.bodies.triangles(), triangle)));
  const double along = dot(normal, line.d);
  const Vec3 across = normal - along * line.d;
  const Vec3 direction = normalized(across);
  if (across == Vec3{} || line.allowance(direction) > 0.0) return {frame.reach, {}, -1};
  return {inside * std::abs(along) / length(across), direction, -1};
}

}  // namespace

bool RimEdgeSearch::find(const Frame& frame, Index c, Index edge, RimEdge& found) {
  const Contacts& contacts = frame.table.contacts();
  const Edge& ends = at(frame.bodies.edges(), edge);
  found.edge = edge;
  for (std::size_t i = 0; i < 2; ++i) found.contacts[i] = frame.table.find(ends[i], at(contacts.body, c));
  const EdgeLine line = line_of(frame, c, edge);
  const bool is_link = found.contacts[0] >= 0 && found.contacts[1] >= 0;
  if (!(is_link ? find_link(frame, line, found) : find_border(frame, c, line, found))) return false;
  return found.depth > 0.0 && found.depth <= frame.reach;
}

/// Computes the exit over the silhouette of the face through which the edge leaves, or through this face if
/// that is shorter: where they are almost parallel.
bool RimEdgeSearch::find_border(const Frame& frame, Index c, const EdgeLine& line, RimEdge& found) {
  const Contacts& contacts = frame.table.contacts();
  const Edge& ends = at(frame.bodies.edges(), found.edge);
  const bool first_inside = found.contacts[0] >= 0;
  const Vec3& out = at(frame.positions, ends[first_inside ? 1 : 0]);
  const Vec3 from = moved_inwards(frame, c);
  const double whole = length(out - from);
  const ExitAhead ahead =
      exit_ahead(frame.bodies, frame.positions, at(contacts.tet, c), from, normalized(out - from), whole);
  if (!ahead.leaves()) return false;
  found.triangle = frame.bodies.triangle_of_face(ahead.tet, ahead.opposite);
  for (const Index corner : at(frame.bodies.triangles(), found.triangle))  // of the same body, at the edge
    if (corner == ends[0] || corner == ends[1]) return false;
  const double part = ahead.distance / whole;
  found.parameter = first_inside ? part : 1.0 - part;
  LineExit exit = silhouettes_.nearest(frame.bodies, frame.positions, found.triangle, line, frame.reach);
  // The walk began inside, but the edge itself leaves before, beside this face.
  if (exit.has_left) return false;
  const LineExit through = exit_through_face(frame, line, found.triangle, ahead.distance);
  if (through.distance < exit.distance || exit.direction == Vec3{}) exit = through;
  found.beyond = exit.beyond;
  found.depth = exit.distance;
  found.direction = exit.direction;
  return exit.direction != Vec3{} && line.allowance(exit.direction) == 0.0;
}

/// Computes the exit through the nearest face through which the edge's own body can leave, as seen from the
/// midpoint of the edge.
bool RimEdgeSearch::find_link(const Frame& frame, const EdgeLine& line, RimEdge& found) {
  const Contacts& contacts = frame.table.contacts();
  const Vec3 from = moved_inwards(frame, found.contacts[0]);
  const Vec3 to = moved_inwards(frame, found.contacts[1]);
  const Vec3 middle = 0.5 * (from + to);
  const Index tet =
      faces_.tet_of(frame.bodies, frame.positions, at(contacts.tet, found.contacts[0]), from, middle);
  if (tet < 0) return false;
  const auto across = [&](const Vec3& normal) { return normalized(normal - dot(normal, line.d) * line.d); };
  const SurfacePoint face =
      faces_.nearest_of(frame.bodies, frame.positions, tet, middle, frame.reach, [&](const Vec3& normal) {
        constexpr double clearly = 0.5;  // not almost parallel to the edge
        const Vec3 direction = across(normal);
        return dot(direction, normal) > clearly * length(normal) && line.allowance(direction) == 0.0;
      });
  if (face.outward == Vec3{}) return false;
  found.direction = across(face.outward);
  // Use the distance from the edge itself, which is not exactly on the walk.
  const Vec3 on_edge = 0.5 * (at(frame.positions, at(contacts.point, found.contacts[0])) +
                              at(frame.positions, at(contacts.point, found.contacts[1])));
  found.depth = dot(face.position - on_edge, face.outward) / dot(found.direction, face.outward);
  return true;
}

bool RimEdgeSearch::find_inset(const Frame& frame, Index c, Index edge, double width, const RimFalloff& rims,
                               const SurfaceNormals& normals, Inset& found) {
  // Cosines. Faces above the first are no sides (ExitSearch::distance_to_side).
  constexpr double alike = 0.75;
  constexpr double surely_alike = 0.9;
  constexpr double clearly = 0.1;
  constexpr double surely = 0.5;
  const Contacts& contacts = frame.table.contacts();
  const EdgeLine line = line_of(frame, c, edge);
  found.parameter = at(contacts.point, c) == line.ends[0] ? 1.0 - Inset::beside : Inset::beside;
  const Vec3 x = line.x + found.parameter * (at(frame.positions, line.ends[1]) - line.x);
  const Index tet =
      faces_.tet_of(frame.bodies, frame.positions, at(contacts.tet, c), moved_inwards(frame, c), x);
  if (tet < 0) return false;
  const SurfacePoint face = faces_.nearest(frame.bodies, frame.positions, tet, x, -1, frame.reach, 0.0);
  if (face.outward == Vec3{}) return false;
  found.triangle = frame.bodies.triangle_of_face(face.tet, face.opposite);
  for (const Index corner : at(frame.bodies.triangles(), found.triangle))  // of the same body, at the edge
    if (corner == line.ends[0] || corner == line.ends[1]) return false;
  found.exit = face.position;
  found.direction = normals.at_point_now(frame.positions, found.triangle, found.exit, face.distance);
  found.depth = dot(found.exit - x, found.direction);
  const double like_contact = dot(found.direction, at(contacts.direction, c)) - alike;
  const double away = -dot(found.direction, normalized(line.outward)) - clearly;
  found.scale =
      std::clamp(std::min(like_contact / (surely_alike - alike), away / (surely - clearly)), 0.0, 1.0);
  if (!(found.depth > 0.0 && found.scale > 0.0)) return false;
  found.scale *= rims.fading_scale(frame.bodies, frame.positions, x, tet, found.direction, width, faces_);
  return true;
}

}  // namespace palpate
