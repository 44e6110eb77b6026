#include <algorithm>
#include <cmath>

#include "geometry/triangle.hpp"
#include "sim/edge_response.hpp"
#include "sim/edge_rows.hpp"
#include "sim/response.hpp"

namespace palpate {

using namespace edge_rows;

namespace {

/// held_by() for the corners of a triangle and their neighbours, interpolated by barycentric weights.
double held_near(const EdgeResponse::Frame& frame, const Meeting& meeting, Index body, double depth) {
  double held = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Index corner = at(frame.bodies.triangles(), meeting.triangle)[i];
    double most = held_by(frame, frame.table.find(corner, body), depth);
    for (const Index edge : frame.bodies.point_edges()[corner]) {
      const Index neighbor = frame.bodies.other_end(edge, corner);
      most = std::max(most, held_by(frame, frame.table.find(neighbor, body), depth));
    }
    held += meeting.weights[i] * most;
  }
  return held;
}

}  // namespace

/// Adds the rows of an edge contact.
void EdgeResponse::add_edge_contact(const Frame& frame, std::size_t contact, Index number,
                                    std::vector<Row>& rows) const {
  const EdgeContacts& contacts = frame.table.edges();
  const Edge& edge = at(frame.bodies.edges(), contacts.edge[contact]);
  const Index body = contacts.body[contact];
  const double depth = contacts.depth[contact];
  if (!(depth > 0.0)) return;
  const double whole = length(at(frame.positions, edge[1]) - at(frame.positions, edge[0]));
  const auto& [enters, leaves] = contacts.parameters[contact];
  const auto part = [&](double parameters) {
    return std::min(1.0, parameters * whole / frame.rules.rim_reach(body));
  };
  const Index own = frame.bodies.body_of(edge);
  double most = part(leaves - enters);
  if (most > least_weight) most *= sharpness(frame, contacts.edge[contact]);
  if (most <= least_weight) return;
  const auto& [entry, exit] = contacts.triangles[contact];
  if (frame.flush.covers(entry) || frame.flush.covers(exit)) return;
  if (borders_flush_face(frame, contacts.edge[contact])) return;
  std::array<Meeting, 2> meetings;
  for (std::size_t end = 0; end < 2; ++end) {
    meetings[end] = meeting(frame, edge, contacts.triangles[contact][end], contacts.parameters[contact][end],
                            contacts.direction[contact]);
  }
  // Depths are measured from the planes through which the ends enter.
  const double outside = part(enters * meetings[0].steepness) * part((1.0 - leaves) * meetings[1].steepness);
  // As soon as an end is inside, the factor of an edge at a rim applies.
  const double lack = support_.lack(own, body);
  const double beside = lack + (1.0 - lack) * outside;
  const double whole_stiffness = stiffness_of_an_end(frame, own, body);
  for (std::size_t end = 0; end < 2; ++end) {
    const Meeting& here = meetings[end];
    double weight = most * (here.side * beside + (1.0 - here.side) * outside);
    if (weight > least_weight) weight *= 1.0 - held_near(frame, here, own, depth);
    if (weight <= least_weight) continue;
    add_at_triangle(frame, edge, here,
                    end_of(contacts.edge[contact], body, 2 * number + static_cast<Index>(end),
                           beyond_least(weight) * whole_stiffness, depth, contacts.direction[contact]),
                    rows);
  }
}

double EdgeResponse::stiffness_of_an_end(const Frame& frame, Index own, Index body) const {
  return part_of_an_end * support_.softness(own, body) * frame.rules.stiffness(own, body);
}

}  // namespace palpate
