#include <algorithm>
#include <array>

#include "contact/nearest_surface.hpp"
#include "geometry/triangle.hpp"
#include "sim/edge_response.hpp"
#include "sim/edge_rows.hpp"
#include "sim/response.hpp"

namespace palpate {

using namespace edge_rows;

namespace {

/// 0 to 1: 1 for an edge with a crease of 60 degrees or more, 0 below 30 degrees.
double crease(const EdgeResponse::Frame& frame, Index edge) {
  constexpr double none = 0.866;  // cosines
  constexpr double surely = 0.5;
  const auto& [first, second] = at(frame.bodies.edge_triangles(), edge);
  if (second < 0) return 1.0;
  const auto normal = [&](Index t) {
    return normalized(area_vector(frame.positions, at(frame.bodies.triangles(), t)));
  };
  return std::clamp((none - dot(normal(first), normal(second))) / (none - surely), 0.0, 1.0);
}

/// Factor of the force at an end in contact: zero if it has just entered through a face along the direction.
/// It had no force there before it entered, whatever the depth of the edge.
double entered(const EdgeResponse::Frame& frame, Index contact, const RimEdge& edge) {
  constexpr double surely = 0.25;  // of the depth of the edge
  const Contacts& contacts = frame.table.contacts();
  const Vec3& x = at(frame.positions, at(contacts.point, contact));
  const double most = surely * edge.depth;
  const ExitAhead ahead =
      exit_ahead(frame.bodies, frame.positions, at(contacts.tet, contact), x, edge.direction, most);
  if (!ahead.leaves()) return 1.0;
  const Vec3 normal = frame.surfaces.normals->at_point_now(
      frame.positions, frame.bodies.triangle_of_face(ahead.tet, ahead.opposite),
      x + ahead.distance * edge.direction, SurfaceNormals::far);
  const double side = side_of(dot(normal, edge.direction));
  return side + (1.0 - side) * ahead.distance / most;
}

/// Whether an edge leaves, or its exit leads, through a face that lies flush on another body.
bool is_at_seam(const EdgeResponse::Frame& frame, Index body, const RimEdge& found) {
  if (found.triangle >= 0 && frame.flush.covers(found.triangle)) return true;
  if (borders_flush_face(frame, found.edge)) return true;
  if (found.triangle >= 0) return found.beyond >= 0 && frame.flush.covers(found.beyond);
  const auto& [first, second] = at(frame.bodies.edges(), found.edge);
  const Vec3& a = at(frame.positions, first);
  const Vec3 along = at(frame.positions, second) - a;
  return std::ranges::any_of(std::array{0.0, 0.5, 1.0}, [&](double part) {
    return frame.flush.leads_through(frame.bodies, frame.positions, body, a + part * along, found.direction,
                                     found.depth);
  });
}

}  // namespace

/// Adds the edges of a contact at a rim. An edge between two such contacts is added for the lower point.
void EdgeResponse::add_rim_edges(const Frame& frame, std::size_t contact, RimEdgeSearch& search,
                                 std::vector<Row>& rows) const {
  const Contacts& contacts = frame.table.contacts();
  const Index point = contacts.point[contact];
  const Index body = contacts.body[contact];
  const RimEdgeSearch::Frame places{frame.bodies, frame.positions, frame.table, frame.rules.rim_reach(body)};
  for (const Index edge : frame.bodies.point_edges()[point]) {
    if (at(frame.bodies.edge_triangles(), edge)[0] < 0) continue;
    const Index other = frame.bodies.other_end(edge, point);
    const Index there = frame.table.find(other, body);
    const bool at_rim = frame.scales[contact] < 1.0;
    if (there >= 0 && (other < point || !at_rim || at(frame.scales, there) >= 1.0)) continue;
    RimEdge found;
    if (search.find(places, static_cast<Index>(contact), edge, found)) add_rim_edge(frame, body, found, rows);
  }
}

void EdgeResponse::add_rim_edge(const Frame& frame, Index body, const RimEdge& found,
                                std::vector<Row>& rows) const {
  const Contacts& contacts = frame.table.contacts();
  const Edge& edge = at(frame.bodies.edges(), found.edge);
  const Index own = frame.bodies.body_of(edge);
  const double whole = length(at(frame.positions, edge[1]) - at(frame.positions, edge[0]));
  double inside = 1.0;
  if (found.triangle >= 0) inside = found.contacts[0] >= 0 ? found.parameter : 1.0 - found.parameter;
  const double length_part = std::min(1.0, inside * whole / frame.rules.rim_reach(body));
  double held = 0.0;
  for (const Index c : found.contacts) held = std::max(held, held_by(frame, c, found.depth));
  double most = (1.0 - held) * support_.lack(own, body) * length_part;
  if (most > least_weight) most *= sharpness(frame, found.edge);
  const bool at_rim =
      std::ranges::any_of(found.contacts, [&](Index c) { return c >= 0 && at(frame.scales, c) < 1.0; });
  if (!at_rim) most *= crease(frame, found.edge);
  if (most <= least_weight || is_at_seam(frame, body, found)) return;
  const double whole_stiffness = stiffness_of_an_end(frame, own, body);
  for (std::size_t i = 0; i < 2; ++i) {
    const Index c = found.contacts[i];
    Meeting here{};
    if (c < 0) here = meeting(frame, edge, found.triangle, found.parameter, found.direction);
    const double weight = most * (c < 0 ? here.side : entered(frame, c, found));
    EdgeEnd end = end_of(found.edge, body, static_cast<Index>(i), beyond_least(weight) * whole_stiffness,
                         found.depth, found.direction);
    if (!(end.law.stiffness > 0.0)) continue;
    if (c < 0) {
      add_at_triangle(frame, edge, here, end, rows);
      continue;
    }
    const fem::Coupling coupling = coupling_of(
        at(contacts.point, c), at(frame.bodies.tets(), at(contacts.tet, c)), at(contacts.weights, c));
    end.points = coupling.points;
    end.coefficients = coupling.coefficients;
    end.of_edge = false;
    rows.push_back({.end = end, .depth = end.law.depth});
  }
}

}  // namespace palpate
