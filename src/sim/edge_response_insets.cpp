#include <algorithm>

#include "geometry/triangle.hpp"
#include "sim/edge_response.hpp"
#include "sim/edge_rows.hpp"
#include "sim/response.hpp"

namespace palpate {

using namespace edge_rows;

/// Adds the insets of edges that lead from other contacts with more falloff to this one at a rim.
void EdgeResponse::add_insets(const Frame& frame, std::size_t contact, RimEdgeSearch& search,
                              std::vector<Row>& rows) const {
  const Contacts& contacts = frame.table.contacts();
  const Index point = contacts.point[contact];
  const Index body = contacts.body[contact];
  const double scale = search.scale_of({frame.bodies, frame.positions, frame.table, frame.rims.reach(body)},
                                       contact, frame.rims);
  for (const Index edge : frame.bodies.point_edges()[point]) {
    const Index there = frame.table.find(frame.bodies.other_end(edge, point), body);
    if (there >= 0) add_inset(frame, there, edge, at(frame.scales, there) - scale, search, rows);
  }
}

/// Adds the inset of a border edge that leaves near a rim, so that a point that leaves there changes nothing.
/// Its weight falls to zero as the crossing comes to the inset. \param crossing  the edge is left out unless
/// this is its first crossing, and all are beyond the inset
void EdgeResponse::add_inset_of_border_edge(const Frame& frame, std::size_t crossing, RimEdgeSearch& search,
                                            std::vector<Row>& rows) const {
  const std::span<const Crossing> all = frame.surfaces.crossings->all();
  const Crossing& first = all[crossing];
  if (crossing > 0 && all[crossing - 1].border_edge == first.border_edge) return;
  for (std::size_t i = crossing; i < all.size() && all[i].border_edge == first.border_edge; ++i)
    if (all[i].parameter < 1.0 - Inset::beside) return;
  const BorderEdge& border = at(frame.surfaces.border_edges->edges(), first.border_edge);
  const double scale = at(frame.scales, border.contact);
  if (scale <= least_weight || frame.flush.covers(first.triangle)) return;
  const Index point = at(frame.table.contacts().point, border.contact);
  const std::span<const Index> edges = frame.bodies.point_edges()[point];
  const Index edge = *std::ranges::find_if(
      edges, [&](Index e) { return frame.bodies.other_end(e, point) == border.free_point; });
  const Index body = at(frame.table.contacts().body, border.contact);
  const Vec3& x = at(frame.positions, point);
  const Vec3 leaves = x + first.parameter * (at(frame.positions, border.free_point) - x);
  const double there = search.scale_at({frame.bodies, frame.positions, frame.table, frame.rims.reach(body)},
                                       first.triangle, leaves, frame.rims, *frame.surfaces.normals);
  const double beyond = (first.parameter - (1.0 - Inset::beside)) / Inset::beside;
  add_inset(frame, border.contact, edge, beyond * (scale - there), search, rows);
}

/// \param contact  of the end away from the rim
/// \param weight   without the falloff of the inset and the support of the bodies
void EdgeResponse::add_inset(const Frame& frame, Index contact, Index edge, double weight,
                             RimEdgeSearch& search, std::vector<Row>& rows) const {
  if (weight <= least_weight || at(frame.bodies.edge_triangles(), edge)[0] < 0) return;
  const Edge& ends = at(frame.bodies.edges(), edge);
  const Index own = frame.bodies.body_of(ends);
  const Index body = at(frame.table.contacts().body, contact);
  weight *= 1.0 - support_.lack(own, body);
  if (weight <= least_weight) return;
  Inset inset;
  if (!search.find_inset({frame.bodies, frame.positions, frame.table, frame.rims.reach(body)}, contact, edge,
                         frame.rims, *frame.surfaces.normals, inset))
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
