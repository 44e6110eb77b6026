// Contacts of the start of a step that would deepen within it, or leave on the other side, for SweptResponse.
#include <algorithm>
#include <array>
#include <span>

#include "geometry/triangle.hpp"
#include "room.hpp"
#include "sim/swept_response.hpp"

namespace palpate {
namespace {

/// Cosine of the angle between the directions at the start and the end of the step below which a contact
/// leaves on the other side. Over a rim, the direction turns by a right angle.
constexpr double other_side = -0.5;
/// Local thickness, in mean edges of the body, below which the body is thin for its mesh: a thin tool is in
/// contact with few of its points, or none.
constexpr double thin_of_edge = 0.25;

using Vectors = std::array<Vec3, 3>;

/// Three edges of the tet of a coupling.
Vectors edges_of_tet(std::span<const Vec3> positions, const std::array<Index, 5>& points) {
  const Vec3& first = at(positions, points[1]);
  return {at(positions, points[2]) - first, at(positions, points[3]) - first,
          at(positions, points[4]) - first};
}

/// Two edges of the triangle of a coupling, and its unit normal.
Vectors edges_and_normal(std::span<const Vec3> positions, const std::array<Index, 5>& points) {
  const Vec3& first = at(positions, points[2]);
  const Vec3 a = at(positions, points[3]) - first;
  const Vec3 b = at(positions, points[4]) - first;
  return {a, b, normalized(cross(a, b))};
}

/// The direction at the end of a step, if it moves with a tet or triangle as a normal does: its products with
/// the vectors stay. Unchanged where these do not span the space.
Vec3 carried(const Vec3& direction, const Vectors& start, const Vectors& end) {
  const double volume = dot(cross(end[0], end[1]), end[2]);
  const Vec3 moved = dot(direction, start[0]) * cross(end[1], end[2]) +
                     dot(direction, start[1]) * cross(end[2], end[0]) +
                     dot(direction, start[2]) * cross(end[0], end[1]);
  const double size = length(moved);
  return size > 0.0 && volume != 0.0 ? ((volume > 0.0 ? 1.0 : -1.0) / size) * moved : direction;
}

}  // namespace

void SweptResponse::list_ends(std::span<const Vec3> positions, const EdgeContacts& contacts) {
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (contacts.direction[c] == Vec3{}) continue;
    const Edge& edge = at(bodies_.edges(), contacts.edge[c]);
    for (std::size_t end = 0; end < 2; ++end) {
      const Triangle& t = at(bodies_.triangles(), contacts.triangles[c][end]);
      const std::array<Vec3, 3> x = corners_of(positions, t);
      const double s = contacts.parameters[c][end];
      const auto w =
          weights_in(x, area_vector(x), (1.0 - s) * at(positions, edge[0]) + s * at(positions, edge[1]));
      StartEnd& start = start_ends_.emplace_back();
      start.key = {SweptKind::edge_edge, contacts.edge[c],
                   -1 - (2 * contacts.body[c] + static_cast<Index>(end))};
      start.coupling.points = {edge[0], edge[1], t[0], t[1], t[2]};
      start.coupling.coefficients = {1.0 - s, s, -w[0], -w[1], -w[2]};
      start.direction = contacts.direction[c];
      start.depth = contacts.depth[c];
      start.thickness = at(query_.thickness().of_triangle, contacts.triangles[c][end]);
    }
  }
}

/// Lists pairs of bodies whose contacts act softly, since they began deep: their first exits may be wrong.
void SweptResponse::list_soft_pairs(const ContactTable& contacts) {
  soft_pairs_.clear();
  const Contacts& points = contacts.contacts();
  for (std::size_t c = 0; c < points.size(); ++c) {
    if (contacts.states().soft[c] == 0) continue;
    make_room(soft_pairs_, soft_pairs_.size() + 1);
    soft_pairs_.push_back(pair_of(at(bodies_.body_of_point(), points.point[c]), points.body[c]));
  }
  std::ranges::sort(soft_pairs_);
  soft_pairs_.erase(std::ranges::unique(soft_pairs_).begin(), soft_pairs_.end());
}

bool SweptResponse::is_soft(Index point, Index body) const {
  return std::ranges::binary_search(soft_pairs_, pair_of(at(bodies_.body_of_point(), point), body));
}

/// Adds the contacts of the start of the step that would deepen in this step by more than least_motion *
/// thickness, or leave on the other side. The sweep does not find these: their primitives overlap at the
/// start. Edge contacts are read from the detection, since most that are shallow have no law.
void SweptResponse::add_sinking(const PredictedStep& step, const ContactResponse& response,
                                std::span<const fem::Coupling> contacts) {
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (response.is_of_edge(c)) continue;
    const Index body = at(bodies_.body_of_point(), contacts[c].points.back());
    const fem::ContactLaw& law = response.laws()[c];
    add_sinking({{SweptKind::point_triangle, contacts[c].points[0], body},
                 contacts[c],
                 law.direction,
                 law.depth,
                 false,
                 query_.thickness().of_tet({contacts[c].points[1], contacts[c].points[2],
                                            contacts[c].points[3], contacts[c].points[4]})},
                step, response);
  }
  for (const StartEnd& end : start_ends_)
    add_sinking({end.key, end.coupling, end.direction, end.depth, true, end.thickness}, step, response);
}

/// Whether the body is thin there for its mesh.
bool SweptResponse::in_thin(const Start& start, Index body) const {
  return start.thickness < thin_of_edge * at(query_.thickness().mean_edge, body);
}

/// \param row  of the contact at the end of the step
bool SweptResponse::point_reverses(const Start& start, Index row, const PredictedStep& step) {
  const auto& points = start.coupling.points;
  const Vec3 direction =
      carried(start.direction, edges_of_tet(step.start, points), edges_of_tet(step.end, points));
  return dot(at(step.contacts.contacts().direction, row), direction) < other_side;
}

/// Where an edge has several contacts with the body at the end of the step, all must reverse. An edge
/// without contact does not reverse: perhaps one of its points is in contact now. O(log(edge contacts)).
bool SweptResponse::edge_reverses(const Start& start, Index body, const PredictedStep& step) {
  const auto& points = start.coupling.points;
  const EdgeContacts& edges = step.contacts.edges();
  const Vec3 direction =
      carried(start.direction, edges_and_normal(step.start, points), edges_and_normal(step.end, points));
  bool turns = false;
  for (const std::size_t row : rows_of_edge(edges, start.key.first)) {
    if (edges.body[row] != body) continue;
    if (!(dot(edges.direction[row], direction) < other_side)) return false;
    turns = true;
  }
  return turns;
}

/// Whether a contact leaves the body on the other side. Where a body is not thin, the exit of a deep edge may
/// jump, and a contact may end over a rim, although nothing leads through. A contact that is missing at the
/// end may not have been found.
/// \param deeper  it is deeper at the end of the step
bool SweptResponse::leaves(const Start& start, Index body, bool deeper, const PredictedStep& step) const {
  if (is_soft(start.coupling.points[0], body)) return false;
  if (start.of_edge) return in_thin(start, body) && edge_reverses(start, body, step);
  const Index row = step.contacts.find(start.key.first, body);
  return row >= 0 ? point_reverses(start, row, step) : in_thin(start, body) && step.complete && deeper;
}

/// Whether a contact is shallow at the end of the step, and not on the other side: it went around a corner of
/// the body, from one face to the next.
bool SweptResponse::slides_on(const Start& start, Index body, const PredictedStep& step) {
  const double deepest = deepest_edge * start.thickness;
  if (!start.of_edge) {
    const Index row = step.contacts.find(start.key.first, body);
    return row >= 0 && at(step.contacts.contacts().depth, row) <= deepest &&
           !point_reverses(start, row, step);
  }
  const EdgeContacts& edges = step.contacts.edges();
  bool found = false;
  for (const std::size_t row : rows_of_edge(edges, start.key.first)) {
    if (edges.body[row] != body) continue;
    if (edges.depth[row] > deepest) return false;
    found = true;
  }
  return found && !edge_reverses(start, body, step);
}

void SweptResponse::add_sinking(const Start& start, const PredictedStep& step,
                                const ContactResponse& response) {
  const Index body = at(bodies_.body_of_point(), start.coupling.points.back());
  const double margin = margin_of_thickness * start.thickness;
  const double before = dot(start.direction, fem::relative(start.coupling, step.start));
  const double deeper = before - dot(start.direction, fem::relative(start.coupling, step.end));
  const bool sinks = deeper > settings().least_motion * start.thickness && !slides_on(start, body, step);
  // A shallow exit may change its direction by rounding alone.
  const bool through = start.depth > margin && leaves(start, body, deeper > margin, step);
  if (!sinks && !through) return;
  // Kept at its depth, a contact in the middle of a sheet would leave again in the next step.
  const double back = through ? margin : 0.0;
  add(start.key,
      {start.coupling, start.direction, before + back, std::max(deeper, 0.0) + back, margin, start.of_edge},
      step, response);
}

}  // namespace palpate
