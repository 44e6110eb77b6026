#include <algorithm>

#include "geometry/triangle.hpp"
#include "sim/edge_response.hpp"
#include "sim/edge_rows.hpp"
#include "sim/response.hpp"

namespace palpate {

using namespace edge_rows;

namespace {

/// Weight of an inset of an edge from a point with the falloff `inner` to one with the falloff `outer`: what
/// the outer one lacks. It is zero if the edge does not lead away from a rim.
double weight_between(double inner, double outer, double reach, double width) {
  return (1.0 - outer) * std::clamp((inner - outer) * reach / width, 0.0, 1.0);
}

/// 0 to 1: 1 if the contact of a supported point is so deep that borders beside it sink in noticeably.
double sunk(const EdgeResponse::Frame& frame, Index contact) {
  constexpr double full = 0.008;  // of the reach
  const Contacts& contacts = frame.table.contacts();
  const Index own = at(frame.bodies.body_of_point(), at(contacts.point, contact));
  const double reach = std::min(frame.rims.reach(own), frame.rims.reach(at(contacts.body, contact)));
  return std::min(1.0, at(contacts.depth, contact) / (full * reach));
}

}  // namespace

/// Distance from a side at which an inset of an edge has its full force, m.
double EdgeResponse::width_of_inset(const Frame& frame, Index edge, Index body) {
  const auto& [a, b] = at(frame.bodies.edges(), edge);
  return std::min(frame.rims.reach(body),
                  Inset::beside * length(at(frame.positions, b) - at(frame.positions, a)));
}

/// Adds the insets of edges that lead from other contacts with more falloff to this one at a rim.
void EdgeResponse::add_insets(const Frame& frame, std::size_t contact, RimEdgeSearch& search,
                              std::vector<Row>& rows) const {
  const Contacts& contacts = frame.table.contacts();
  const Index point = contacts.point[contact];
  const Index body = contacts.body[contact];
  const double reach = frame.rims.reach(body);
  double outer = -1.0;
  for (const Index edge : frame.bodies.point_edges()[point]) {
    const Index there = frame.table.find(frame.bodies.other_end(edge, point), body);
    // With sides that fade in, the falloff is not smaller, so only one end of an edge can be the outer one.
    if (there < 0 || at(frame.scales, there) <= frame.scales[contact]) continue;
    if (sunk(frame, there) <= least_weight) continue;  // before the walk
    if (outer < 0.0)
      outer = search.scale_of({frame.bodies, frame.positions, frame.table, reach}, contact, frame.rims);
    add_inset(frame, there, edge,
              weight_between(at(frame.scales, there), outer, reach, width_of_inset(frame, edge, body)),
              search, rows);
  }
}

/// Adds the inset of a border edge that leaves near a rim, so that a point that leaves there changes nothing.
/// Its weight falls to zero as the crossing comes to the inset.
/// \param number  of a crossing; the edge is left out unless this is its nearest one
void EdgeResponse::add_inset_of_border_edge(const Frame& frame, std::size_t number, RimEdgeSearch& search,
                                            std::vector<Row>& rows) const {
  const std::span<const Crossing> all = frame.surfaces.crossings->all();
  const Crossing& crossing = all[number];
  if (crossing.parameter <= 1.0 - Inset::beside) return;
  const BorderEdge& border = at(frame.surfaces.border_edges->edges(), crossing.border_edge);
  const double inner = at(frame.scales, border.contact);
  if (inner <= least_weight || sunk(frame, border.contact) <= least_weight) return;
  if (frame.flush.covers(crossing.triangle)) return;
  const auto is_nearer = [&](std::size_t i) {
    return all[i].parameter < crossing.parameter || (all[i].parameter == crossing.parameter && i < number);
  };
  for (std::size_t i = number; i-- > 0 && all[i].border_edge == crossing.border_edge;)
    if (is_nearer(i)) return;
  for (std::size_t i = number + 1; i < all.size() && all[i].border_edge == crossing.border_edge; ++i)
    if (is_nearer(i)) return;
  const Index body = at(frame.table.contacts().body, border.contact);
  if (frame.table.find(border.free_point, body) >= 0) return;  // in another layer
  const Index point = at(frame.table.contacts().point, border.contact);
  const Index edge = *std::ranges::find_if(frame.bodies.point_edges()[point], [&](Index e) {
    return frame.bodies.other_end(e, point) == border.free_point;
  });
  const Vec3& x = at(frame.positions, point);
  const Vec3 leaves = x + crossing.parameter * (at(frame.positions, border.free_point) - x);
  const double reach = frame.rims.reach(body);
  const double outer = search.scale_at({frame.bodies, frame.positions, frame.table, reach}, crossing.triangle,
                                       leaves, frame.rims, *frame.surfaces.normals);
  const double beyond = (crossing.parameter - (1.0 - Inset::beside)) / Inset::beside;
  add_inset(frame, border.contact, edge,
            beyond * weight_between(inner, outer, reach, width_of_inset(frame, edge, body)), search, rows);
}

/// \param contact  of the end away from the rim
/// \param weight   without the falloff of the inset and the support of the bodies
void EdgeResponse::add_inset(const Frame& frame, Index contact, Index edge, double weight,
                             RimEdgeSearch& search, std::vector<Row>& rows) const {
  if (weight <= least_weight || at(frame.bodies.edge_triangles(), edge)[0] < 0) return;
  const Edge& ends = at(frame.bodies.edges(), edge);
  const Index own = frame.bodies.body_of(ends);
  const Index body = at(frame.table.contacts().body, contact);
  weight *= (1.0 - support_.lack(own, body)) * sunk(frame, contact);
  if (weight <= least_weight) return;
  Inset inset;
  if (!search.find_inset({frame.bodies, frame.positions, frame.table, frame.rims.reach(body)}, contact, edge,
                         width_of_inset(frame, edge, body), frame.rims, *frame.surfaces.normals, inset))
    return;
  weight *= inset.scale;
  if (weight <= least_weight || frame.flush.covers(inset.triangle)) return;
  const std::array<Vec3, 3> t = corners_of(frame.positions, at(frame.bodies.triangles(), inset.triangle));
  add_at_triangle(
      frame, ends, {inset.triangle, inset.parameter, weights_in(t, area_vector(t), inset.exit), 0.0, 0.0},
      end_of(edge, body, EdgeEnd::inset, beyond_least(weight) * stiffness_of_an_end(frame, own, body),
             inset.depth, inset.direction),
      rows);
}

}  // namespace palpate
